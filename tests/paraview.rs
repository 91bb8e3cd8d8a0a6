//! Goal: what a run writes is what ParaView shows. VTK's own readers, the ones in ParaView, read the frames of a short
//! Taylor impact; times, cells, fields and values are compared with the history and the summary of the run.
//!
//! Needs Python with the package `vtk`; without it the test says that it was skipped.

use serde_json::Value;
use std::path::Path;
use std::process::Command;

#[test]
fn vtk_reads_the_frames_of_a_taylor_impact_as_they_were_written() {
    let has_vtk = Command::new("python3").args(["-c", "import vtk"]).output().is_ok_and(|out| out.status.success());
    if !has_vtk {
        eprintln!("skipped: Python's package vtk is not installed (pip install vtk)");
        return;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let directory = tempfile::tempdir().unwrap();
    let results = directory.path().join("results");
    let run = Command::new(env!("CARGO_BIN_EXE_estar"))
        .arg("run")
        .arg(root.join("meshes/taylor/taylor.toml"))
        .args(["--quiet", "--set", "time.end=\"4 us\"", "--set", "output.frames=4", "--set", "expect=[]"])
        .arg("--output")
        .arg(&results)
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));

    let script = root.join("tests/read_results.py");
    let read = Command::new("python3").arg(script).arg(&results).output().unwrap();
    assert!(read.status.success(), "{}", String::from_utf8_lossy(&read.stderr));
    let frames: Vec<Value> = serde_json::from_slice(&read.stdout).unwrap();
    let summary: Value = serde_json::from_slice(&std::fs::read(results.join("summary.json")).unwrap()).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();

    // t = 0, four frames, the last of which is the end
    assert_eq!(frames.len(), 5);
    assert_eq!(frames.len() as u64, summary["frames"].as_u64().unwrap());
    for frame in &frames {
        assert_eq!(frame["listed_time"], frame["time"]);
        assert_eq!((&frame["points"], &frame["cells"]), (&summary["mesh"]["nodes"], &summary["mesh"]["elements"]));
        assert_eq!(frame["only_hexahedra"], true);
        for field in ["displacement", "velocity", "node_id"] {
            assert!(frame["node_fields"].as_array().unwrap().contains(&field.into()), "{field}");
        }
        for field in ["cauchy_stress", "equivalent_plastic_strain", "element_id", "part", "volume_ratio"] {
            assert!(frame["cell_fields"].as_array().unwrap().contains(&field.into()), "{field}");
        }
        // labels of the mesh file, each once
        assert_eq!(frame["node_ids"], serde_json::json!([1, 2, summary["mesh"]["nodes"]]));
        assert_eq!(frame["element_ids"], summary["mesh"]["elements"]);
        assert!((number(&frame["reference_length"]) - 0.0324).abs() < 1e-15);
        // the stress components stand in the order that ParaView names them in
        assert!(number(&frame["mises_error"]) <= 1e-9 * number(&frame["largest_mises"]));
        assert!(number(&frame["pressure_error"]) <= 1e-6);
    }
    let (first, last) = (&frames[0], &frames[4]);
    assert_eq!(number(&first["time"]), 0.0);
    assert!((number(&first["lowest_velocity"]) + 227.0).abs() < 1e-12 * 227.0);
    assert_eq!(number(&first["largest_plastic_strain"]), 0.0);
    assert_eq!(last["time"], summary["time"]);
    assert_eq!(number(&last["length"]), number(&summary["probes"]["length"]));
    let largest = number(&summary["extremes"]["max_equivalent_plastic_strain"]);
    let of_cells = number(&last["largest_plastic_strain"]);
    assert!(of_cells > 0.1 * largest && of_cells <= largest, "{of_cells} {largest}");
}
