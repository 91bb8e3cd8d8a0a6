//! Sets and surfaces: defined in any order, resolved when everything is known.

use std::collections::{HashMap, HashSet};

use estar_mesh::{Face, Group, GroupKind};

use super::{Element, Use};
use crate::assembly::NodeIndex;
use crate::error::{Located, Place, Problem};

/// What a set is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum SetKind {
    Nodes,
    Elements,
}

/// What a data line puts into a set.
#[derive(Debug, Clone)]
pub(super) enum Members {
    One(u64),
    Range { first: u64, last: u64, step: u64 },
    Set(String),
    NodesOf(String),
}

#[derive(Debug)]
pub(super) struct SetDefinition {
    pub members: Vec<Members>,
    /// Made by Abaqus/CAE for its own surfaces: not a group.
    pub is_internal: bool,
    pub line: u64,
}

#[derive(Debug)]
pub(super) struct SurfaceDefinition {
    pub name: String,
    /// Elements and the face of each, S1 being 0.
    pub faces: Vec<(Members, usize)>,
    pub line: u64,
}

/// The elements of the file, found by their numbers.
#[derive(Debug)]
pub(super) struct Elements<'a> {
    list: &'a [Element],
    position: HashMap<u64, usize>,
}

impl<'a> Elements<'a> {
    pub fn new(list: &'a [Element]) -> Self {
        Self { list, position: list.iter().enumerate().map(|(k, element)| (element.label, k)).collect() }
    }

    fn get(&self, label: u64) -> Option<&'a Element> {
        self.position.get(&label).map(|position| &self.list[*position])
    }
}

/// All definitions of a file.
#[derive(Debug, Default)]
pub(super) struct Sets {
    /// In the order of the file. A name may come twice: the second adds to the first.
    definitions: Vec<(SetKind, String, SetDefinition)>,
    pub surfaces: Vec<SurfaceDefinition>,
    pub passed_over_elements: HashSet<u64>,
}

/// Members by number, ascending, of sets by kind and name in capitals.
type Resolved = HashMap<(SetKind, String), Vec<u64>>;

impl Sets {
    pub fn define(&mut self, kind: SetKind, name: String, definition: SetDefinition) {
        self.definitions.push((kind, name, definition));
    }

    /// The groups: element sets, then surfaces, then node sets.
    pub fn groups(
        &self,
        nodes: &NodeIndex,
        elements: &Elements,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<Group>, Located> {
        let resolved = self.resolved(nodes, elements)?;
        let mut groups = Groups { list: Vec::new(), taken: HashMap::new(), warnings };
        let named = |kind: SetKind| {
            let mut seen = HashSet::new();
            self.definitions.iter().filter(move |(its_kind, name, definition)| {
                *its_kind == kind && !definition.is_internal && seen.insert(name.to_ascii_uppercase())
            })
        };
        for (kind, name, definition) in named(SetKind::Elements) {
            let labels = &resolved[&(*kind, name.to_ascii_uppercase())];
            match self.element_group(name, labels, nodes, elements) {
                Some(group) => groups.add(group, "_elements"),
                None if labels.is_empty() => return Err(empty(name, GroupKind::Volume, definition.line)),
                None => groups.warnings.push(format!("the set \"{name}\" has only elements that are passed over")),
            }
        }
        for surface in &self.surfaces {
            groups.add(surface_group(surface, nodes, elements, &resolved)?, "_surface");
        }
        for (kind, name, definition) in named(SetKind::Nodes) {
            let labels = &resolved[&(*kind, name.to_ascii_uppercase())];
            if labels.is_empty() {
                return Err(empty(name, GroupKind::Point, definition.line));
            }
            let mut indices: Vec<u32> = labels.iter().filter_map(|label| nodes.get(*label)).collect();
            indices.sort_unstable();
            // Abaqus/CAE writes the nodes of an element set under its name: that group has them already.
            let namesake = groups.taken.get(&name.to_ascii_uppercase()).map(|position| &groups.list[*position]);
            if namesake.is_none_or(|group| group.nodes != indices) {
                groups.add(Group::point(name.as_str(), indices), "_nodes");
            }
        }
        Ok(groups.list)
    }

    /// The members of every set. A set may name only sets before it, so that this ends.
    fn resolved(&self, nodes: &NodeIndex, elements: &Elements) -> Result<Resolved, Located> {
        let mut resolved = Resolved::new();
        for (kind, name, definition) in &self.definitions {
            let mut labels = Vec::new();
            for member in &definition.members {
                if let Members::NodesOf(set) = member {
                    let key = (SetKind::Elements, set.to_ascii_uppercase());
                    let of_set = resolved.get(&key).ok_or_else(|| missing(name, "set", set, definition.line))?;
                    let used = of_set.iter().filter_map(|label| elements.get(*label));
                    labels.extend(used.flat_map(|element| &element.nodes));
                    continue;
                }
                for_each_label(member, *kind, name, definition.line, &resolved, &mut |label| {
                    let (known, what) = match kind {
                        SetKind::Nodes => (nodes.get(label).is_some(), "node"),
                        SetKind::Elements => {
                            let known = elements.get(label).is_some() || self.passed_over_elements.contains(&label);
                            (known, "element")
                        }
                    };
                    labels.push(label);
                    if known { Ok(()) } else { Err(missing(name, what, &label.to_string(), definition.line)) }
                })?;
            }
            let all = resolved.entry((*kind, name.to_ascii_uppercase())).or_default();
            all.extend(labels);
            all.sort_unstable();
            all.dedup();
        }
        Ok(resolved)
    }

    /// The group of an element set, of the greatest dimension that it has elements of.
    fn element_group(&self, name: &str, labels: &[u64], nodes: &NodeIndex, elements: &Elements) -> Option<Group> {
        let members = || labels.iter().filter_map(|label| elements.get(*label));
        let solids = || members().filter(|element| matches!(element.usage, Use::Solid(_)));
        let faces = || members().filter(|element| matches!(element.usage, Use::Face(_)));
        let lines = || members().filter(|element| matches!(element.usage, Use::Line(_)));
        // nodes were found when the elements were made
        let face = |element: &Element| Face::new(&nodes.nodes(element.label, &element.nodes).ok()?);
        let (mut group, labels): (Group, Vec<u64>) = if solids().next().is_some() {
            let group = Group::volume(name, solids().map(|element| element.index).collect());
            (group, solids().flat_map(|element| element.nodes.iter().copied()).collect())
        } else if faces().next().is_some() {
            let group = Group::surface(name, faces().filter_map(face));
            (group, faces().flat_map(|element| element.nodes.iter().copied()).collect())
        } else if lines().next().is_some() {
            (Group::curve(name, Vec::new()), lines().flat_map(|element| element.nodes.iter().copied()).collect())
        } else {
            return None;
        };
        group.nodes = labels.into_iter().filter_map(|label| nodes.get(label)).collect();
        group.nodes.sort_unstable();
        group.nodes.dedup();
        Some(group)
    }
}

/// Groups whose names must differ, whatever their kind.
struct Groups<'a> {
    list: Vec<Group>,
    taken: HashMap<String, usize>,
    warnings: &'a mut Vec<String>,
}

