//! Bodies that share no nodes: what they are called, and that nothing happens where they meet.

use crate::conformity::{Doubt, length};
use estar_deck::format::short;
use estar_mesh::{Connectivity, Mesh};
use estar_solver::model::{LoadKind, Model};

/// So many bodies are described; of more, the largest.
const MOST_DESCRIBED: usize = 5;
/// So many parts of a body are named.
const MOST_PARTS: usize = 3;

/// What each body is made of.
#[derive(Debug)]
pub struct Bodies<'a> {
    connectivity: &'a Connectivity,
    /// Of each body, the parts that it has elements of.
    parts: Vec<Vec<usize>>,
    names: Vec<&'a str>,
}

impl<'a> Bodies<'a> {
    /// The bodies of a mesh with the `parts` (the elements of each), which are called by `names`.
    pub fn new<'e>(
        connectivity: &'a Connectivity,
        parts: impl IntoIterator<Item = &'e [u32]>,
        names: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let mut of_body = vec![Vec::new(); connectivity.bodies.len()];
        for (part, elements) in parts.into_iter().enumerate() {
            for &element in elements {
                let parts: &mut Vec<usize> = &mut of_body[connectivity.body_of_element[element as usize] as usize];
                if parts.last() != Some(&part) {
                    parts.push(part);
                }
            }
        }
        Self { connectivity, parts: of_body, names: names.into_iter().collect() }
    }

    /// A body in words.
    pub fn described(&self, body: usize, unit: &str) -> String {
        let of_body = &self.connectivity.bodies[body];
        let [low, high] = of_body.extent;
        let [x, y] = [0, 1].map(|axis| short(high[axis] - low[axis]));
        let names: Vec<String> =
            self.parts[body].iter().take(MOST_PARTS).map(|&part| format!("`{}`", self.names[part])).collect();
        let more = if self.parts[body].len() > MOST_PARTS { " and others" } else { "" };
        let parts = if names.is_empty() { String::new() } else { format!(" of {}{more}", names.join(", ")) };
        let elements = if of_body.element_count == 1 { "element" } else { "elements" };
        format!(
            "{} {elements}{parts}, {x} × {y} × {} (element {} is one)",
            of_body.element_count,
            length(high[2] - low[2], unit),
            of_body.first_element
        )
    }

    /// The largest bodies in words, separated by semicolons.
    pub fn listed(&self, bodies: &[usize], unit: &str) -> String {
        let described: Vec<String> =
            bodies.iter().take(MOST_DESCRIBED).map(|&body| self.described(body, unit)).collect();
        let more = match bodies.len().saturating_sub(MOST_DESCRIBED) {
            0 => String::new(),
            count => format!("; and {count} smaller"),
        };
        described.join("; ") + &more
    }
}

/// What can happen to bodies that nothing keeps apart, and that to others nothing happens at all.
pub fn doubts(mesh: &Mesh, bodies: &Bodies<'_>, model: &Model) -> Vec<Doubt> {
    let count = bodies.connectivity.bodies.len();
    let mut doubts = Vec::new();
    if count > 1 {
        let message = format!(
            "the mesh has {count} bodies that share no nodes, and bodies of elements do not touch each other: should they meet, they pass \
             through each other without any force"
        );
        let all: Vec<usize> = (0..count).collect();
        let help = format!(
            "the bodies are: {}; join those that belong together (`merge` in [mesh]); a [[rigid_wall]] stands for a tool that is not deformed",
            bodies.listed(&all, "m")
        );
        doubts.push(Doubt { message, help });
    }
    let is_idle = idle(mesh, bodies.connectivity, model);
    let idle: Vec<usize> = (0..count).filter(|&body| is_idle[body]).collect();
    if !idle.is_empty() {
        let message = match idle.len() {
            1 => "a body is neither held nor driven nor loaded and does not move: nothing happens to it".to_owned(),
            idle => {
                format!("{idle} bodies are neither held nor driven nor loaded and do not move: nothing happens to them")
            }
        };
        let help = format!("give it something to do, or leave it out of the mesh: {}", bodies.listed(&idle, "m"));
        doubts.push(Doubt { message, help });
    }
    doubts
}

/// Of each body, whether nothing acts on it.
fn idle(mesh: &Mesh, connectivity: &Connectivity, model: &Model) -> Vec<bool> {
    let is_for_all = |load: &LoadKind| matches!(load, LoadKind::Gravity { .. });
    // a wall that moves may come to any body
    if model.loads.iter().any(|load| is_for_all(&load.kind)) || model.walls.iter().any(|wall| wall.motion.is_some()) {
        return vec![false; connectivity.bodies.len()];
    }
    let mut acted = vec![false; mesh.node_count()];
    let of_fixes = model.fixes.iter().flat_map(|fix| &fix.nodes);
    let of_motions = model.prescribed.iter().flat_map(|prescribed| &prescribed.nodes);
    let moving =
        model.initial_velocities.iter().filter(|velocity| velocity.translation != [0.0; 3] || velocity.spin.is_some());
    for &node in of_fixes.chain(of_motions).chain(moving.flat_map(|velocity| &velocity.nodes)) {
        acted[node as usize] = true;
    }
    for load in &model.loads {
        if let LoadKind::Pressure { faces, .. } | LoadKind::Traction { faces, .. } = &load.kind {
            for &node in faces.iter().flat_map(|face| face.nodes()) {
                acted[node as usize] = true;
            }
        }
    }
    let mut is_idle = vec![true; connectivity.bodies.len()];
    for (nodes, &body) in mesh.elements().iter().zip(&connectivity.body_of_element) {
        if nodes.iter().any(|&node| acted[node as usize]) {
            is_idle[body as usize] = false;
        }
    }
    is_idle
}
