//! Goal: the lines of `docs/mesh-files.md` that convert other formats do what they say. Each is run on a mesh that Gmsh or meshio
//! wrote, and the result is read; the program itself prints the same line when it is given that file. Without Gmsh and meshio
//! the test says that it was skipped.

mod common;

use std::fs;
use std::path::Path;
use std::process::Command;

use common::Folder;
use estar_io::{read_mesh, read_mesh_bytes};
use estar_mesh::GroupKind::{self, Nodes, Surface, Volume};

/// A box of tets whose volume is `block` and whose lower face is `foot`, in every format of the page.
const MAKE: &str = r#"
import gmsh, meshio, numpy
gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 0)
gmsh.model.occ.addBox(0, 0, 0, 1, 1, 2)
gmsh.model.occ.synchronize()
gmsh.write("part.step")
foot = gmsh.model.getEntitiesInBoundingBox(-.1, -.1, -.1, 1.1, 1.1, .1, 2)
gmsh.model.addPhysicalGroup(3, [1], 7, "block")
gmsh.model.addPhysicalGroup(2, [tag for _, tag in foot], 9, "foot")
gmsh.option.setNumber("Mesh.MeshSizeMin", 0.7)
gmsh.option.setNumber("Mesh.MeshSizeMax", 0.8)
gmsh.model.mesh.generate(3)
for ending in ("unv", "med", "bdf"):
    gmsh.write("part." + ending)
gmsh.finalize()
box = numpy.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
hexes = meshio.Mesh(box, [("hexahedron", numpy.arange(8).reshape(1, 8))], point_sets={"foot": numpy.arange(4)})
hexes.write("part.e")
open("part.geo", "w").write("""
SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 2};
Physical Volume("block") = {1};
Physical Surface("foot") = {5};
""")
"#;

/// What a converted file has, by the ending of what it was.
fn groups_of(ending: &str) -> &'static [(&'static str, GroupKind)] {
    match ending {
        "unv" | "med" | "geo" => &[("block", Volume), ("foot", Surface)],
        // the properties of the body and of its face
        "bdf" => &[("volume_1", Volume), ("surface_5", Surface)],
        "step" => &[("volume_1", Volume), ("surface_6", Surface)],
        "e" => &[("all", Volume), ("foot", Nodes)],
        _ => &[],
    }
}

#[test]
fn the_lines_that_convert_do_what_the_page_says() {
    let folder = Folder::new("conversion");
    fs::create_dir_all(&folder.0).unwrap();
    let made = Command::new("python3").args(["-c", MAKE]).current_dir(&folder.0).output();
    let made = made.is_ok_and(|output| output.status.success());
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/mesh-files.md")).unwrap();
    let lines: Vec<&str> = page
        .lines()
        .filter(|line| line.starts_with('|'))
        .flat_map(|row| row.split('`'))
        .filter(|code| code.starts_with("gmsh ") || code.starts_with("meshio "))
        .collect();
    assert_eq!(lines.len(), 6, "{lines:#?}");
    let has_tools = ["gmsh", "meshio"].iter().all(|tool| Command::new(tool).arg("--help").output().is_ok());
    if !made || !has_tools {
        eprintln!("skipped: Python's gmsh, meshio and netCDF4 are not all installed");
        return;
    }
    for line in lines {
        let words: Vec<&str> = line.split(' ').collect();
        let name = words.iter().find(|word| word.starts_with("part.")).unwrap();
        let target = folder.0.join(words.iter().rfind(|word| word.starts_with("part.")).unwrap());
        let output = Command::new(words[0]).args(&words[1..]).current_dir(&folder.0).output().unwrap();
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        let mesh = read_mesh(&target).unwrap_or_else(|error| panic!("{line}: {error}")).mesh;
        for (group, kind) in groups_of(name.strip_prefix("part.").unwrap()) {
            let found = mesh.groups().iter().any(|found| found.name == *group && found.kind == *kind);
            assert!(found, "{line}: no {kind} {group}");
        }
        let content = fs::read(folder.0.join(name)).unwrap();
        let told = read_mesh_bytes(&content, name).unwrap_err().to_string();
        assert!(told.contains(line), "{line}: {told}");
        fs::remove_file(target).unwrap();
    }
}