impl Groups<'_> {
    /// Adds a group; one whose name is taken gets the suffix, as often as it takes.
    fn add(&mut self, mut group: Group, suffix: &str) {
        let name = group.name.clone();
        while self.taken.contains_key(&group.name.to_ascii_uppercase()) {
            group.name += suffix;
        }
        if group.name != name {
            let message = format!("\"{name}\" names two things; the {} group is called \"{}\"", group.kind, group.name);
            self.warnings.push(message);
        }
        self.taken.insert(group.name.to_ascii_uppercase(), self.list.len());
        self.list.push(group);
    }
}

fn surface_group(
    surface: &SurfaceDefinition,
    nodes: &NodeIndex,
    elements: &Elements,
    resolved: &Resolved,
) -> Result<Group, Located> {
    let (name, line) = (&surface.name, surface.line);
    let mut faces = Vec::new();
    for (member, face) in &surface.faces {
        for_each_label(member, SetKind::Elements, name, line, resolved, &mut |label| {
            let solid = elements.get(label).ok_or_else(|| missing(name, "solid element", &label.to_string(), line))?;
            let Use::Solid(shape) = solid.usage else {
                return Err(missing(name, "solid element", &label.to_string(), line));
            };
            // Abaqus numbers the faces as they are listed here
            let Some(places) = shape.faces().get(*face) else {
                return Err(missing(name, "face", &format!("S{} of the {shape} {label}", face + 1), line));
            };
            let labels: Vec<u64> = places.iter().map(|&place| solid.nodes[place]).collect();
            let of_face = nodes.nodes(label, &labels).map_err(|problem| problem.at(Place::Line(line)))?;
            faces.extend(Face::new(&of_face));
            Ok(())
        })?;
    }
    if faces.is_empty() {
        return Err(empty(name, GroupKind::Surface, line));
    }
    let mut group = Group::surface(name.as_str(), faces);
    group.nodes = group.faces.iter().flat_map(Face::nodes).copied().collect();
    group.nodes.sort_unstable();
    group.nodes.dedup();
    Ok(group)
}

/// Hands on every number that a member stands for, until one is refused: a range ends at its first missing number.
fn for_each_label(
    member: &Members,
    kind: SetKind,
    name: &str,
    line: u64,
    resolved: &Resolved,
    hand_on: &mut dyn FnMut(u64) -> Result<(), Located>,
) -> Result<(), Located> {
    match member {
        Members::One(label) => hand_on(*label),
        Members::Range { first, last, step } => {
            let mut label = *first;
            while label <= *last {
                hand_on(label)?;
                match label.checked_add(*step) {
                    Some(next) => label = next,
                    None => break,
                }
            }
            Ok(())
        }
        Members::Set(set) | Members::NodesOf(set) => {
            let labels = resolved.get(&(kind, set.to_ascii_uppercase()));
            labels.ok_or_else(|| missing(name, "set", set, line))?.iter().try_for_each(|label| hand_on(*label))
        }
    }
}

fn missing(group: &str, what: &'static str, label: &str, line: u64) -> Located {
    Problem::MissingMember { group: group.to_owned(), what, label: label.to_owned() }.at(Place::Line(line))
}

fn empty(name: &str, kind: GroupKind, line: u64) -> Located {
    Problem::EmptyGroup { name: name.to_owned(), kind }.at(Place::Line(line))
}
