//! `estar mesh`: structured meshes, and what is in a mesh file.

use crate::console::{print, tell};
use crate::failure::Failure;
use clap::{Args, Subcommand};
use estar_deck::format;
use estar_deck::memory::{self, MeshSize};
use estar_deck::units::{self, Dimension};
use estar_io::{Field, FieldData, Frame, Grid, MeshFile, WriteError, write_frame_file};
use estar_mesh::conformity::Conformity;
use estar_mesh::generate::{
    BoxSpec, CylinderParameters, CylinderSpec, NeckingBarParameters, NeckingBarSpec, Section, SpecError, box_mesh,
    cut_into, cylinder, necking_bar,
};
use estar_mesh::quality::QualityReport;
use estar_mesh::{Connectivity, Group, GroupKind, Mesh, Shape, Wanted};
use estar_session::bodies::Bodies;
use estar_session::conformity;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Meshes that need no mesher, and a look into mesh files.
#[derive(Debug, Subcommand)]
pub enum MeshCommand {
    /// A box of equal bricks from the origin: volume "box", surfaces "x_min", "x_max", ..., "z_max"
    Box(BoxArguments),
    /// A cylinder along z from z = 0: volume "bar", surfaces "foot", "top", "side" (and "symmetry_x", "symmetry_y" in a
    /// quarter), curve "axis"
    Cylinder(CylinderArguments),
    /// An eighth of the bar that necks: volume "bar", surfaces "symmetry_x", "symmetry_y", "symmetry_z", "grip",
    /// "side", curve "axis", point "neck"
    NeckingBar(NeckingBarArguments),
    /// Print counts, groups and quality of a mesh file
    Info {
        /// The mesh: Gmsh 4.1, 4.0 or 2.2 (.msh), Abaqus (.inp), or VTK (.vtu, .vtk)
        file: PathBuf,
    },
}

/// Where a mesh goes.
#[derive(Debug, Args)]
pub struct Target {
    /// The file to write (Gmsh 4.1), in metres
    #[arg(long, value_name = "FILE")]
    output: PathBuf,
    /// Elements: each hex stays one, or is cut into two wedges or six tets
    #[arg(long, value_parser = shape, default_value = "hex8", value_name = "hex8|wedge6|tet4|tet10")]
    shape: Shape,
    /// Write text instead of binary
    #[arg(long)]
    ascii: bool,
    /// Overwrite a file that is there
    #[arg(long)]
    force: bool,
}

/// A box.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct BoxArguments {
    /// Lengths along x, y, z: numbers in m or with a unit, such as 32.4mm
    #[arg(long, num_args = 3, value_names = ["X", "Y", "Z"], value_parser = length, default_values = ["1", "1", "1"])]
    size: Vec<f64>,
    /// Cells along x, y, z
    #[arg(long, num_args = 3, value_names = ["NX", "NY", "NZ"], default_values = ["10", "10", "10"])]
    cells: Vec<u32>,
    #[command(flatten)]
    target: Target,
}

/// A cylinder.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct CylinderArguments {
    /// Radius: a number in m or with a unit
    #[arg(long, value_parser = length, default_value = "3.2mm")]
    radius: f64,
    /// Length: a number in m or with a unit
    #[arg(long, value_parser = length, default_value = "32.4mm")]
    length: f64,
    /// The whole section instead of a quarter with symmetry planes
    #[arg(long)]
    full: bool,
    #[command(flatten)]
    section: SectionArguments,
    #[command(flatten)]
    target: Target,
}

/// A bar that necks.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct NeckingBarArguments {
    /// Length of the whole bar, of which half is meshed
    #[arg(long, value_parser = length, default_value = "53.334mm")]
    length: f64,
    /// Radius at the ends
    #[arg(long, value_parser = length, default_value = "6.413mm")]
    radius: f64,
    /// Radius at the middle over radius at the ends
    #[arg(long, default_value_t = 0.982)]
    neck_ratio: f64,
    #[command(flatten)]
    section: SectionArguments,
    #[command(flatten)]
    target: Target,
}

