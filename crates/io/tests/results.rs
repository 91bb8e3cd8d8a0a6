//! What is written for ParaView, read back as VTK's format says.

mod common;

use common::Folder;
use std::collections::HashMap;
use std::fs;
use std::io::Read;
use std::path::Path;

use estar_io::{Field, FieldData, Frame, FrameError, Grid, ResultWriter, WriteError};
use estar_mesh::Mesh;
use estar_mesh::generate::{BoxSpec, box_mesh};

/// 4,096 hexes: a scalar field fills whole blocks exactly, and a tensor field several.
fn mesh() -> Mesh {
    box_mesh(&BoxSpec::new([1.0, 2.0, 3.0], [16; 3]).unwrap())
}

fn grid(mesh: &Mesh, cell_fields: &[Field]) -> Grid {
    Grid::new(mesh.node_count(), mesh.elements(), &[], cell_fields).unwrap()
}

fn frame<'a>(
    (mesh, grid): (&'a Mesh, &'a Grid),
    time: f64,
    node_fields: Vec<Field<'a>>,
    cell_fields: Vec<Field<'a>>,
) -> Frame<'a> {
    Frame { time, grid, points: FieldData::F64(mesh.coordinates().as_flattened()), node_fields, cell_fields }
}

/// The arrays of a file by section and name, as VTK's format says to read them: type and bytes.
fn arrays(path: &Path) -> HashMap<String, (String, Vec<u8>)> {
    let file = fs::read(path).unwrap();
    let marker = b"<AppendedData encoding=\"raw\">\n_";
    let start = file.windows(marker.len()).position(|window| window == marker).unwrap();
    let (xml, appended) = (std::str::from_utf8(&file[..start]).unwrap(), &file[start + marker.len()..]);
    let attribute = |line: &str, key: &str| {
        let (_, rest) = line.split_once(&format!(" {key}=\"")).unwrap();
        rest.split_once('"').unwrap().0.to_owned()
    };
    let mut section = String::new();
    let mut arrays = HashMap::new();
    for line in xml.lines() {
        if !line.starts_with("<DataArray") {
            section = line.trim_matches(['<', '>']).to_owned();
            continue;
        }
        let data = &appended[attribute(line, "offset").parse::<usize>().unwrap()..];
        let word = |k: usize| u64::from_le_bytes(data[8 * k..8 * k + 8].try_into().unwrap()) as usize;
        let (block_count, block_size, last_size) = (word(0), word(1), word(2));
        let mut at = 8 * (3 + block_count);
        let mut bytes = Vec::new();
        for block in 0..block_count {
            let compressed = &data[at..at + word(3 + block)];
            flate2::read::ZlibDecoder::new(compressed).read_to_end(&mut bytes).unwrap();
            at += compressed.len();
            let is_short = block + 1 == block_count && last_size > 0;
            assert_eq!(bytes.len(), block * block_size + if is_short { last_size } else { block_size });
        }
        arrays.insert(format!("{section}/{}", attribute(line, "Name")), (attribute(line, "type"), bytes));
    }
    arrays
}

#[test]
fn fields_come_back_bit_for_bit() {
    let mesh = mesh();
    let folder = Folder::new("bits");
    let velocity: Vec<f64> = (0..3 * mesh.node_count()).map(|k| (k as f64).sin() * 1e-200).collect();
    let stress: Vec<f64> = (0..6 * mesh.element_count()).map(|k| (k as f64).sqrt() * 1e200).collect();
    let part: Vec<i32> = (0..mesh.element_count() as i32).map(|k| -k).collect();
    let label: Vec<i64> = (0..mesh.element_count() as i64).collect();
    let small: Vec<f32> = (0..mesh.element_count()).map(|k| k as f32 / 3.0).collect();
    let first_component = |hex: usize| stress[6 * hex];
    let computed = FieldData::Computed { count: mesh.element_count(), number: &first_component };
    let node_fields = vec![Field { name: "velocity", components: 3, data: FieldData::F64(&velocity) }];
    let cell_fields = vec![
        Field { name: "cauchy_stress", components: 6, data: FieldData::F64(&stress) },
        Field { name: "first_component", components: 1, data: computed },
        Field { name: "J < 1 & more", components: 1, data: FieldData::F32(&small) },
    ];
    let unchanging = [
        Field { name: "part", components: 1, data: FieldData::I32(&part) },
        Field { name: "label", components: 1, data: FieldData::I64(&label) },
    ];
    let grid = grid(&mesh, &unchanging);
    let mut writer = ResultWriter::create(&folder.0).unwrap();
    let path = writer.write_frame(&frame((&mesh, &grid), 1.25e-6, node_fields, cell_fields)).unwrap();
    assert!(path.ends_with("fields/frame_00000.vtu"));

    let arrays = arrays(&path);
    let expect = |name: &str, vtk_type: &str, bytes: Vec<u8>| {
        let (found_type, found) = &arrays[name];
        assert_eq!(found_type, vtk_type, "{name}");
        assert!(*found == bytes, "{name}");
    };
    let doubles = |values: &[f64]| values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let ints = |values: &[i32]| values.iter().flat_map(|value| value.to_le_bytes()).collect();
    expect("FieldData/TimeValue", "Float64", doubles(&[1.25e-6]));
    expect("Points/Points", "Float64", doubles(&mesh.coordinates().concat()));
    expect("PointData/velocity", "Float64", doubles(&velocity));
    expect("CellData/cauchy_stress", "Float64", doubles(&stress));
    expect("CellData/first_component", "Float64", doubles(&stress.iter().step_by(6).copied().collect::<Vec<_>>()));
    expect("CellData/part", "Int32", ints(&part));
    expect("CellData/label", "Int64", label.iter().flat_map(|value| value.to_le_bytes()).collect());
    expect("CellData/J &lt; 1 &amp; more", "Float32", small.iter().flat_map(|value| value.to_le_bytes()).collect());
    expect(
        "Cells/connectivity",
        "Int32",
        mesh.elements().all_nodes().iter().flat_map(|node| node.to_le_bytes()).collect(),
    );
    expect("Cells/offsets", "Int32", ints(&(1..=4096).map(|hex| 8 * hex).collect::<Vec<_>>()));
    expect("Cells/types", "UInt8", vec![12; 4096]);
}

