//! `[[probe]]`: numbers that are followed.

use crate::snapshot::Snapshot;
use estar_deck::Deck;
use estar_deck::decoder::At;
use estar_deck::diagnostics::{Diagnostic, Diagnostics, Span, listed};
use estar_deck::fields::{Component, ProbeField};
use estar_deck::format::ranges;
use estar_deck::history_column;
use estar_deck::model::RigidWallTable;
use estar_deck::names::{GroupName, OfNodes};
use estar_deck::probe::{ProbeKind, ProbeTable};
use estar_deck::units::Dimension;
use estar_mesh::quality::volume;
use estar_mesh::{GroupError, Mesh, Wanted};
use estar_solver::model::{Direction, Part};

/// A number that is followed.
#[derive(Clone, Debug)]
pub struct Probe {
    /// Its name.
    pub name: String,
    /// Its dimension.
    pub dimension: Dimension,
    what: What,
}

#[derive(Clone, Debug)]
enum What {
    Extent { nodes: Vec<u32>, axis: usize },
    MaxRadius { nodes: Vec<u32>, axis: usize, centre: [f64; 3] },
    Reaction { nodes: Vec<u32>, direction: Direction },
    ContactForce { wall: usize, direction: Direction },
    Mean { field: ProbeField, component: Option<Component>, weights: Vec<(u32, f64)> },
    Maximum { field: ProbeField, component: Option<Component>, members: Vec<u32> },
}

impl Probe {
    /// Its value now.
    pub fn value(&self, snapshot: &Snapshot<'_>) -> f64 {
        match &self.what {
            What::Extent { nodes, axis } => {
                let places = || nodes.iter().map(|node| snapshot.position(*node)[*axis]);
                places().fold(f64::NEG_INFINITY, f64::max) - places().fold(f64::INFINITY, f64::min)
            }
            What::MaxRadius { nodes, axis, centre } => {
                let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
                let radius = |node: &u32| {
                    let place = snapshot.position(*node);
                    (place[first] - centre[first]).hypot(place[second] - centre[second])
                };
                nodes.iter().map(radius).fold(0.0, f64::max)
            }
            What::Reaction { nodes, direction } => snapshot.reaction(nodes, *direction),
            What::ContactForce { wall, direction } => snapshot.simulation.wall_force(*wall)[index(*direction)],
            What::Mean { field, component, weights } => {
                let sum = |term: &dyn Fn(&(u32, f64)) -> f64| weights.iter().map(term).sum::<f64>();
                sum(&|(index, weight)| weight * snapshot.value(*field, *component, *index))
                    / sum(&|(_, weight)| *weight)
            }
            What::Maximum { field, component, members } => {
                let values = members.iter().map(|index| snapshot.value(*field, *component, *index));
                values.fold(f64::NEG_INFINITY, f64::max)
            }
        }
    }
}

/// The probes of a deck on a mesh of such parts.
pub fn resolve(deck: &Deck, mesh: &Mesh, parts: &[Part], diagnostics: &mut Diagnostics) -> Vec<Probe> {
    let mut probes = Vec::new();
    for table in &deck.probe {
        let name = &table.name.0;
        if history_column::is_column(&name.value) {
            let message = format!("the probe `{}` has the name of a column that history.csv has anyway", name.value);
            diagnostics.push(Diagnostic::error(message).at(name.span, "this name").help("any other name would do"));
        }
        if let Some(what) = (Resolver { deck, mesh, parts, diagnostics }).what(table) {
            probes.push(Probe { name: name.value.clone(), dimension: table.kind.dimension(), what });
        }
    }
    probes
}

struct Resolver<'a> {
    deck: &'a Deck,
    mesh: &'a Mesh,
    parts: &'a [Part],
    diagnostics: &'a mut Diagnostics,
}

