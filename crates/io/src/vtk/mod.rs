//! Meshes of VTK that other programs write: `.vtu` and `.vtk`, from the cells and their arrays to elements and groups.
//!
//! VTK has no groups. Programs write them as arrays of whole numbers, one for each cell or point: a number that stands for a
//! part, a material or a set gives a group here, which is named after the array and the number. Nodes and cells are known by
//! the numbers that ParaView shows, from 0, unless the file has an array of numbers for them.

mod binary;
mod cell_type;
mod legacy;
mod xml;

use std::collections::{BTreeMap, HashSet};

use estar_mesh::quality::volume;
use estar_mesh::{ElementLabel, Face, Group, GroupKind, MeshError, NodeLabel, Shape};

use crate::MeshFile;
use crate::assembly::Assembly;
use crate::error::{Located, Place, Problem, and_more, excerpt, visible_name};
use cell_type::Use;

/// An array of more numbers than this that differ gives no groups: it numbers things.
const MOST_GROUPS: usize = 1000;

/// Reads `.vtu`, whose arrays are unpacked to so many bytes at most.
pub(crate) fn read_xml(bytes: &[u8], limit: u64) -> Result<MeshFile, Located> {
    let (pieces, format) = xml::read(bytes, limit)?;
    mesh_of(pieces, format).map_err(|problem| problem.at(Place::File))
}

/// Reads `.vtk`, if twice its bytes are within the limit.
pub(crate) fn read_legacy(bytes: &[u8], limit: u64) -> Result<MeshFile, Located> {
    // its cells have four bytes a node, and eight here
    if 2 * bytes.len() as u64 > limit {
        return Err(Problem::NoMemory { limit }.at(Place::File));
    }
    let (piece, format) = legacy::read(bytes)?;
    mesh_of(vec![piece], format).map_err(|problem| problem.at(Place::File))
}

/// What a mesh is made of, of one piece of an unstructured grid.
#[derive(Debug, Default)]
struct Piece {
    points: Vec<[f64; 3]>,
    /// The points of all cells, one cell after another.
    connectivity: Vec<i64>,
    /// Where the points of each cell end in `connectivity`.
    ends: Vec<i64>,
    /// VTK's number of the type of each cell.
    types: Vec<i64>,
    node_arrays: Vec<Numbers>,
    cell_arrays: Vec<Numbers>,
    /// The names of arrays that are not one whole number for each.
    passed_over: Vec<String>,
}

/// An array of one whole number for each point or cell.
#[derive(Debug)]
struct Numbers {
    name: String,
    values: Vec<i64>,
}

/// What an array of whole numbers says.
enum Role {
    /// Which cells are there a second time, or hidden.
    Ghosts,
    /// The numbers by which nodes or elements are known.
    Labels,
    /// 1 in the group of this name, 0 elsewhere: as `estar convert` writes it.
    Mark(String),
    /// A group for each number.
    Groups,
}

impl Role {
    fn of(array: &str) -> Self {
        /// As this program, VTK, ParaView's filters and its reader of Exodus call them.
        const LABELS: [&str; 12] = [
            "node_id",
            "element_id",
            "GlobalIds",
            "GlobalNodeId",
            "GlobalElementId",
            "GlobalPointIds",
            "GlobalCellIds",
            "PedigreeIds",
            "PedigreeNodeId",
            "PedigreeElementId",
            "vtkOriginalPointIds",
            "vtkOriginalCellIds",
        ];
        match array.strip_prefix("group ") {
            Some(name) if !name.is_empty() => Self::Mark(name.to_owned()),
            _ if array == "vtkGhostType" => Self::Ghosts,
            _ if LABELS.contains(&array) => Self::Labels,
            _ => Self::Groups,
        }
    }
}

/// A group by the array it comes from, its kind, and its number in the array.
type Key = (usize, GroupKind, i64);

/// An array that gives groups.
struct Source {
    name: String,
    role: Role,
    group_count: usize,
}

/// The groups of arrays, filled cell by cell.
#[derive(Default)]
struct ArrayGroups {
    sources: Vec<Source>,
    groups: BTreeMap<Key, Group>,
}

impl ArrayGroups {
    /// The place of an array, by which groups are asked for.
    fn source(&mut self, name: &str) -> usize {
        self.sources.iter().position(|source| source.name == name).unwrap_or_else(|| {
            self.sources.push(Source { name: name.to_owned(), role: Role::of(name), group_count: 0 });
            self.sources.len() - 1
        })
    }