/// How a round bar is divided.
#[derive(Debug, Args)]
pub struct SectionArguments {
    /// Cells along each side of the core of a quarter
    #[arg(long, default_value_t = 4)]
    core_cells: u32,
    /// Rings of cells around the core
    #[arg(long, default_value_t = 3)]
    rings: u32,
    /// Cells along the axis
    #[arg(long, default_value_t = 40)]
    axial_cells: u32,
    /// Length of the last cell along the axis over that of the first
    #[arg(long, default_value_t = 1.0)]
    grading: f64,
}

impl SectionArguments {
    fn size(&self, is_full: bool) -> MeshSize {
        MeshSize::of_round_bar(is_full, self.core_cells, self.rings, self.axial_cells)
    }
}

/// A length of the command line, m.
fn length(text: &str) -> Result<f64, String> {
    let measured = units::parse(text).map_err(|error| error.to_string())?;
    match measured.dimension {
        Some(dimension) if dimension != Dimension::LENGTH => Err(format!("it is {dimension}, but a length is needed")),
        _ => Ok(measured.value),
    }
}

/// A shape that hexes can be cut into.
fn shape(text: &str) -> Result<Shape, String> {
    let shapes = [Shape::Hex8, Shape::Wedge6, Shape::Tet4, Shape::Tet10];
    let named = shapes.into_iter().find(|shape| shape.to_string() == text);
    named.ok_or_else(|| "it is none of hex8, wedge6, tet4, tet10".to_owned())
}

/// Does what the command says.
///
/// # Errors
/// An impossible size, a file that cannot be written or read, or a mesh that is none.
pub fn mesh(command: &MeshCommand) -> Result<(), Failure> {
    let impossible = |error: SpecError| Failure::Input(format!("error: {error}"));
    match command {
        MeshCommand::Box(arguments) => {
            let sizes = |values: &[f64]| [values[0], values[1], values[2]];
            let cells = [arguments.cells[0], arguments.cells[1], arguments.cells[2]];
            let spec = BoxSpec::new(sizes(&arguments.size), cells).map_err(impossible)?;
            write(&arguments.target, MeshSize::of_box(cells), || box_mesh(&spec))
        }
        MeshCommand::Cylinder(arguments) => {
            let spec = CylinderSpec::try_from(CylinderParameters {
                radius: arguments.radius,
                length: arguments.length,
                section: if arguments.full { Section::Full } else { Section::Quarter },
                core_cells: arguments.section.core_cells,
                radial_rings: arguments.section.rings,
                axial_cells: arguments.section.axial_cells,
                axial_grading: arguments.section.grading,
            })
            .map_err(impossible)?;
            write(&arguments.target, arguments.section.size(arguments.full), || cylinder(&spec))
        }
        MeshCommand::NeckingBar(arguments) => {
            let spec = NeckingBarSpec::try_from(NeckingBarParameters {
                full_length: arguments.length,
                end_radius: arguments.radius,
                neck_ratio: arguments.neck_ratio,
                core_cells: arguments.section.core_cells,
                radial_rings: arguments.section.rings,
                axial_cells: arguments.section.axial_cells,
                axial_grading: arguments.section.grading,
            })
            .map_err(impossible)?;
            write(&arguments.target, arguments.section.size(false), || necking_bar(&spec))
        }
        MeshCommand::Info { file } => info(file),
    }
}

/// A file is written where there is none, or an ordinary one that may be overwritten.
fn check_target(output: &Path, force: bool) -> Result<(), Failure> {
    if output.exists() && !force {
        let message = format!("error: {} is there already\nhelp: overwrite it with --force", output.display());
        return Err(Failure::Input(message));
    }
    // the new file takes the place of the old: a device or a link would be gone
    if output.symlink_metadata().is_ok_and(|metadata| !metadata.is_file()) {
        return Err(Failure::File(format!("error: {} is there and no ordinary file", output.display())));
    }
    Ok(())
}