#[test]
fn the_series_names_every_frame_with_its_time() {
    let mesh = mesh();
    let grid = grid(&mesh, &[]);
    let folder = Folder::new("series");
    let mut writer = ResultWriter::create(&folder.0).unwrap();
    for time in [0.0, 0.1 + 0.2] {
        writer.write_frame(&frame((&mesh, &grid), time, vec![], vec![])).unwrap();
    }
    let mut writer = ResultWriter::resume(&folder.0, vec![0.0]).unwrap();
    writer.write_frame(&frame((&mesh, &grid), 0.5, vec![], vec![])).unwrap();
    assert_eq!(writer.frame_count(), 2);
    let series = fs::read_to_string(folder.0.join("results.pvd")).unwrap();
    assert!(series.contains("<DataSet timestep=\"0.0\" part=\"0\" file=\"fields/frame_00000.vtu\"/>"));
    assert!(series.contains("<DataSet timestep=\"0.5\" part=\"0\" file=\"fields/frame_00001.vtu\"/>"));
    assert_eq!(series.matches("<DataSet").count(), 2);
}

#[test]
fn the_same_frame_gives_the_same_bytes() {
    let mesh = mesh();
    let grid = grid(&mesh, &[]);
    let folder = Folder::new("bytes");
    let mut writer = ResultWriter::create(&folder.0).unwrap();
    let first = writer.write_frame(&frame((&mesh, &grid), 1.0, vec![], vec![])).unwrap();
    let second = writer.write_frame(&frame((&mesh, &grid), 1.0, vec![], vec![])).unwrap();
    assert_eq!(fs::read(first).unwrap(), fs::read(second).unwrap());
}

#[test]
fn a_field_of_the_wrong_length_or_name_is_refused_and_writes_nothing() {
    let mesh = mesh();
    let parts = vec![1; mesh.element_count()];
    let grid = grid(&mesh, &[Field { name: "part", components: 1, data: FieldData::I32(&parts) }]);
    let folder = Folder::new("refused");
    let mut writer = ResultWriter::create(&folder.0).unwrap();
    let one = |name| Field { name, components: 1, data: FieldData::F64(&[1.0]) };
    let error = writer.write_frame(&frame((&mesh, &grid), 0.0, vec![], vec![one("p")])).unwrap_err();
    assert_eq!(error.to_string(), "field \"p\": 1 numbers, but 4096 expected (1 for each of 4096)");
    let pressure = vec![0.0; mesh.element_count()];
    let field = Field { name: "p", components: 1, data: FieldData::F64(&pressure) };
    let error = writer.write_frame(&frame((&mesh, &grid), 0.0, vec![], vec![field, field])).unwrap_err();
    assert!(matches!(error, WriteError::Frame(FrameError::DuplicateField { .. })));
    let field = Field { name: "part", ..field };
    let error = writer.write_frame(&frame((&mesh, &grid), 0.0, vec![], vec![field])).unwrap_err();
    assert!(matches!(error, WriteError::Frame(FrameError::DuplicateField { .. })));
    let short = Frame { points: FieldData::F64(&[0.0; 3]), ..frame((&mesh, &grid), 0.0, vec![], vec![]) };
    let error = writer.write_frame(&short).unwrap_err();
    assert!(matches!(error, WriteError::Frame(FrameError::Length { .. })));
    assert_eq!(fs::read_dir(folder.0.join("fields")).unwrap().count(), 0);
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = Folder::new("blocked");
    fs::write(&folder.0, "a file").unwrap();
    let error = ResultWriter::create(&folder.0).unwrap_err();
    assert!(matches!(error, WriteError::Unwritable { .. }) && error.to_string().contains("blocked"));
    fs::remove_file(&folder.0).unwrap();
}
