//! From what an Abaqus file says to a mesh.

use std::collections::HashMap;

use estar_mesh::NodeLabel;

use super::element_type::Use;
use super::placement::Placement;
use super::scope::{Index, Scope};
use super::sets::{Body, GroupMaker};
use super::{Instance, Reader, is_solid};
use crate::MeshFile;
use crate::assembly::Assembly;
use crate::error::{Located, Place, Problem, Unsupported, and_more};

/// Nodes, and elements, that instances of parts may make together: a short file could ask for any number.
const MOST_COPIES: u64 = 10_000_000;

/// A scope and where it is placed, before its numbers are known.
struct Placed {
    scope: usize,
    placement: Placement,
    instance: Option<String>,
    owners: Vec<String>,
}

impl Reader {
    pub(super) fn mesh_file(mut self) -> Result<MeshFile, Located> {
        self.refuse_unsupported()?;
        let mut assembly = Assembly::default();
        let is_flat = self.parts.is_empty() && self.instances.is_empty();
        let outer = std::mem::take(&mut self.outer);
        let (mut scopes, mut placed) = self.instanced()?;
        let instance_count = placed.len();
        let owners = if is_flat { Vec::new() } else { vec!["assembly".to_owned()] };
        placed.push(Placed { scope: scopes.len(), placement: Placement::default(), instance: None, owners });
        scopes.push(outer);

        let indices = scopes.iter().map(Index::new).collect::<Result<Vec<_>, _>>()?;
        let offsets = label_offsets(&scopes, &placed)?;
        let mut bodies = Vec::with_capacity(placed.len());
        let mut element_offset = 0;
        for (body, (node_offset_of_labels, element_offset_of_labels)) in placed.iter().zip(&offsets) {
            let (scope, index) = (&scopes[body.scope], &indices[body.scope]);
            // copies are limited, and what is written out takes more bytes than there are numbers
            let node_offset = assembly.coordinates.len() as u32;
            let solid_offset = assembly.elements.len() as u32;
            assembly.node_labels.extend(scope.node_labels.iter().map(|label| NodeLabel(label + node_offset_of_labels)));
            let is_moved = body.placement != Placement::default();
            let place = |x: &[f64; 3]| if is_moved { body.placement.apply(*x) } else { *x };
            assembly.coordinates.extend(scope.coordinates.iter().map(place));
            for element in &scope.elements {
                if let Use::Solid(shape) = element.usage {
                    let nodes = index.nodes_of(element, node_offset);
                    assembly.add(element.label + element_offset_of_labels, shape, &nodes);
                }
            }
            let (instance, owners) = (body.instance.clone(), body.owners.clone());
            bodies.push(Body { scope, index, instance, owners, node_offset, element_offset, solid_offset });
            element_offset += scope.elements.len() as u32;
        }
        self.refuse_joints(&bodies, &assembly)?;
        self.tell_what_is_left_out(&placed, &offsets, &mut assembly.warnings);
        if assembly.elements.is_empty() {
            return Err(self.no_solids().at(Place::File));
        }
        let maker = GroupMaker::new(&bodies, instance_count, &assembly.elements);
        let groups = maker.groups(&mut assembly.warnings)?;
        assembly.groups = groups;
        assembly.finish("Abaqus".into()).map_err(|problem| problem.at(Place::File))
    }

    fn refuse_unsupported(&self) -> Result<(), Located> {
        let unsupported: Vec<_> =
            self.others.iter().filter(|(_, tally)| matches!(tally.usage, Use::Unsupported(_))).collect();
        let Some((_, first)) = unsupported.first() else { return Ok(()) };
        let list = unsupported.iter().map(|(kind, tally)| Unsupported {
            kind: format!("of type {kind}"),
            count: tally.count,
            first: tally.first,
            advice: if let Use::Unsupported(advice) = tally.usage { advice } else { "" },
        });
        Err(first.origin.fail(Problem::UnsupportedElements(list.collect())))
    }

