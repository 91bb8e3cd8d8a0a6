//! Goal: meshes in `.vtu` and `.vtk` are read as VTK, meshio and Gmsh write them, and damaged ones are refused. One mesh of two
//! cubes, a pyramid, a wedge and a tet lies in `corpus/vtk/` in the ways that VTK 9.7 and meshio 5.3 have, and a cube as Gmsh
//! 4.15 writes it. vtkio, which shares no code with the reader here, is the second opinion on the files that it reads.

mod common;

use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use common::Folder;
use estar_io::{Field, FieldData, Frame, Grid, MeshFile, read_mesh, read_mesh_bytes, write_frame_file};
use estar_mesh::GroupKind::{Curve, Nodes, Point, Surface, Volume};
use estar_mesh::quality::QualityReport;
use estar_mesh::{Elements, NodeLabel, Shape};
use vtkio::Vtk;
use vtkio::model::DataSet;

fn corpus() -> Vec<(String, Vec<u8>)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/corpus/vtk");
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> =
        paths.map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(path).unwrap())).collect();
    files.sort();
    files
}

fn of_corpus(name: &str) -> Vec<u8> {
    corpus().into_iter().find(|(file, _)| file == name).unwrap().1
}

fn read(bytes: &[u8]) -> MeshFile {
    read_mesh_bytes(bytes, "part.vtu").unwrap()
}

fn error(bytes: &[u8]) -> String {
    read_mesh_bytes(bytes, "part.vtu").unwrap_err().to_string()
}

/// The ASCII file of the corpus with something replaced.
fn changed(from: &str, to: &str) -> Vec<u8> {
    changed_in("vtk_ascii_none_32_little.vtu", from, to)
}

fn changed_in(file: &str, from: &str, to: &str) -> Vec<u8> {
    let text = String::from_utf8(of_corpus(file)).unwrap();
    assert!(text.contains(from), "{from:?} is not in\n{text}");
    text.replacen(from, to, 1).into_bytes()
}

/// A file of one piece, in text.
fn vtu(points: &[[f64; 3]], cells: &[(u8, &[u32])], arrays: &str) -> String {
    let words = |numbers: Vec<String>| numbers.join(" ");
    let mut end = 0;
    let ends = cells.iter().map(|(_, nodes)| {
        end += nodes.len();
        end.to_string()
    });
    let array = |name: &str, kind: &str, numbers: String| {
        format!("<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">{numbers}</DataArray>")
    };
    format!(
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">{arrays}<Points><DataArray type=\"Float64\" \
         NumberOfComponents=\"3\" format=\"ascii\">{}</DataArray></Points><Cells>{}{}{}</Cells></Piece>",
        points.len(),
        cells.len(),
        words(points.as_flattened().iter().map(ToString::to_string).collect()),
        array("connectivity", "Int64", words(cells.iter().flat_map(|(_, c)| *c).map(ToString::to_string).collect())),
        array("offsets", "Int64", words(ends.collect())),
        array("types", "UInt8", words(cells.iter().map(|(kind, _)| kind.to_string()).collect())),
    )
}

fn file_of(pieces: &[String]) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\"><UnstructuredGrid>{}\
         </UnstructuredGrid></VTKFile>",
        pieces.concat()
    )
}

const CUBE: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];
const HEX: (u8, &[u32]) = (12, &[0, 1, 2, 3, 4, 5, 6, 7]);

