//! Prints how long a mesh of a million hexes takes to write and read, and a frame of it to write, against the time a
//! plain copy of the same bytes takes. Not measured: a disk that is slower than the system's file cache.
//!
//! `cargo run --release -p estar-io --example io_rates -- FOLDER`

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use estar_io::{Field, FieldData, Frame, Grid, ResultWriter, read_mesh, write_gmsh_file};
use estar_mesh::generate::{BoxSpec, box_mesh};
use estar_mesh::locality_order;
use estar_mesh::quality::QualityReport;

fn timed<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    println!("{what:<40} {:8.3} s", start.elapsed().as_secs_f64());
    result
}

fn report(path: &Path) -> Result<(), Box<dyn Error>> {
    let copy = path.with_extension("copy");
    timed(&format!("copy {:.1} MB", fs::metadata(path)?.len() as f64 / 1e6), || fs::copy(path, &copy))?;
    Ok(fs::remove_file(copy)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("give a folder to write to")?);
    fs::create_dir_all(&folder)?;
    let mesh = timed("generate 1,000,000 hexes", || BoxSpec::new([1.0; 3], [100; 3]).map(|spec| box_mesh(&spec)))?;
    for (binary, name) in [(true, "binary.msh"), (false, "text.msh")] {
        let path = folder.join(name);
        timed(&format!("write {name}"), || write_gmsh_file(&path, &mesh, binary))?;
        let read = timed(&format!("read {name}"), || read_mesh(&path))?;
        // which has the group of all elements, too
        assert!(read.mesh.elements() == mesh.elements() && read.mesh.coordinates() == mesh.coordinates());
        report(&path)?;
    }
    let order = timed("locality order", || locality_order(&mesh));
    let mesh = timed("renumber", || mesh.renumbered(&order));
    timed("quality", || QualityReport::new(&mesh));

    let waves = |count: usize| (0..count).map(|k| (k as f64 * 1e-3).sin()).collect::<Vec<f64>>();
    let (velocity, stress, strain) =
        (waves(3 * mesh.node_count()), waves(6 * mesh.element_count()), waves(mesh.element_count()));
    let labels: Vec<i64> = mesh.element_labels().iter().map(|label| label.0 as i64).collect();
    let unchanging = [Field { name: "label", components: 1, data: FieldData::I64(&labels) }];
    let grid = timed("compress the grid", || Grid::new(mesh.node_count(), mesh.elements(), &[], &unchanging))?;
    let mut writer = ResultWriter::create(&folder)?;
    for time in [0.0, 1.0] {
        let frame = Frame {
            time,
            grid: &grid,
            points: FieldData::F64(mesh.coordinates().as_flattened()),
            node_fields: vec![Field { name: "velocity", components: 3, data: FieldData::F64(&velocity) }],
            cell_fields: vec![
                Field { name: "cauchy_stress", components: 6, data: FieldData::F64(&stress) },
                Field { name: "equivalent_plastic_strain", components: 1, data: FieldData::F64(&strain) },
            ],
        };
        let path = timed("write a frame (106 MB of numbers)", || writer.write_frame(&frame))?;
        report(&path)?;
    }
    Ok(())
}