    /// An error if what holds solids together would be left out.
    fn refuse_joints(&self, bodies: &[Body], assembly: &Assembly) -> Result<(), Located> {
        if !self.others.values().any(|tally| tally.usage == Use::Joint) {
            return Ok(());
        }
        let mut is_of_solid = vec![false; assembly.coordinates.len()];
        for &node in assembly.elements.all_nodes() {
            is_of_solid[node as usize] = true;
        }
        for body in bodies {
            for element in body.scope.elements.iter().filter(|element| element.usage == Use::Joint) {
                let nodes = &body.index.element_nodes[element.nodes.clone()];
                let mut known = nodes.iter().filter(|node| **node != u32::MAX);
                if known.any(|node| is_of_solid[(node + body.node_offset) as usize]) {
                    let types = self.others.iter().filter(|(_, tally)| tally.usage == Use::Joint);
                    let types = and_more(types.map(|(name, tally)| format!("{} of type {name}", tally.count)));
                    let problem = Problem::Joints { types, first: element.label };
                    return Err(element.origin.fail(problem));
                }
            }
        }
        Ok(())
    }

    fn no_solids(&self) -> Problem {
        let types = and_more(self.others.iter().map(|(name, tally)| format!("{} of type {name}", tally.count)));
        if types.is_empty() { Problem::Mesh(estar_mesh::MeshError::NoElements) } else { Problem::NoSolids { types } }
    }

    /// The scopes of parts as they are instanced, and the instances. Without an instance each part stands where it was made.
    fn instanced(&mut self) -> Result<(Vec<Scope>, Vec<Placed>), Located> {
        let instances = std::mem::take(&mut self.instances);
        let mut scopes: Vec<Scope> = Vec::new();
        let mut placed = Vec::new();
        if instances.is_empty() {
            let is_alone = self.parts.len() == 1;
            for (name, part) in &mut self.parts {
                let (placement, owners) = (Placement::default(), owners(is_alone, None, name));
                placed.push(Placed { scope: scopes.len(), placement, instance: None, owners });
                scopes.push(std::mem::take(part));
            }
            return Ok((scopes, placed));
        }
        let of_name = |name: &str| self.parts.iter().position(|(part, _)| part.eq_ignore_ascii_case(name));
        let part_of = |instance: &Instance| {
            let message = || format!("there is no *PART with the name {}", instance.part);
            of_name(&instance.part).ok_or_else(|| instance.origin.fail(Problem::Syntax { message: message() }))
        };
        let mut uses = vec![0_u64; self.parts.len()];
        let (mut nodes, mut elements) = (0, 0);
        for instance in &instances {
            let part = part_of(instance)?;
            uses[part] += 1;
            if uses[part] > 1 {
                nodes += self.parts[part].1.node_labels.len() as u64;
                elements += self.parts[part].1.elements.len() as u64;
            }
            if nodes.max(elements) > MOST_COPIES {
                let what =
                    format!("more than {} million nodes or elements in copies of parts", MOST_COPIES / 1_000_000);
                return Err(instance.origin.fail(Problem::NotSupported { what, advice: "write a flat input file" }));
            }
        }
        let unused: Vec<String> =
            self.parts.iter().zip(&uses).filter(|(_, count)| **count == 0).map(|((name, _), _)| name.clone()).collect();
        for name in unused {
            *self.passed_over.entry(format!("PART, NAME={name}, which has no instance")).or_default() += 1;
        }
        let is_alone = instances.len() == 1;
        let mut whole: HashMap<usize, usize> = HashMap::new();
        for instance in instances {
            let part = part_of(&instance)?;
            let owners = owners(is_alone, instance.name.as_deref(), &self.parts[part].0);
            let scope = match whole.get(&part) {
                Some(&scope) if instance.own.is_empty() => scope,
                _ => {
                    let scope = scopes.len();
                    if instance.own.is_empty() {
                        whole.insert(part, scope);
                    }
                    let of_part = &self.parts[part].1;
                    scopes.push(if of_part.is_empty() { instance.own } else { of_part.with(&instance.own) });
                    scope
                }
            };
            placed.push(Placed { scope, placement: instance.placement, instance: instance.name, owners });
        }
        Ok((scopes, placed))
    }