fn write(target: &Target, size: MeshSize, mesh: impl FnOnce() -> Mesh) -> Result<(), Failure> {
    check_target(&target.output, target.force)?;
    if let Some(shortage) = memory::shortage_of_new_mesh(size, target.shape) {
        return Err(Failure::Input(format!("error: {shortage}\nhelp: {}", memory::HELP)));
    }
    let mesh = match target.shape {
        Shape::Hex8 => mesh(),
        shape => cut_into(&mesh(), shape),
    };
    estar_io::write_gmsh_file(&target.output, &mesh, !target.ascii).map_err(Failure::writing(&target.output))?;
    let (nodes, elements) = (mesh.node_count(), format::elements(&mesh, |number| number.to_string()));
    print(&format!("{}: {nodes} nodes, {elements}, in metres", target.output.display()))
}

fn read(file: &Path) -> Result<MeshFile, Failure> {
    if let Some(shortage) = memory::shortage_of_mesh(file) {
        return Err(Failure::Input(format!("error: {shortage}\nhelp: {}", memory::HELP)));
    }
    estar_io::read_mesh_within(file, memory::most_of_mesh()).map_err(|error| {
        let message = format!("error: {error}");
        if error.is_unreadable() { Failure::File(message) } else { Failure::Input(message) }
    })
}

/// What `estar convert` is to do.
#[derive(Debug, Args)]
pub struct ConvertArguments {
    /// The mesh: Gmsh 4.1, 4.0 or 2.2 (.msh), Abaqus (.inp), or VTK (.vtu, .vtk)
    file: PathBuf,
    /// The file to write (.vtu); the mesh's name with that ending unless given
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Overwrite a file that is there
    #[arg(long)]
    force: bool,
}

/// Writes a mesh for ParaView, with the numbers of nodes and elements and a field for each group.
///
/// # Errors
/// The mesh cannot be read, or the file cannot be written.
pub fn convert(arguments: &ConvertArguments) -> Result<(), Failure> {
    let MeshFile { mesh, warnings, .. } = read(&arguments.file)?;
    warnings.iter().for_each(|warning| tell(&format!("warning: {warning}\n")));
    let output = arguments.output.clone().unwrap_or_else(|| arguments.file.with_extension("vtu"));
    if output.extension().is_none_or(|ending| ending != "vtu") {
        let message = format!("error: {} does not end in .vtu, the format that is written", output.display());
        return Err(Failure::Input(message));
    }
    check_target(&output, arguments.force)?;
    let node_labels: Vec<i64> = mesh.node_labels().iter().map(|label| label.0 as i64).collect();
    let element_labels: Vec<i64> = mesh.element_labels().iter().map(|label| label.0 as i64).collect();
    // 1 in the group, 0 elsewhere
    let members = |count: usize, members: &[u32]| {
        let mut marks = vec![0_u8; count];
        members.iter().for_each(|&member| marks[member as usize] = 1);
        marks
    };
    let (volumes, others): (Vec<&Group>, Vec<&Group>) =
        mesh.groups().iter().partition(|group| group.kind == GroupKind::Volume);
    let (mut of_nodes, mut of_elements) = (Vec::new(), Vec::new());
    for group in others {
        add_field(&mut of_nodes, mesh.name_to_find(group, Wanted::Nodes), members(mesh.node_count(), &group.nodes));
    }
    for group in volumes {
        let name = mesh.name_to_find(group, Wanted::Elements);
        add_field(&mut of_elements, name, members(mesh.element_count(), &group.elements));
    }
    let node_fields = mesh_fields("node_id", &node_labels, &of_nodes);
    let cell_fields = mesh_fields("element_id", &element_labels, &of_elements);
    let refused = |error: WriteError| Failure::File(format!("error: {error}"));
    let grid = Grid::new(mesh.node_count(), mesh.elements(), &node_fields, &cell_fields).map_err(refused)?;
    let points = FieldData::F64(mesh.coordinates().as_flattened());
    let frame = Frame { time: 0.0, grid: &grid, points, node_fields: Vec::new(), cell_fields: Vec::new() };
    write_frame_file(&output, &frame).map_err(refused)?;
    let elements = format::elements(&mesh, |number| number.to_string());
    let groups = mesh.groups().len();
    print(&format!("{}: {} nodes, {elements}, {groups} groups", output.display(), mesh.node_count()))
}