#[test]
fn every_way_to_write_a_mesh_gives_the_same() {
    let mut count = 0;
    for (name, bytes) in corpus().into_iter().filter(|(name, _)| !name.contains("lzma") && !name.contains("gmsh")) {
        let MeshFile { mesh, warnings, .. } = read_mesh_bytes(&bytes, &name).unwrap_or_else(|error| panic!("{error}"));
        let shapes = [Shape::Hex8, Shape::Hex8, Shape::Pyramid5, Shape::Wedge6, Shape::Tet4];
        assert_eq!((0..5).map(|element| mesh.elements().shape(element)).collect::<Vec<_>>(), shapes, "{name}");
        assert_eq!(mesh.elements().nodes(1), [1, 2, 5, 4, 7, 8, 11, 10], "{name}");
        assert_eq!(mesh.coordinates()[11..14], [[2.0, 1.0, 1.0], [0.5, 0.5, 2.0], [1.0, 0.5, 2.0]], "{name}");
        // numbers are those that ParaView shows; point 16 belongs to no cell
        assert_eq!(mesh.node_labels()[15], NodeLabel(15), "{name}");
        // two cubes, a pyramid of 1/3 and a wedge of 1/2 on them, a tet of 1/6 beside
        let quality = QualityReport::new(&mesh);
        assert!((quality.summary().total_volume - 3.0).abs() < 1e-14 && quality.errors().is_empty(), "{name}");
        let groups: Vec<_> = mesh
            .groups()
            .iter()
            .map(|group| (&group.name[..], group.kind, [group.elements.len(), group.faces.len(), group.nodes.len()]))
            .collect();
        let expected = [
            ("foot_0", Nodes, [0, 0, 10]),
            ("foot_1", Nodes, [0, 0, 6]),
            ("material_1", Volume, [2, 0, 9]),
            ("material_2", Volume, [3, 0, 11]),
            ("material_7", Surface, [0, 1, 4]),
            ("material_8", Surface, [0, 1, 3]),
            ("material_9", Curve, [0, 0, 2]),
            ("material_9", Point, [0, 0, 1]),
            ("all", Volume, [5, 0, 16]),
        ];
        assert_eq!(groups, expected, "{name}");
        assert_eq!(mesh.group("material_1").unwrap().elements, [0, 2], "{name}");
        assert_eq!(warnings[0], "1 wedge has the other triangle first, and is turned", "{name}");
        assert_eq!(warnings.last().unwrap(), "1 node belongs to no element and is left out: 16", "{name}");
        count += 1;
    }
    assert_eq!(count, 18);
}

#[test]
fn gmsh_writes_its_groups_as_numbers_of_cells() {
    for name in ["gmsh.vtk", "gmsh_binary.vtk"] {
        let mesh = read(&of_corpus(name)).mesh;
        assert_eq!((mesh.node_count(), mesh.element_count()), (8, 1));
        assert_eq!(mesh.group("volume_7").unwrap().elements, [0], "{name}");
        assert_eq!(mesh.group("surface_8").unwrap().faces.len(), 1, "{name}");
        let outward = mesh.outward_faces(mesh.group("surface_8").unwrap());
        assert!(outward.is_ok() && QualityReport::new(&mesh).errors().is_empty(), "{name}");
    }
}

/// vtkio has no reader of raw bytes behind the XML, and none of `.vtk` with data before the points.
#[test]
fn vtkio_reads_the_same_points_and_cells() {
    let mut count = 0;
    for (name, bytes) in corpus() {
        let is_xml = name.ends_with("vtu");
        let theirs = if is_xml { Vtk::parse_xml(&bytes[..]) } else { Vtk::parse_legacy_be(&bytes[..]) };
        let (Ok(theirs), Ok(ours)) = (theirs, read_mesh_bytes(&bytes, &name)) else { continue };
        let DataSet::UnstructuredGrid { pieces, .. } = theirs.data else { panic!("{name}") };
        let piece = pieces.into_iter().next().unwrap().into_loaded_piece_data(None).unwrap();
        let points: Vec<f64> = piece.points.cast_into().unwrap();
        let mesh = ours.mesh;
        assert_eq!(points[..3 * mesh.node_count()], *mesh.coordinates().as_flattened(), "{name}");
        let (connectivity, ends) = piece.cells.cell_verts.into_xml();
        let solids = (0..ends.len()).filter(|&cell| matches!(piece.cells.types[cell] as u8, 10..=14));
        let cells: Vec<Vec<u32>> = solids
            .map(|cell| {
                let start = if cell == 0 { 0 } else { ends[cell - 1] as usize };
                connectivity[start..ends[cell] as usize].iter().map(|&node| node as u32).collect()
            })
            .collect();
        assert_eq!(cells.len(), mesh.element_count(), "{name}");
        for (element, mut cell) in cells.into_iter().enumerate() {
            if mesh.elements().shape(element) == Shape::Wedge6 {
                cell.rotate_left(3);
            }
            assert_eq!(mesh.elements().nodes(element), cell, "{name}");
        }
        count += 1;
    }
    assert!(count >= 11, "vtkio read {count} files");
}