    fn tell_what_is_left_out(&self, placed: &[Placed], offsets: &[(u64, u64)], warnings: &mut Vec<String>) {
        let others = self.others.iter().filter(|(_, tally)| !is_solid(tally.usage));
        let others: Vec<String> = others.map(|(name, tally)| format!("{} {name}", tally.count)).collect();
        if !others.is_empty() {
            let list = and_more(others);
            warnings.push(format!(
                "elements that are no solids are left out (sets of them may name faces or nodes): {list}"
            ));
        }
        let shifted = placed.iter().zip(offsets).filter(|(_, offset)| **offset != (0, 0));
        let shifted: Vec<String> = shifted
            .map(|(body, (nodes, elements))| format!("{} (nodes + {nodes}, elements + {elements})", body.owners[0]))
            .collect();
        if !shifted.is_empty() {
            let list = and_more(shifted);
            warnings.push(format!("instances have the same numbers, so that those of some are larger here: {list}"));
        }
        if !self.passed_over.is_empty() {
            let times = |(name, count): (&String, &u64)| match count {
                1 => format!("*{name}"),
                count => format!("*{name} ({count} times)"),
            };
            let list = self.passed_over.iter().map(times).collect::<Vec<_>>().join(", ");
            let joins: Vec<String> =
                self.passed_over.keys().filter(|name| joins_bodies(name)).map(|name| format!("*{name}")).collect();
            let apart = match joins.join(", ") {
                none if none.is_empty() => String::new(),
                joins => format!("; what {joins} would join comes apart"),
            };
            warnings.push(format!("only the mesh is read; passed over: {list}{apart}"));
        }
    }
}

/// Keywords without which bodies come apart.
fn joins_bodies(keyword: &str) -> bool {
    const JOINS: [&str; 9] = [
        "TIE",
        "MPC",
        "EQUATION",
        "COUPLING",
        "RIGID BODY",
        "EMBEDDED ELEMENT",
        "KINEMATIC COUPLING",
        "DISTRIBUTING COUPLING",
        "SHELL TO SOLID COUPLING",
    ];
    JOINS.contains(&keyword)
}

/// What the groups of an instance belong to, by all its names.
fn owners(is_alone: bool, instance: Option<&str>, part: &str) -> Vec<String> {
    let names = [is_alone.then_some("part"), instance, (is_alone || instance.is_none()).then_some(part)];
    names.into_iter().flatten().map(ToOwned::to_owned).collect()
}

/// What is added to the numbers of nodes and elements of each body: nothing, unless two have one number. Then that of the first
/// stays, and the others get round numbers on top.
fn label_offsets(scopes: &[Scope], placed: &[Placed]) -> Result<Vec<(u64, u64)>, Located> {
    let bodies: Vec<&Scope> =
        placed.iter().map(|body| &scopes[body.scope]).filter(|scope| scope.has_solids()).collect();
    let nodes = step(bodies.iter().map(|scope| scope.node_labels.to_vec()).collect());
    let elements = step(
        bodies
            .iter()
            .map(|scope| scope.elements.iter().filter(|e| is_solid(e.usage)).map(|e| e.label).collect())
            .collect(),
    );
    let mut rank = 0;
    let mut offset = |body: &Placed| {
        if !scopes[body.scope].has_solids() {
            return Some((0, 0));
        }
        rank += 1;
        let of = |step: Option<u64>| (rank - 1_u64).checked_mul(step?).filter(|offset| *offset <= i64::MAX as u64 / 2);
        Some((of(nodes)?, of(elements)?))
    };
    let offsets: Option<Vec<_>> = placed.iter().map(&mut offset).collect();
    offsets.ok_or_else(|| {
        let what = "instances that have the same numbers, some of them very large,".into();
        Problem::NotSupported { what, advice: "number nodes and elements from 1" }.at(Place::File)
    })
}

/// By how much the numbers of one list must differ from those of the next: 0 if no number is in two lists, else a power of
/// ten above all of them, if there is one.
fn step(lists: Vec<Vec<u64>>) -> Option<u64> {
    if lists.len() < 2 {
        return Some(0);
    }
    let mut all = lists.concat();
    all.sort_unstable();
    if all.windows(2).all(|pair| pair[0] < pair[1]) {
        return Some(0);
    }
    let greatest = all.last().copied().unwrap_or(0);
    let mut step = 10_u64;
    while step <= greatest {
        step = step.checked_mul(10)?;
    }
    Some(step)
}