    /// The group of a number, unless there is none of it or the array has too many.
    fn group(&mut self, source: usize, kind: GroupKind, number: i64) -> Option<&mut Group> {
        let Source { name, role, group_count } = &mut self.sources[source];
        let is_none = matches!(role, Role::Mark(_)) && number == 0;
        if is_none || *group_count > MOST_GROUPS {
            return None;
        }
        Some(self.groups.entry((source, kind, number)).or_insert_with(|| {
            *group_count += 1;
            let by_kind = || format!("{}_{number}", kind.qualifier());
            let (name, owners) = match (role, name.as_str()) {
                (Role::Mark(name), _) => (name.clone(), Vec::new()),
                (_, "gmsh:physical") => (by_kind(), vec!["physical".to_owned()]),
                (_, "gmsh:geometrical" | "CellEntityIds") => (by_kind(), vec!["entity".to_owned()]),
                (_, name) => (format!("{name}_{number}"), vec![name.to_owned()]),
            };
            Group { owners, ..Group::new(name, kind) }
        }))
    }

    fn finish(self, warnings: &mut Vec<String>) -> Result<Vec<Group>, Problem> {
        let is_too_long = |source: usize| self.sources[source].group_count > MOST_GROUPS;
        let too_long = (0..self.sources.len()).filter(|source| is_too_long(*source));
        let too_long: Vec<String> = too_long.map(|source| quoted(&self.sources[source].name)).collect();
        if !too_long.is_empty() {
            let list = and_more(too_long);
            warnings.push(format!("arrays of more than {MOST_GROUPS} numbers that differ make no groups: {list}"));
        }
        let groups = self.groups.into_iter().filter(|((source, ..), _)| !is_too_long(*source));
        // the group of all elements is made for every mesh
        let groups = groups.map(|(_, group)| group).filter(|group| group.name != "all");
        groups.map(|group| Ok(Group { name: visible_name(&group.name)?, ..group })).collect()
    }
}

fn quoted(name: &str) -> String {
    format!("\"{}\"", excerpt(name.as_bytes()))
}

/// What is counted to be told.
#[derive(Default)]
struct Tally {
    /// By VTK's number of the type: how many cells of no use, and the first.
    left_out: BTreeMap<i64, (u64, u64)>,
    /// The same of solids that cannot be used.
    unsupported: BTreeMap<i64, (u64, u64)>,
    ghosts: u64,
    turned_wedges: u64,
    /// Faces, lines and vertices in no group.
    nameless: u64,
    passed_over: Vec<String>,
}

/// A mesh on its way from pieces.
#[derive(Default)]
struct Maker {
    assembly: Assembly,
    groups: ArrayGroups,
    tally: Tally,
    /// The number of each point and solid by an array of the file; none if a piece has no such array.
    node_labels: Option<Vec<i64>>,
    element_labels: Option<Vec<i64>>,
    /// Cells of all pieces so far.
    cell_count: u64,
}

fn mesh_of(pieces: Vec<Piece>, format: String) -> Result<MeshFile, Problem> {
    let mut maker = Maker { node_labels: Some(Vec::new()), element_labels: Some(Vec::new()), ..Maker::default() };
    let piece_count = pieces.len();
    for piece in pieces {
        maker.add(piece)?;
    }
    maker.finish(piece_count, format)
}

/// The array of a piece by which its points or cells are numbered.
fn labels(arrays: &[Numbers]) -> Option<&Numbers> {
    arrays.iter().find(|array| matches!(Role::of(&array.name), Role::Labels))
}

