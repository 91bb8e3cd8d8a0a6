//! Goal: a frame is read back as it was written, and anything else is refused without harm.

mod common;

use common::Folder;
use estar_io::{
    Field, FieldData, Frame, FrameContent, FrameLimits, Grid, ResultWriter, read_frame, read_frame_bytes,
    read_frame_with, write_frame_file,
};
use estar_mesh::{Elements, Shape};
use std::fs;

/// Two cubes side by side, with a field of each kind, as the bytes of a frame.
fn frame(name: &str) -> Vec<u8> {
    let points: Vec<f64> = (0..12).flat_map(|node| [node % 3, node / 3 % 2, node / 6].map(f64::from)).collect();
    let mut elements = Elements::with_capacity(Shape::Hex8, 2);
    for first in 0..2 {
        elements.push(Shape::Hex8, &[0, 1, 4, 3, 6, 7, 10, 9].map(|node| node + first));
    }
    let label: Vec<i64> = (101..113).collect();
    let part = [1, 2];
    let grid = Grid::new(
        12,
        &elements,
        &[Field { name: "node_id", components: 1, data: FieldData::I64(&label) }],
        &[Field { name: "part", components: 1, data: FieldData::I32(&part) }],
    )
    .unwrap();
    let strain = [0.25, 1.5];
    let folder = Folder::new(name);
    let mut writer = ResultWriter::create(&folder.0).unwrap();
    let frame = Frame {
        time: 3.5e-6,
        grid: &grid,
        points: FieldData::F64(&points),
        node_fields: vec![Field { name: "velocity <\"&>", components: 3, data: FieldData::F64(&points) }],
        cell_fields: vec![Field { name: "strain", components: 1, data: FieldData::F64(&strain) }],
    };
    writer.write_frame(&frame).unwrap();
    fs::read(folder.0.join("fields/frame_00000.vtu")).unwrap()
}

#[test]
fn a_frame_is_read_back_as_it_was_written() {
    let FrameContent { time, points, connectivity, offsets, types, node_fields, cell_fields } =
        read_frame_bytes(&frame("read_back")).unwrap();
    assert_eq!(time, 3.5e-6);
    assert_eq!((points.len(), points[11]), (12, [2.0, 1.0, 1.0]));
    assert_eq!(connectivity[8..], [1, 2, 5, 4, 7, 8, 11, 10]);
    assert_eq!((offsets, types), (vec![8, 16], vec![12, 12]));
    assert_eq!(node_fields["node_id"].data[3], 104.0);
    assert_eq!((node_fields["velocity <\"&>"].components, node_fields["velocity <\"&>"].data.len()), (3, 36));
    assert_eq!(cell_fields["strain"].data, [0.25, 1.5]);
    assert_eq!(cell_fields["part"].data, [1.0, 2.0]);
}

#[test]
fn fields_that_are_not_wanted_have_no_numbers_and_the_rest_is_the_same() {
    let folder = Folder::new("wanted");
    let path = folder.0.join("frame.vtu");
    fs::create_dir_all(&folder.0).unwrap();
    fs::write(&path, frame("wanted_source")).unwrap();
    let (whole, part) =
        (read_frame(&path).unwrap(), read_frame_with(&path, FrameLimits::default(), |name| name == "strain").unwrap());
    assert_eq!((&part.points, &part.connectivity), (&whole.points, &whole.connectivity));
    assert_eq!(part.cell_fields["strain"], whole.cell_fields["strain"]);
    let velocity = &part.node_fields["velocity <\"&>"];
    assert_eq!((velocity.components, velocity.data.len()), (3, 0));
    assert!(part.node_fields.keys().eq(whole.node_fields.keys()));
}

#[test]
fn a_frame_that_ends_early_is_refused_wherever_it_ends() {
    let whole = frame("ends_early");
    let end = whole.windows(16).position(|window| window == b"</AppendedData>\n").unwrap() - 1;
    for length in 0..end {
        assert!(read_frame_bytes(&whole[..length]).is_err(), "{length}");
    }
}

#[test]
fn a_frame_with_wrong_bytes_does_no_harm() {
    let whole = frame("wrong_bytes");
    for place in 0..whole.len() {
        for wrong in [0, 0xff, whole[place] ^ 1, b'9'] {
            let mut damaged = whole.clone();
            damaged[place] = wrong;
            // a wrong digit of the time is a time
            let _ = read_frame_bytes(&damaged);
        }
    }
}

#[test]
fn counts_that_lie_are_refused_before_memory_is_taken() {
    for (from, to) in [
        ("NumberOfPoints=\"12\"", "NumberOfPoints=\"999999999999999\""),
        ("NumberOfCells=\"2\"", "NumberOfCells=\"18446744073709551615\""),
        ("NumberOfComponents=\"3\"", "NumberOfComponents=\"99999999\""),
        ("offset=\"0\"", "offset=\"18446744073709551615\""),
    ] {
        let mut bytes = frame("lies");
        let at = bytes.windows(from.len()).position(|window| window == from.as_bytes()).unwrap();
        bytes.splice(at..at + from.len(), to.bytes());
        assert!(read_frame_bytes(&bytes).is_err(), "{from}");
    }
}