#[test]
fn what_is_no_unstructured_grid_is_refused_with_what_to_do() {
    for (kind, words) in [
        ("PolyData", "a surface of VTK (PolyData), not a mesh of solids, which is not read; mesh the volume inside"),
        ("PUnstructuredGrid", "the list of the pieces of a VTK mesh"),
        ("ImageData", "apply the filter Append Datasets"),
        ("StructuredGrid", "a structured grid of VTK"),
        ("RectilinearGrid", "a rectilinear grid of VTK"),
        ("vtkMultiBlockDataSet", "apply the filter Merge Blocks"),
        ("Table", "something else than an unstructured grid"),
    ] {
        let told = error(&changed("type=\"UnstructuredGrid\"", &format!("type=\"{kind}\"")));
        assert!(told.contains(words), "{kind}: {told}");
    }
    let told = error(&changed_in("vtk_42_ascii.vtk", "UNSTRUCTURED_GRID", "POLYDATA"));
    assert!(told.contains("a surface of VTK") && told.starts_with("part.vtu:"), "{told}");
    let told = error(&of_corpus("vtk_appended_lzma_32_little.vtu"));
    assert!(
        told.contains("vtkLZMADataCompressor\" is not supported; save the mesh with the compressor ZLib"),
        "{told}"
    );
}

#[test]
fn what_is_wrong_is_named_with_its_place() {
    for (from, to, words) in [
        ("NumberOfPoints=\"17\"", "NumberOfPoints=\"18\"", "the array \"Points\" has 51 numbers instead of 54"),
        ("NumberOfPoints=\"17\"", "NumberOfPoints=\"-1\"", "NumberOfPoints: expected a number, found \"-1\""),
        ("NumberOfCells=\"9\"", "NumberOfCells=\"10\"", "has 9 numbers instead of 10"),
        ("NumberOfCells=\"9\"", "NumberOfCells=\"99999999999999999\"", "instead of 99999999999999999"),
        ("Name=\"connectivity\"", "Name=\"nodes\"", "the piece has no array \"connectivity\""),
        ("byte_order=\"LittleEndian\"", "byte_order=\"Middle\"", "byte_order is \"Middle\""),
        ("header_type=\"UInt32\"", "header_type=\"Float64\"", "header_type is \"Float64\""),
        ("<Cells>", "<Cell>", "bad XML"),
        ("</VTKFile>", "", "bad XML"),
        ("type=\"Float64\" Name=\"Points\"", "type=\"Complex\" Name=\"Points\"", "has the type \"Complex\""),
        ("NumberOfComponents=\"3\"", "NumberOfComponents=\"2\"", "instead of 34"),
        ("9 9 9", "9 9 nine", "the array \"Points\" has \"nine\" for a number"),
        ("0.5 0.5 2", "0.5 0.5 NaN", "node 12: its z coordinate is NaN"),
        ("8 16 21 27", "8 16 15 27", "the array \"offsets\" ends cell 2 at 15"),
        ("8 16 21 27", "8 16 21 999", "the array \"offsets\" ends cell 3 at 999"),
        ("8 16 21 27", "8 17 21 27", "cell 1 has 9 points, which hexahedra cannot have"),
        ("10 9 12 7", "10 9 17 7", "cell 2 refers to point 17, but there are 17, numbered from 0"),
        ("10 9 12 7", "10 9 -1 7", "cell 2 refers to point -1"),
        ("12 12 14 13", "25 12 14 13", "cell 0 has 8 points, which 20-node hexahedra cannot have"),
        (
            "12 12 14 13",
            "42 12 14 13",
            "unsupported elements: 1 polyhedra (the first is element 0): mesh with hexahedra",
        ),
        ("12 12 14 13", "99 12 14 13", "unsupported elements: 1 cells of VTK's type 99 (the first is element 0)"),
    ] {
        let told = error(&changed(from, to));
        assert!(told.contains(words), "{from} → {to}: {told}");
    }
    for (from, to, words) in [
        ("ASCII", "TEXT", ":4: the third line of a VTK file is ASCII or BINARY"),
        ("POINTS 17 double", "POINTS 17 complex", "\"complex\" is no type of numbers of VTK"),
        ("POINTS 17 double", "POINTS 17000000000 double", "numbers: 51000000000 are announced, but only"),
        ("POINTS 17 double", "POINTS 18446744073709551615 double", "are announced, but only"),
        ("CELLS 9 ", "CELLS 8 ", "8 cells are announced, but there are 9"),
        ("CELL_TYPES 9", "CELL_TYPES 8", ":47: expected a section such as POINTS, found \"1\""),
        ("CELL_TYPES 9", "SPHERES 9", "expected a section such as POINTS, found \"SPHERES\""),
        ("8 0 1 4 3", "8 0 1 four 3", "expected a number, found \"four\""),
        ("8 0 1 4 3", "80 0 1 4 3", "a cell of 80 nodes does not fit into CELLS"),
        ("material 1 9 int", "material 1 8 int", "\"9\" is no keyword of VTK that is known here"),
    ] {
        let told = error(&changed_in("vtk_42_ascii.vtk", from, to));
        assert!(told.contains(words), "{from} → {to}: {told}");
    }
}