/// Adds a group's marks. Groups that have one name to be found by have the same members: one field shows them.
fn add_field(fields: &mut Vec<(String, Vec<u8>)>, group: String, marks: Vec<u8>) {
    let name = format!("group {group}");
    if fields.iter().all(|(known, _)| *known != name) {
        fields.push((name, marks));
    }
}

/// The numbers of the user, and a mark for the members of each group.
fn mesh_fields<'a>(name: &'a str, labels: &'a [i64], groups: &'a [(String, Vec<u8>)]) -> Vec<Field<'a>> {
    let labels = Field { name, components: 1, data: FieldData::I64(labels) };
    let marks = groups.iter().map(|(name, marks)| Field { name, components: 1, data: FieldData::U8(marks) });
    std::iter::once(labels).chain(marks).collect()
}

fn info(file: &Path) -> Result<(), Failure> {
    let read = read(file)?;
    let mesh = &read.mesh;
    let mut text = String::new();
    let _ = writeln!(text, "{} ({})", file.display(), read.format);
    let _ = writeln!(text, "  {} nodes, {}", mesh.node_count(), format::elements(mesh, |number| number.to_string()));
    let _ = writeln!(
        text,
        "  numbers: nodes {}; elements {}",
        format::ranges(mesh.node_labels().iter().map(|node| node.0)),
        format::ranges(mesh.element_labels().iter().map(|element| element.0))
    );
    let [low, high] = mesh.extent();
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let _ = writeln!(text, "  {name} from {:.6e} to {:.6e}", low[axis], high[axis]);
    }
    let _ = writeln!(text, "  groups:");
    let names = mesh.full_names();
    let width = format::column_width(names.iter().map(String::as_str));
    for (group, name) in mesh.groups().iter().zip(&names) {
        let members = match (group.elements.len(), group.faces.len()) {
            (0, 0) => String::new(),
            (0, faces) => format!("{}, ", format::number_of(faces, "face", "faces")),
            (elements, _) => format!("{}, ", format::number_of(elements, "element", "elements")),
        };
        let nodes = format::number_of(group.nodes.len(), "node", "nodes");
        let _ = writeln!(text, "    {name:width$}  {:8} {members}{nodes}", group.kind);
    }
    let quality = QualityReport::new(mesh);
    let _ = write!(text, "  quality: {}", quality.summary());
    for warning in &read.warnings {
        let _ = writeln!(text, "  warning: {warning}");
    }
    // what makes a mesh unusable comes first
    if quality.errors().is_empty() {
        let connectivity = Connectivity::new(mesh);
        let count = connectivity.bodies.len();
        if count > 1 {
            let parts: [&[u32]; 0] = [];
            let all: Vec<usize> = (0..count).collect();
            let listed = Bodies::new(&connectivity, parts, []).listed(&all, "");
            let _ = writeln!(text, "  {count} bodies that share no nodes: {listed}");
        }
        for doubt in conformity::doubts(&Conformity::new(mesh, &connectivity), "") {
            let _ = writeln!(text, "  warning: {}\n    help: {}", doubt.message, doubt.help);
        }
    }
    const MOST_SHOWN: usize = 20;
    for error in quality.errors().iter().take(MOST_SHOWN) {
        let _ = writeln!(text, "  error: {error}");
    }
    print(&text)?;
    match quality.errors().len() {
        0 => Ok(()),
        count => {
            let faults = if count == 1 { "fault" } else { "faults" };
            Err(Failure::Input(format!("error: {}: the mesh has {count} {faults}", file.display())))
        }
    }
}