/// Arrays of zeros take a thousandth of their length in the file.
#[test]
fn a_small_file_is_not_unpacked_into_a_large_memory() {
    let node_count = 2_000_000;
    let points = vec![0.0; 3 * node_count];
    let mut elements = Elements::with_capacity(Shape::Hex8, 1);
    elements.push(Shape::Hex8, &[0, 1, 2, 3, 4, 5, 6, 7]);
    let grid = Grid::new(node_count, &elements, &[], &[]).unwrap();
    let folder = Folder::new("bomb");
    fs::create_dir_all(&folder.0).unwrap();
    let path = folder.0.join("frame.vtu");
    let points = FieldData::F64(&points);
    let frame = Frame { time: 0.0, grid: &grid, points, node_fields: Vec::new(), cell_fields: Vec::new() };
    write_frame_file(&path, &frame).unwrap();
    assert!(fs::metadata(&path).unwrap().len() < 700_000);
    let told = read_frame(&path).unwrap_err().to_string();
    assert!(told.contains("promises more than such a file can hold"), "{told}");
}

#[test]
fn a_frame_larger_than_its_limits_is_refused() {
    let folder = Folder::new("limits");
    fs::create_dir_all(&folder.0).unwrap();
    let path = folder.0.join("frame.vtu");
    let bytes = frame("limits_source");
    fs::write(&path, &bytes).unwrap();
    let read = |file: u64, numbers: u64| read_frame_with(&path, FrameLimits { file, numbers }, |_| true);
    let length = bytes.len() as u64;
    // the time, 12 points and velocities, labels of nodes; strain, part, connectivity, offsets and types of two cells
    let numbers = 8 * (1 + 12 * (3 + 3 + 1) + 2 * (1 + 1 + 8 + 1 + 1));
    assert!(read(length, numbers).is_ok());
    assert!(read(length - 1, numbers).unwrap_err().to_string().contains("more than"));
    assert!(read(length, numbers - 1).unwrap_err().to_string().contains("promises more"));
}

#[cfg(unix)]
#[test]
fn a_device_is_no_frame() {
    let told = read_frame(std::path::Path::new("/dev/zero")).unwrap_err().to_string();
    assert!(told.contains("a device or a pipe"), "{told}");
}

#[test]
fn a_file_that_is_not_there_or_no_frame_is_named() {
    let folder = Folder::new("no_frame");
    fs::create_dir_all(&folder.0).unwrap();
    let path = folder.0.join("frame.vtu");
    assert!(read_frame(&path).unwrap_err().to_string().contains("frame.vtu: cannot be read"));
    fs::write(&path, "<VTKFile>\n").unwrap();
    assert!(read_frame(&path).unwrap_err().to_string().contains("frame.vtu: no frame of this program"));
}

/// The frame with its arrays in base64 where the XML names them: vtkio reads no bytes behind the XML. Only heads are looked at.
fn with_arrays_in_the_xml(frame: &[u8]) -> String {
    use base64::prelude::{BASE64_STANDARD, Engine};
    const BEHIND: &str = "<AppendedData encoding=\"raw\">\n_";
    let start = frame.windows(BEHIND.len()).position(|window| window == BEHIND.as_bytes()).unwrap();
    let (xml, behind) = (std::str::from_utf8(&frame[..start]).unwrap(), &frame[start + BEHIND.len()..]);
    let word = |at: usize| u64::from_le_bytes(behind[at..at + 8].try_into().unwrap()) as usize;
    let mut out = String::new();
    for (k, piece) in xml.split(" format=\"appended\" offset=\"").enumerate() {
        if k == 0 {
            out += piece;
            continue;
        }
        let (offset, rest) = piece.split_once("\"/>").unwrap();
        let at: usize = offset.parse().unwrap();
        // blocks, their size, the size of the last, then the packed size of each
        let head = 8 * (3 + word(at));
        let data: usize = (0..word(at)).map(|block| word(at + 8 * (3 + block))).sum();
        let encoded = |from: usize, length: usize| BASE64_STANDARD.encode(&behind[from..from + length]);
        out += &format!(" format=\"binary\">{}{}</DataArray>{rest}", encoded(at, head), encoded(at + head, data));
    }
    out + "</VTKFile>"
}

/// A third reader, after our own and VTK's in `tests/paraview.rs`. vtkio passes over field data: the time is compared there.
#[test]
fn vtkio_reads_every_field_as_it_was_written() {
    use vtkio::Vtk;
    use vtkio::model::{Attribute, DataSet};
    let ours = read_frame_bytes(&frame("vtkio")).unwrap();
    let vtk = Vtk::parse_xml(with_arrays_in_the_xml(&frame("vtkio_too")).as_bytes()).unwrap();
    let DataSet::UnstructuredGrid { pieces, .. } = vtk.data else { panic!("no unstructured grid") };
    assert_eq!(pieces.len(), 1);
    let piece = pieces.into_iter().next().unwrap().into_loaded_piece_data(None).unwrap();
    assert_eq!(piece.points.cast_into::<f64>().unwrap(), ours.points.as_flattened());
    let (connectivity, ends) = piece.cells.cell_verts.into_xml();
    assert!(connectivity.iter().eq(ours.connectivity.iter().map(|&node| u64::from(node)).collect::<Vec<_>>().iter()));
    assert!(ends.iter().map(|&end| end as usize).eq(ours.offsets.iter().copied()));
    assert!(piece.cells.types.iter().map(|&kind| kind as u8).eq(ours.types.iter().copied()));
    for (theirs, fields) in [(piece.data.point, &ours.node_fields), (piece.data.cell, &ours.cell_fields)] {
        assert_eq!(theirs.len(), fields.len());
        for attribute in theirs {
            let Attribute::DataArray(array) = attribute else { panic!("a field of fields") };
            let components = array.num_comp();
            let field = &fields[&array.name];
            assert_eq!((components, array.data.cast_into::<f64>().unwrap()), (field.components, field.data.clone()));
        }
    }
}