#[test]
fn a_small_file_cannot_ask_for_much_memory_or_time() {
    let start = Instant::now();
    // the head of the points: blocks, their size, the size of the last
    let raw = of_corpus("vtk_appended_zlib_32_little.vtu");
    let find = |word: &[u8], from: usize| from + raw[from..].windows(word.len()).position(|w| w == word).unwrap();
    let points = find(b"offset=\"", find(b"Name=\"Points\"", 0)) + 8;
    let offset: usize = std::str::from_utf8(&raw[points..find(b"\"", points)]).unwrap().parse().unwrap();
    let first = find(b"_", find(b"<AppendedData", 0)) + 1 + offset;
    assert_eq!(raw[first..first + 4], [1, 0, 0, 0]);
    for words in [[u32::MAX; 3], [0, u32::MAX, 0], [1, u32::MAX, u32::MAX], [3, 1 << 30, 1], [0, 0, 1], [1, 1, 2]] {
        let mut bytes = raw.clone();
        for (k, word) in words.iter().enumerate() {
            bytes[first + 4 * k..first + 4 * k + 4].copy_from_slice(&word.to_le_bytes());
        }
        assert!(read_mesh_bytes(&bytes, "huge").is_err(), "{words:?}");
    }
    let nested = file_of(&["<a>".repeat(200_000)]);
    assert!(read_mesh_bytes(nested.as_bytes(), "nested").is_err());
    let laughs: String =
        (1..20).map(|k| format!("<!ENTITY a{k} \"{}\">", format!("&a{};", k - 1).repeat(10))).collect();
    let laughs = format!("<?xml version=\"1.0\"?><!DOCTYPE a [<!ENTITY a0 \"ha\">{laughs}]><VTKFile>&a19;</VTKFile>");
    assert!(read_mesh_bytes(laughs.as_bytes(), "laughs").is_err());
    assert!(start.elapsed().as_secs_f64() < 10.0);
}

#[test]
fn a_wedge_may_begin_with_either_triangle() {
    let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    let wedge = |nodes: &[u32]| read(file_of(&[vtu(&points, &[(13, nodes)], "")]).as_bytes());
    let (straight, turned) = (wedge(&[0, 1, 2, 3, 4, 5]), wedge(&[3, 4, 5, 0, 1, 2]));
    assert_eq!(straight.mesh.elements(), turned.mesh.elements());
    assert!(straight.warnings.is_empty() && turned.warnings.len() == 1, "{:?}", turned.warnings);
}

#[test]
fn voxels_and_pixels_have_their_nodes_along_the_axes() {
    let voxel: (u8, &[u32]) = (11, &[0, 1, 3, 2, 4, 5, 7, 6]);
    let arrays = "<CellData><DataArray type=\"UInt8\" Name=\"id\" format=\"ascii\">1 2</DataArray></CellData>";
    let read = read(file_of(&[vtu(&CUBE, &[voxel, (8, &[0, 1, 3, 2])], arrays)]).as_bytes());
    assert_eq!(read.mesh.elements().nodes(0), [0, 1, 2, 3, 4, 5, 6, 7]);
    assert!(read.mesh.outward_faces(read.mesh.group("id_2").unwrap()).is_ok());
}