impl Maker {
    fn add(&mut self, piece: Piece) -> Result<(), Problem> {
        let cell_count = piece.types.len();
        if piece.ends.len() != cell_count {
            let (announced, found) = (piece.ends.len() as u64, cell_count as u64);
            return Err(Problem::CountMismatch { what: "cells", announced, found });
        }
        for (arrays, count) in [(&piece.node_arrays, piece.points.len()), (&piece.cell_arrays, cell_count)] {
            if let Some(array) = arrays.iter().find(|array| array.values.len() != count) {
                let what = format!("has {} numbers instead of {count}", array.values.len());
                return Err(Problem::Array { array: excerpt(array.name.as_bytes()), what });
            }
        }
        let first_node = self.assembly.coordinates.len();
        let node_count = piece.points.len();
        if first_node + node_count > u32::MAX as usize {
            let (what, count, limit) = ("nodes", first_node + node_count, u32::MAX as usize);
            return Err(Problem::Mesh(MeshError::TooLarge { what, count, limit }));
        }
        self.assembly.coordinates.extend_from_slice(&piece.points);
        self.node_labels = self.node_labels.take().zip(labels(&piece.node_arrays)).map(|(mut all, array)| {
            all.extend_from_slice(&array.values);
            all
        });
        for array in
            piece.node_arrays.iter().filter(|array| !matches!(Role::of(&array.name), Role::Labels | Role::Ghosts))
        {
            let source = self.groups.source(&array.name);
            for (node, &number) in (first_node as u32..).zip(&array.values) {
                if let Some(group) = self.groups.group(source, GroupKind::Nodes, number) {
                    group.nodes.push(node);
                }
            }
        }
        self.add_cells(&piece, first_node as u32)?;
        self.cell_count += cell_count as u64;
        self.tally.passed_over.extend(piece.passed_over);
        Ok(())
    }

    fn add_cells(&mut self, piece: &Piece, first_node: u32) -> Result<(), Problem> {
        /// vtkDataSetAttributes::DUPLICATECELL and HIDDENCELL.
        const NOT_THERE: i64 = 1 | 32;
        let numbers = labels(&piece.cell_arrays);
        if numbers.is_none() {
            self.element_labels = None;
        }
        let ghosts = piece.cell_arrays.iter().find(|array| matches!(Role::of(&array.name), Role::Ghosts));
        let of_groups = |array: &&Numbers| !matches!(Role::of(&array.name), Role::Labels | Role::Ghosts);
        let of_groups: Vec<(usize, &[i64])> = piece
            .cell_arrays
            .iter()
            .filter(of_groups)
            .map(|array| (self.groups.source(&array.name), &array.values[..]))
            .collect();
        let mut start = 0;
        let mut nodes = Vec::new();
        for (cell, (&code, &end)) in piece.types.iter().zip(&piece.ends).enumerate() {
            let label = self.cell_count + cell as u64;
            let of_cell = usize::try_from(end).ok().and_then(|end| piece.connectivity.get(start..end));
            let of_cell = of_cell.ok_or_else(|| {
                let what =
                    format!("ends cell {label} at {end}, of {} points that all cells have", piece.connectivity.len());
                Problem::Array { array: "offsets".to_owned(), what }
            })?;
            start += of_cell.len();
            if ghosts.is_some_and(|ghosts| ghosts.values[cell] & NOT_THERE != 0) {
                self.tally.ghosts += 1;
                continue;
            }
            nodes.clear();
            for &node in of_cell {
                // fits: the points of all pieces are counted by 32 bits
                match usize::try_from(node) {
                    Ok(index) if index < piece.points.len() => nodes.push(first_node + index as u32),
                    _ => {
                        let node = node.to_string();
                        return Err(Problem::NoSuchPoint { cell: label, node, count: piece.points.len() });
                    }
                }
            }
            let usage = cell_type::usage(code, nodes.len());
            let usage = usage.ok_or_else(|| Problem::CellSize {
                cell: label,
                kind: cell_type::name(code),
                found: nodes.len(),
            })?;
            let group_kind = match usage {
                Use::Solid(_) => GroupKind::Volume,
                Use::Face => GroupKind::Surface,
                Use::Line => GroupKind::Curve,
                Use::Point => GroupKind::Point,
                Use::LeftOut | Use::Unsupported => {
                    let tally = &mut self.tally;
                    let by_type = if usage == Use::LeftOut { &mut tally.left_out } else { &mut tally.unsupported };
                    by_type.entry(code).or_insert((0, label)).0 += 1;
                    continue;
                }
            };
            cell_type::put_in_order(code, &mut nodes);
            if let Use::Solid(shape) = usage {
                self.turn_wedge(shape, &mut nodes);
                self.assembly.add(label, shape, &nodes);
                if let (Some(all), Some(array)) = (&mut self.element_labels, numbers) {
                    all.push(array.values[cell]);
                }
            }
            let solid = self.assembly.elements.len() as u32;
            let mut is_named = false;
            for &(source, values) in &of_groups {
                let Some(group) = self.groups.group(source, group_kind, values[cell]) else { continue };
                is_named = true;
                match group_kind {
                    GroupKind::Volume => group.elements.push(solid - 1),
                    GroupKind::Surface => group.faces.extend(Face::new(&nodes)),
                    _ => group.nodes.extend_from_slice(&nodes),
                }
            }
            if !is_named && group_kind != GroupKind::Volume {
                self.tally.nameless += 1;
            }
        }
        Ok(())
    }

