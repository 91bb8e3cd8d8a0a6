//! Mesh formats that are not read: how each is told by its content, and the line that converts it.

use std::path::Path;

use crate::error::Problem;

/// What turns a file into one that is read.
#[derive(Debug, Clone, Copy)]
enum Way {
    /// Gmsh reads it; what becomes of its groups.
    Gmsh(&'static str),
    /// Gmsh meshes it.
    GmshMeshes,
    /// Python's meshio reads it; what becomes of its groups.
    Meshio(&'static str),
    /// Something else.
    Advice(&'static str),
}

/// What a file is whose format is known, but not read.
pub(crate) fn recognised(content: &[u8], name: &str) -> Option<Problem> {
    let (what, way) = format_of(content, name)?;
    let advice = match way {
        Way::Gmsh(groups) => {
            format!("convert it: gmsh {name} -save -format msh41 -o {} ({groups})", ending(name, "msh"))
        }
        Way::GmshMeshes => format!("mesh it: gmsh {name} -3 -format msh41 -o {}", ending(name, "msh")),
        Way::Meshio(groups) => format!("convert it: meshio convert {name} {} ({groups})", ending(name, "inp")),
        Way::Advice(advice) => advice.to_owned(),
    };
    Some(Problem::OtherFormat { what, advice })
}

const EXPORT_ANOTHER: &str = "write the mesh as Abaqus (.inp) or Gmsh (.msh) with the program that made it";

/// A file of LS-DYNA that begins as one of Abaqus could.
pub(crate) fn ls_dyna() -> Problem {
    Problem::OtherFormat { what: "a keyword file of LS-DYNA", advice: EXPORT_ANOTHER.to_owned() }
}

/// A file of VTK that is no unstructured grid.
pub(crate) fn other_vtk(kind: &str) -> Problem {
    const SAVE: &str =
        "in ParaView apply the filter Append Datasets, which makes an unstructured grid, and save that as .vtu";
    let kind_in_capitals = kind.to_ascii_uppercase().replace('_', "");
    let (what, advice) = match kind_in_capitals.as_str() {
        "POLYDATA" | "PPOLYDATA" => {
            ("a surface of VTK (PolyData), not a mesh of solids", "mesh the volume inside and save that")
        }
        "PUNSTRUCTUREDGRID" => (
            "the list of the pieces of a VTK mesh",
            "open it in ParaView, apply the filter Append Datasets, and save as .vtu",
        ),
        "IMAGEDATA" | "PIMAGEDATA" | "STRUCTUREDPOINTS" => ("an image of VTK", SAVE),
        "STRUCTUREDGRID" | "PSTRUCTUREDGRID" => ("a structured grid of VTK", SAVE),
        "RECTILINEARGRID" | "PRECTILINEARGRID" => ("a rectilinear grid of VTK", SAVE),
        "VTKMULTIBLOCKDATASET" | "COLLECTION" | "VTKPARTITIONEDDATASET" | "VTKPARTITIONEDDATASETCOLLECTION" => (
            "a VTK file that only names others",
            "give one of the files that it names, or open it in ParaView, apply the filter Merge Blocks, and save as .vtu",
        ),
        _ => ("a VTK file of something else than an unstructured grid", SAVE),
    };
    Problem::OtherFormat { what, advice: advice.to_owned() }
}

/// A name with another ending, in the folder where the command is given.
fn ending(name: &str, ending: &str) -> String {
    let stem = Path::new(name).file_stem().unwrap_or_default().display();
    // a file may be called what it is not
    let is_called_so = Path::new(name).extension().is_some_and(|own| own.eq_ignore_ascii_case(ending));
    let more = if is_called_so { "-converted" } else { "" };
    format!("{stem}{more}.{ending}")
}

fn format_of(content: &[u8], name: &str) -> Option<(&'static str, Way)> {
    /// Nothing tells a format behind this.
    const LOOKED_AT: usize = 1 << 16;
    let start = &content[..content.len().min(LOOKED_AT)];
    let begins = |beginning: &[u8]| content.starts_with(beginning);
    let has = |word: &[u8]| start.windows(word.len()).any(|window| window == word);
    let has_line =
        |word: &[u8]| start.split(|byte| *byte == b'\n').any(|line| line.trim_ascii_start().starts_with(word));
    let is_called = |endings: &[&str]| {
        let own = Path::new(name).extension().unwrap_or_default();
        endings.iter().any(|ending| own.eq_ignore_ascii_case(ending))
    };
    if begins(b"$MeshFormat") || begins(b"$NOD") {
        None
    } else if has_line(b"*KEYWORD") || begins(b"*ELEMENT_") || begins(b"*NODE_") {
        Some(("a keyword file of LS-DYNA", Way::Advice(EXPORT_ANOTHER)))
    } else if begins(b"*") {
        None
    } else if has_line(b"[mesh]") || has_line(b"[[part]]") {
        Some(("a deck, not a mesh", Way::Advice("`estar check` and `estar run` take it")))
    } else if has_line(b"MeshVersionFormatted") {
        Some((
            "a Medit mesh (.mesh)",
            Way::Gmsh("its references become groups by their numbers, see `estar mesh info`"),
        ))
    } else if has_line(b"NDIME=") {
        Some(("a mesh of SU2", Way::Advice(EXPORT_ANOTHER)))
    } else if begins(b"-1\n") || begins(b"-1\r") || begins(b"-1 ") {
        Some(("an I-deas universal file (.unv)", Way::Gmsh("groups keep their names")))
    } else if begins(b"\x89HDF") && (is_called(&["med", "rmed", "mmed"]) || has(b"INFOS_GENERALES") || has(b"ENS_MAA"))
    {
        Some(("a MED file of Salome", Way::Gmsh("groups keep their names")))
    } else if begins(b"CDF") || begins(b"\x89HDF") && is_called(&["e", "ex2", "exo", "g", "gen"]) {
        Some(("an Exodus file", Way::Meshio("node sets keep their names; blocks and side sets are lost")))
    } else if has_line(b"BEGIN BULK") || has_line(b"BEGIN,BULK") || has_line(b"GRID") {
        let groups = "it has no named groups: properties become `volume_1`, `surface_2`, ..., by their numbers";
        Some(("a Nastran bulk data file", Way::Gmsh(groups)))
    } else if begins(b"ISO-10303-21") || has(b"CASCADE Topology") || begins(b"DBRep_DrawableShape") {
        Some(("a CAD file, not a mesh", Way::GmshMeshes))
    } else if has_line(b"SetFactory(") || has_line(b"Point(") || has_line(b"Point (") {
        Some(("a script of Gmsh, not a mesh", Way::GmshMeshes))
    } else if begins(b"solid ") && has(b"facet") {
        Some(("an STL file: a surface, not a mesh of solids", Way::Advice("mesh the volume inside and save that")))
    } else {
        None
    }
}
