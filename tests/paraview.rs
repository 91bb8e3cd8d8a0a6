//! Goal: what a run writes is what ParaView shows. VTK's own readers, the ones in ParaView, read the frames of a short
//! Taylor impact; times, cells, fields and values are compared with the history and the summary of the run. The expression for
//! principal stresses of `docs/paraview.md` is evaluated by the functions of VTK that ParaView's Python Calculator has.
//!
//! Needs Python with the package `vtk`; without it the tests say that they were skipped.

use serde_json::Value;
use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn has_vtk() -> bool {
    let has_vtk = Command::new("python3").args(["-c", "import vtk"]).output().is_ok_and(|out| out.status.success());
    if !has_vtk {
        eprintln!("skipped: Python's package vtk is not installed (pip install vtk)");
    }
    has_vtk
}

/// Results of the first microseconds of a Taylor impact.
fn taylor_impact(results: &Path) {
    let run = Command::new(env!("CARGO_BIN_EXE_estar"))
        .arg("run")
        .arg(root().join("meshes/taylor/taylor.toml"))
        .args(["--quiet", "--set", "time.end=\"4 us\"", "--set", "output.frames=4", "--set", "expect=[]"])
        .arg("--output")
        .arg(results)
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
}

/// What a script beside this file prints.
fn printed_by(script: &str, arguments: &[&OsStr]) -> Value {
    let script = root().join("tests").join(script);
    let printed = Command::new("python3").arg(script).args(arguments).output().unwrap();
    assert!(printed.status.success(), "{}", String::from_utf8_lossy(&printed.stderr));
    serde_json::from_slice(&printed.stdout).unwrap()
}

#[test]
fn vtk_reads_the_frames_of_a_taylor_impact_as_they_were_written() {
    if !has_vtk() {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let results = directory.path().join("results");
    taylor_impact(&results);
    let printed = printed_by("read_results.py", &[results.as_os_str()]);
    let frames = printed.as_array().unwrap();
    let summary: Value = serde_json::from_slice(&std::fs::read(results.join("summary.json")).unwrap()).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();

    // t = 0, four frames, the last of which is the end
    assert_eq!(frames.len(), 5);
    assert_eq!(frames.len() as u64, summary["frames"].as_u64().unwrap());
    for frame in frames {
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
        assert_eq!(frame["parts"], serde_json::json!([1]));
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

#[test]
fn the_recipe_for_principal_stresses_gives_them_in_vtk() {
    let page = std::fs::read_to_string(root().join("docs/paraview.md")).unwrap();
    let (_, after) = page.split_once("`eigenvalue(").expect("the recipe for principal stresses");
    let expression = format!("eigenvalue({}", after.split_once('`').unwrap().0);
    if !has_vtk() {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    taylor_impact(directory.path());
    let frame = directory.path().join("fields/frame_00004.vtu");
    let found = printed_by("principal_stresses.py", &[frame.as_os_str(), OsStr::new(&expression)]);
    let number = |name: &str| found[name].as_f64().unwrap();
    let largest = number("largest");
    assert!(number("cells") > 3000.0 && largest > 400e6, "{found}");
    assert_eq!(found["falling"], true);
    // of rounding
    assert!(number("pressure_error") <= 1e-14 * largest && number("mises_error") <= 1e-13 * largest, "{found}");
    assert!(number("determinant_error") <= 1e-13 * largest.powi(3), "{found}");
}