    /// VTK's documents and its shape functions do not agree which triangle of a wedge comes first, and programs write both: a
    /// wedge of negative volume has the other.
    fn turn_wedge(&mut self, shape: Shape, nodes: &mut [u32]) {
        if shape != Shape::Wedge6 {
            return;
        }
        let positions: Vec<[f64; 3]> = nodes.iter().map(|&node| self.assembly.coordinates[node as usize]).collect();
        if volume(shape, &positions) < 0.0 {
            nodes.rotate_left(3);
            self.tally.turned_wedges += 1;
        }
    }

    fn finish(mut self, piece_count: usize, format: String) -> Result<MeshFile, Problem> {
        if !self.tally.unsupported.is_empty() {
            let list = self.tally.unsupported.iter();
            let list = list.map(|(code, (count, first))| cell_type::unsupported(*code, *count, *first));
            return Err(Problem::UnsupportedElements(list.collect()));
        }
        let assembly = &mut self.assembly;
        let warnings = &mut assembly.warnings;
        let nodes = numbered(self.node_labels, assembly.coordinates.len(), "points", warnings);
        assembly.node_labels = match nodes {
            Some(labels) => labels.into_iter().map(NodeLabel).collect(),
            None => (0..assembly.coordinates.len() as u64).map(NodeLabel).collect(),
        };
        let elements = numbered(self.element_labels, assembly.elements.len(), "cells", warnings);
        if let Some(labels) = elements {
            assembly.element_labels = labels.into_iter().map(ElementLabel).collect();
        }
        if piece_count > 1 {
            warnings.push(format!(
                "the file has {piece_count} pieces, which have no nodes in common: [mesh] merge joins those at one place"
            ));
        }
        self.tally.tell(warnings);
        if assembly.elements.is_empty() && self.cell_count > 0 {
            let types = "faces, lines or points".to_owned();
            return Err(Problem::NoSolids { types });
        }
        assembly.groups = self.groups.finish(warnings)?;
        self.assembly.finish(format)
    }
}

/// The numbers of an array, if each is there once and none is negative; what is wrong with them is told.
fn numbered(labels: Option<Vec<i64>>, count: usize, of: &str, warnings: &mut Vec<String>) -> Option<Vec<u64>> {
    let labels = labels.filter(|labels| labels.len() == count && count > 0)?;
    let mut seen = HashSet::with_capacity(count);
    let unique: Option<Vec<u64>> =
        labels.iter().map(|&label| u64::try_from(label).ok().filter(|label| seen.insert(*label))).collect();
    if unique.is_none() {
        warnings
            .push(format!("the array that numbers the {of} has a number twice or below 0: they are numbered from 0"));
    }
    unique
}

impl Tally {
    fn tell(self, warnings: &mut Vec<String>) {
        if !self.left_out.is_empty() {
            let list = self.left_out.iter().map(|(code, (count, _))| format!("{count} {}", cell_type::name(*code)));
            warnings.push(format!(
                "cells that are neither solids nor faces or lines that name groups are left out: {}",
                and_more(list)
            ));
        }
        let counted = [
            (
                self.ghosts,
                [
                    "cell is marked as double or hidden (vtkGhostType), and is left out",
                    "cells are marked as doubles or hidden (vtkGhostType), and are left out",
                ],
            ),
            (
                self.turned_wedges,
                [
                    "wedge has the other triangle first, and is turned",
                    "wedges have the other triangle first, and are turned",
                ],
            ),
            (
                self.nameless,
                [
                    "face, line or vertex is in no group, and is left out",
                    "faces, lines or vertices are in no group, and are left out",
                ],
            ),
        ];
        let counted = counted.iter().filter(|(count, _)| *count > 0);
        warnings
            .extend(counted.map(|(count, [one, many])| format!("{count} {}", if *count == 1 { one } else { many })));
        if !self.passed_over.is_empty() {
            let mut names = self.passed_over;
            names.sort_unstable();
            names.dedup();
            let list = and_more(names.iter().map(|name| quoted(name)));
            warnings.push(format!(
                "only the mesh is read; arrays passed over, since they have not one whole number each: {list}"
            ));
        }
    }
}