impl Resolver<'_> {
    fn what(&mut self, table: &ProbeTable) -> Option<What> {
        match &table.kind {
            ProbeKind::Extent { group, axis } => {
                Some(What::Extent { nodes: group.nodes(self.mesh)?, axis: index(*axis) })
            }
            ProbeKind::MaxRadius { group, axis, centre } => {
                Some(What::MaxRadius { nodes: group.nodes(self.mesh)?, axis: index(*axis), centre: centre.value })
            }
            ProbeKind::Reaction { group, direction } => {
                let nodes = group.nodes(self.mesh)?;
                self.check_reaction(&group.name, &nodes, *direction);
                Some(What::Reaction { nodes, direction: *direction })
            }
            ProbeKind::ContactForce { wall, direction } => {
                let is_meant =
                    |table: &RigidWallTable| table.name.as_ref().is_some_and(|name| name.0.value == wall.0.value);
                let wall = self.deck.rigid_wall.iter().position(is_meant)?;
                Some(What::ContactForce { wall, direction: *direction })
            }
            ProbeKind::Node { label, group, field, component } => {
                let node = match (label, group) {
                    (Some(label), None) => self.node_of_label(label.value.0, label.span),
                    (None, Some(group)) => self.node_of_group(group),
                    (label, _) => {
                        let fault =
                            if label.is_some() { "both `label` and `group`" } else { "neither `label` nor `group`" };
                        let message = format!("the probe `{}` has {fault}", table.name.0.value);
                        let diagnostic = Diagnostic::error(message).at(table.span, "this probe");
                        self.diagnostics.push(diagnostic.help("one of the two says which node"));
                        None
                    }
                };
                if !field.value.is_nodal() {
                    self.wrong_place(field.span, "a node", "a field of nodes: position, displacement or velocity");
                    return None;
                }
                let component = self.component(field, component)?;
                Some(What::Mean { field: field.value, component, weights: vec![(node?, 1.0)] })
            }
            ProbeKind::Element { label, field, component } => {
                let labels = self.mesh.element_labels();
                let element = labels.iter().position(|element| element.0 == label.value.0);
                if element.is_none() {
                    let message = format!("the mesh has no element with the number {}", label.value.0);
                    let help = format!("its elements are {}", ranges(labels.iter().map(|element| element.0)));
                    self.diagnostics.push(Diagnostic::error(message).at(label.span, "no such element").help(help));
                }
                if field.value.is_nodal() {
                    self.wrong_place(field.span, "an element", "a field of elements, such as von_mises_stress");
                    return None;
                }
                let component = self.component(field, component)?;
                let element = element? as u32;
                self.check_temperature(field, &[element]);
                Some(What::Mean { field: field.value, component, weights: vec![(element, 1.0)] })
            }
            ProbeKind::GroupAverage { group, field, component } => {
                let component = self.component(field, component)?;
                let members = self.members(group, field)?;
                let weight = |index: &u32| match field.value.is_nodal() {
                    true => 1.0,
                    false => {
                        let element = *index as usize;
                        volume(self.mesh.elements().shape(element), &self.mesh.positions(element))
                    }
                };
                let weights = members.iter().map(|index| (*index, weight(index))).collect();
                Some(What::Mean { field: field.value, component, weights })
            }
            ProbeKind::Maximum { group, field, component } => {
                let component = self.component(field, component)?;
                let members = self.members(group, field)?;
                Some(What::Maximum { field: field.value, component, members })
            }
        }
    }

    /// A force is sought only where some node is held or driven.
    fn check_reaction(&mut self, name: &At<String>, nodes: &[u32], direction: Direction) {
        let fixes = self.deck.fix.iter().flat_map(|fix| {
            fix.directions.iter().map(move |direction| (fix.group.name.value.as_str(), direction.value))
        });
        let driven = self.deck.prescribed.iter();
        let driven = driven.map(|entry| (entry.group.name.value.as_str(), entry.direction.value));
        let mut held: Vec<&str> =
            fixes.chain(driven).filter(|(_, held)| *held == direction).map(|(name, _)| name).collect();
        let is_held = |name: &&str| {
            let group = self.mesh.group(name);
            group.is_some_and(|group| group.nodes.iter().any(|node| nodes.binary_search(node).is_ok()))
        };
        if held.iter().any(is_held) {
            return;
        }
        held.sort_unstable();
        held.dedup();
        let axis = ["x", "y", "z"][index(direction)];
        let message = format!("nothing holds or drives a node of `{}` in {axis}: there is no reaction", name.value);
        let help = match listed(held) {
            none if none.is_empty() => format!(
                "no [[fix]] and no [[prescribed]] acts in {axis}; the force of a rigid wall is kind = \"contact-force\""
            ),
            groups => format!("the groups that are held or driven in {axis} are {groups}"),
        };
        self.diagnostics.push(Diagnostic::error(message).at(name.span, "a free group").help(help));
    }

    fn node_of_label(&mut self, label: u64, span: Span) -> Option<u32> {
        let node = self.mesh.node_labels().iter().position(|node| node.0 == label);
        if node.is_none() {
            let message = format!("the mesh has no node with the number {label}");
            let help = format!("its nodes are {}", ranges(self.mesh.node_labels().iter().map(|node| node.0)));
            self.diagnostics.push(Diagnostic::error(message).at(span, "no such node").help(help));
        }
        node.map(|node| node as u32)
    }

    fn node_of_group(&mut self, of: &GroupName<OfNodes>) -> Option<u32> {
        let group = of.group(self.mesh)?;
        if let [node] = group.nodes[..] {
            return Some(node);
        }
        let message =
            format!("the group `{}` has {} nodes, but a probe of one node needs one", group.name, group.nodes.len());
        let diagnostic = Diagnostic::error(message).at(of.name.span, "this group");
        self.diagnostics.push(diagnostic.help("kind = \"group-average\" or \"maximum\" takes all of them"));
        None
    }

    /// The nodes or elements of a group on which a field lives.
    fn members(&mut self, of: &GroupName<OfNodes>, field: &At<ProbeField>) -> Option<Vec<u32>> {
        if field.value.is_nodal() {
            return of.nodes(self.mesh);
        }
        let name = &of.name;
        let message = match self.mesh.find(&name.value, Wanted::Elements) {
            Ok(group) => {
                self.check_temperature(field, &group.elements);
                return Some(group.elements.clone());
            }
            Err(GroupError::OtherKind(group)) => {
                format!("the group `{}` is a {}, but the field lives on elements", group.name, group.kind)
            }
            Err(_) => format!("several volume groups are named `{}`", name.value),
        };
        let names = self.mesh.names_to_find(Wanted::Elements);
        let help = format!("the volume groups are {}", listed(names.iter().map(String::as_str)));
        let diagnostic = Diagnostic::error(message).at(name.span, "a volume group is needed");
        self.diagnostics.push(diagnostic.at(field.span, "this field").help(help));
        None
    }

    /// Every element whose temperature is asked for must have one.
    fn check_temperature(&mut self, field: &At<ProbeField>, elements: &[u32]) {
        if field.value != ProbeField::Temperature {
            return;
        }
        let cold = self.parts.iter().find(|part| {
            let of_part = |element: &u32| part.elements.binary_search(element).is_ok();
            !part.material.has_temperature() && elements.iter().any(of_part)
        });
        if cold.is_some() {
            let diagnostic = Diagnostic::error("this probe asks for the temperature of a material that has none");
            let help = "a material has a temperature with hardening = { law = \"johnson-cook\", ... }";
            self.diagnostics.push(diagnostic.at(field.span, "this field").help(help));
        }
    }

    fn wrong_place(&mut self, span: Span, place: &str, wanted: &str) {
        let message = format!("this field does not live on {place}");
        self.diagnostics.push(Diagnostic::error(message).at(span, format!("{wanted} is needed")));
    }

    /// The component of a field, which vectors and tensors need and scalars must not have.
    fn component(&mut self, field: &At<ProbeField>, given: &Option<At<Component>>) -> Option<Option<Component>> {
        let choices = field.value.components();
        let names = listed(choices.iter().map(|component| component.name()));
        let diagnostic = match given {
            None if choices.is_empty() => return Some(None),
            Some(component) if choices.contains(&component.value) => return Some(Some(component.value)),
            None => Diagnostic::error("this field has components: `component` must say which")
                .at(field.span, "this field")
                .help(format!("the components are {names}")),
            Some(component) if choices.is_empty() => Diagnostic::error("this field has no components")
                .at(component.span, "leave this out")
                .at(field.span, "this field"),
            Some(component) => Diagnostic::error(format!("this field has no component `{}`", component.value.name()))
                .at(component.span, "this component")
                .help(format!("the components are {names}")),
        };
        self.diagnostics.push(diagnostic);
        None
    }
}

fn index(direction: Direction) -> usize {
    match direction {
        Direction::X => 0,
        Direction::Y => 1,
        Direction::Z => 2,
    }
}