#[test]
fn pieces_doubles_numbers_and_cells_of_no_use_are_told() {
    let shifted = CUBE.map(|[x, y, z]| [x + 1.0, y, z]);
    let arrays = |ids: &str, ghosts: &str, nodes: &str| {
        format!(
            "<CellData><DataArray type=\"Int32\" Name=\"element_id\" format=\"ascii\">{ids}</DataArray><DataArray \
             type=\"UInt8\" Name=\"vtkGhostType\" format=\"ascii\">{ghosts}</DataArray></CellData><PointData><DataArray \
             type=\"Int64\" Name=\"GlobalNodeId\" format=\"ascii\">{nodes}</DataArray></PointData>"
        )
    };
    let one = vtu(&CUBE, &[HEX, HEX], &arrays("70 71", "0 1", "11 12 13 14 15 16 17 18"));
    let strip: (u8, &[u32]) = (6, &[0, 1, 2, 3]);
    let other = vtu(&shifted, &[HEX, strip, (5, &[0, 1, 2])], &arrays("80 81 82", "0 0 0", "21 22 23 24 25 26 27 28"));
    let MeshFile { mesh, warnings, .. } = read(file_of(&[one.clone(), other]).as_bytes());
    assert_eq!(mesh.element_labels().iter().map(|label| label.0).collect::<Vec<_>>(), [70, 80]);
    assert_eq!((mesh.node_labels()[0], mesh.node_labels()[15]), (NodeLabel(11), NodeLabel(28)));
    assert_eq!(mesh.groups().len(), 1, "numbers make no groups");
    let told = [
        "the file has 2 pieces, which have no nodes in common: [mesh] merge joins those at one place",
        "cells that are neither solids nor faces or lines that name groups are left out: 1 triangle strips",
        "1 cell is marked as double or hidden (vtkGhostType), and is left out",
        "1 face, line or vertex is in no group, and is left out",
    ];
    assert_eq!(warnings, told);
    // one number twice: the numbers of ParaView stand in
    let MeshFile { mesh, warnings, .. } = read(file_of(&[one.clone(), one]).as_bytes());
    assert_eq!((mesh.node_labels()[15], mesh.element_labels()[1].0), (NodeLabel(15), 2));
    assert!(warnings[0].starts_with("the array that numbers the points has a number twice"), "{warnings:?}");
}

#[test]
fn an_array_of_many_numbers_makes_no_groups() {
    let count = 1500;
    let cells: Vec<(u8, &[u32])> = vec![HEX; count];
    let numbers: Vec<String> = (0..count).map(|k| k.to_string()).collect();
    let arrays = format!(
        "<CellData><DataArray type=\"Int32\" Name=\"chunk\" format=\"ascii\">{}</DataArray></CellData>",
        numbers.join(" ")
    );
    let MeshFile { mesh, warnings, .. } = read(file_of(&[vtu(&CUBE, &cells, &arrays)]).as_bytes());
    assert_eq!(mesh.groups().len(), 1);
    assert_eq!(warnings, ["arrays of more than 1000 numbers that differ make no groups: \"chunk\""]);
}

/// What `estar convert` writes: numbers of nodes and elements, and a field of 0 and 1 for each group.
#[test]
fn a_mesh_that_was_converted_is_read_with_its_groups() {
    let mut elements = Elements::with_capacity(Shape::Hex8, 1);
    elements.push(Shape::Hex8, &[0, 1, 2, 3, 4, 5, 6, 7]);
    let labels: Vec<i64> = (11..19).collect();
    let foot = [1, 1, 1, 1, 0, 0, 0, 0];
    let node_fields = [
        Field { name: "node_id", components: 1, data: FieldData::I64(&labels) },
        Field { name: "group foot", components: 1, data: FieldData::U8(&foot) },
    ];
    let cell_fields = [
        Field { name: "element_id", components: 1, data: FieldData::I64(&[5]) },
        Field { name: "group part.bar", components: 1, data: FieldData::U8(&[1]) },
        Field { name: "group all", components: 1, data: FieldData::U8(&[1]) },
    ];
    let grid = Grid::new(8, &elements, &node_fields, &cell_fields).unwrap();
    let points = FieldData::F64(CUBE.as_flattened());
    let frame = Frame { time: 0.0, grid: &grid, points, node_fields: Vec::new(), cell_fields: Vec::new() };
    let folder = Folder::new("converted");
    fs::create_dir_all(&folder.0).unwrap();
    let path = folder.0.join("part.vtu");
    write_frame_file(&path, &frame).unwrap();
    let MeshFile { mesh, warnings, format } = read_mesh(&path).unwrap();
    assert_eq!((format.as_str(), warnings.len()), ("VTU 1.0, zlib", 0));
    assert_eq!((mesh.node_labels()[0], mesh.element_labels()[0].0), (NodeLabel(11), 5));
    assert_eq!(mesh.group("foot").unwrap().nodes, [0, 1, 2, 3]);
    let names: Vec<&str> = mesh.groups().iter().map(|group| group.name.as_str()).collect();
    assert_eq!(names, ["foot", "part.bar", "all"]);
}
