//! Rigid tools of a deck: their names, what the solver is given, and what of their geometry and motion cannot work.

use estar_deck::Deck;
use estar_deck::diagnostics::{Diagnostic, Diagnostics};
use estar_deck::model::{RigidWallTable, WallSurface};
use estar_mesh::{Connectivity, Face, Mesh};
use estar_solver::Curve;
use estar_solver::model::{Model, RigidWall, WallMotion, WallShape};

/// Times at which motions are looked at, beside the points of their curves.
const SAMPLES: usize = 256;

/// The walls as the solver is given them.
pub fn walls(deck: &Deck) -> Vec<RigidWall> {
    let of_entry = |entry: &RigidWallTable| {
        let motion = entry.motion.as_ref().and_then(|motion| {
            let curve = motion.motion.curve(deck.interpolation(motion.interpolation))?;
            Some(WallMotion { direction: motion.direction.0, quantity: motion.motion.quantity(), curve })
        });
        RigidWall { shape: entry.surface.shape(), friction: entry.friction.0, motion }
    };
    deck.rigid_wall.iter().map(of_entry).collect()
}

/// Names of the rigid walls: their own, or their place in the deck.
pub fn names(deck: &Deck) -> Vec<String> {
    let name = |(index, wall): (usize, &RigidWallTable)| match &wall.name {
        Some(name) => name.0.value.clone(),
        None => format!("rigid wall {}", index + 1),
    };
    deck.rigid_wall.iter().enumerate().map(name).collect()
}

/// Reports tools that begin in the body, that are smaller than the faces that they meet, and that get to what is held.
pub fn check(deck: &Deck, mesh: &Mesh, connectivity: &Connectivity, model: &Model, diagnostics: &mut Diagnostics) {
    let is_curved = |wall: &RigidWall| !matches!(wall.shape, WallShape::Plane { .. });
    for (entry, wall) in deck.rigid_wall.iter().zip(&model.walls) {
        if !check_beginning(entry, wall, mesh, diagnostics) {
            continue;
        }
        if is_curved(wall) {
            check_size(entry, wall, mesh, model, connectivity, diagnostics);
        }
        check_held(entry, wall, mesh, model, diagnostics);
    }
}

/// No node may begin behind the wall; whether none does.
fn check_beginning(entry: &RigidWallTable, wall: &RigidWall, mesh: &Mesh, diagnostics: &mut Diagnostics) -> bool {
    let gaps = mesh.coordinates().iter().map(|position| wall.gap(position, 0.0));
    let behind: Vec<f64> = gaps.filter(|gap| *gap < -1e-9 * size(mesh)).collect();
    if behind.is_empty() {
        return true;
    }
    let depth = -behind.iter().copied().fold(0.0, f64::min);
    let message = format!("{} nodes lie behind the wall at time 0, up to {depth:.3e} m deep", behind.len());
    let help = match entry.surface {
        WallSurface::Plane { .. } => "`normal` points into the body's side; or move `point`",
        WallSurface::Cylinder { .. } | WallSurface::Sphere { .. } => {
            "the body is outside of the tool: move the tool, or make it smaller"
        }
    };
    diagnostics.push(Diagnostic::error(message).at(entry.span, "this wall").help(help));
    false
}

/// A curved tool acts on nodes: one whose radius is less than the distance between them passes between them, and may begin
/// within an element.
fn check_size(
    entry: &RigidWallTable,
    wall: &RigidWall,
    mesh: &Mesh,
    model: &Model,
    connectivity: &Connectivity,
    diagnostics: &mut Diagnostics,
) {
    let (radius, axis) = match wall.shape {
        WallShape::Plane { .. } => return,
        WallShape::Cylinder { radius, axis, .. } => (radius, Some(axis)),
        WallShape::Sphere { radius, .. } => (radius, None),
    };
    let times = times(model.settings.end, wall.motion.as_ref().map(|motion| &motion.curve));
    let body_travel = body_travel(model, &times);
    // between two times the tool is at most so far from where it was at the nearer one
    let places = times.iter().map(|time| wall.displacement(*time));
    let places: Vec<[f64; 3]> = places.collect();
    let stride = places.windows(2).map(|pair| norm(minus(pair[1], pair[0]))).fold(0.0, f64::max);
    let longest = |corners: &[[f64; 3]]| {
        let edges = corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| across(minus(*b, *a), axis));
        edges.fold(0.0, f64::max)
    };
    let mut coarsest: Option<(f64, u64)> = None;
    for outer in &connectivity.outer_faces {
        let corners = ring(&outer.face, mesh);
        let edge = longest(&corners);
        if edge <= radius || coarsest.is_some_and(|(known, _)| edge <= known) {
            continue;
        }
        let reach = edge + body_travel + stride;
        let centre = mean(&corners);
        if times.iter().any(|time| wall.gap(&centre, *time) <= reach) {
            coarsest = Some((edge, mesh.element_labels()[outer.element as usize].0));
        }
    }
    if let Some((edge, element)) = coarsest {
        let message = format!(
            "the tool, of radius {radius:.4e} m, is smaller than the faces of elements that it can meet: the nodes of element \
             {element} are {edge:.4e} m apart, and it would pass between them"
        );
        let help =
            format!("a radius of at least {edge:.4e} m, or elements of at most {radius:.4e} m where it meets them");
        diagnostics.push(Diagnostic::error(message).at(entry.span, "this tool").help(help));
        return;
    }
    // deep in a coarse body it meets no outer face
    let inside = (0..mesh.element_count()).find(|&element| {
        let positions = mesh.positions(element);
        let centre = mean(&positions);
        let reach = positions.iter().map(|position| norm(minus(*position, centre))).fold(0.0, f64::max);
        wall.gap(&centre, 0.0) <= 0.0 && reach > radius
    });
    if let Some(element) = inside {
        let label = mesh.element_labels()[element].0;
        let message = format!("the tool begins inside of element {label}, between its nodes");
        let help = "the body is outside of the tool: move the tool";
        diagnostics.push(Diagnostic::error(message).at(entry.span, "this tool").help(help));
    }
}

/// How far nodes may go by the velocities that they begin with and by what drives them, m.
fn body_travel(model: &Model, times: &[f64]) -> f64 {
    let thrown = model.initial_velocities.iter().map(|entry| norm(entry.translation) * model.settings.end);
    let driven = model
        .prescribed
        .iter()
        .flat_map(|entry| times.iter().map(|time| entry.quantity.displacement(&entry.curve, *time).abs()));
    thrown.chain(driven).fold(0.0, f64::max)
}

/// Held and driven nodes whose place is known at all times must stay in front of the wall.
fn check_held(entry: &RigidWallTable, wall: &RigidWall, mesh: &Mesh, model: &Model, diagnostics: &mut Diagnostics) {
    let normal_axes: [bool; 3] = match wall.shape {
        WallShape::Plane { normal, .. } => normal.map(|component| component.abs() > 1e-6),
        WallShape::Cylinder { axis, .. } => axis.map(|component| component.abs() < 1.0 - 1e-12),
        WallShape::Sphere { .. } => [true; 3],
    };
    // what drives each direction of each node: a place in `prescribed`, or one past it where the node is held
    let held = model.prescribed.len();
    let mut drivers = vec![[None; 3]; mesh.node_count()];
    for fix in &model.fixes {
        for (&node, direction) in fix.nodes.iter().flat_map(|node| fix.directions.iter().map(move |d| (node, d))) {
            drivers[node as usize][direction.index()] = Some(held);
        }
    }
    for (place, prescribed) in model.prescribed.iter().enumerate() {
        for &node in &prescribed.nodes {
            drivers[node as usize][prescribed.direction.index()] = Some(place);
        }
    }
    let is_known = |drivers: &[Option<usize>; 3]| (0..3).all(|i| drivers[i].is_some() || !normal_axes[i]);
    let known: Vec<u32> = (0..).zip(&drivers).filter(|(_, drivers)| is_known(drivers)).map(|(node, _)| node).collect();
    let curve = wall.motion.as_ref().map(|motion| &motion.curve);
    let times = times(model.settings.end, curve.into_iter().chain(model.prescribed.iter().map(|entry| &entry.curve)));
    for time in times {
        let driven = model.prescribed.iter().map(|entry| entry.quantity.displacement(&entry.curve, time));
        let displacements: Vec<f64> = driven.chain([0.0]).collect();
        let gap = |node: u32| {
            let (reference, drivers) = (mesh.coordinates()[node as usize], drivers[node as usize]);
            let place = std::array::from_fn(|i| reference[i] + drivers[i].map_or(0.0, |driver| displacements[driver]));
            (wall.gap(&place, time), node)
        };
        let nearest = known.iter().map(|&node| gap(node)).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((gap, node)) = nearest.filter(|(gap, _)| *gap < -1e-9 * size(mesh)) else { continue };
        let label = mesh.node_labels()[node as usize].0;
        let message = format!(
            "node {label}, which is held or driven, is {:.3e} m behind the wall at t = {time:.4e} s, and the wall cannot move it",
            -gap
        );
        let help = "let the wall stop before it, or leave the direction of its normal free there";
        diagnostics.push(Diagnostic::error(message).at(entry.span, "this wall").help(help));
        return;
    }
}

/// Times from 0 to the end, evenly and at the points of the curves.
fn times<'a>(end: f64, curves: impl IntoIterator<Item = &'a Curve>) -> Vec<f64> {
    let evenly = (0..=SAMPLES).map(|sample| end * sample as f64 / SAMPLES as f64);
    let of_curves = curves.into_iter().flat_map(Curve::times).filter(|time| (0.0..=end).contains(time));
    let mut times: Vec<f64> = evenly.chain(of_curves).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

/// The largest extent of the body along an axis, m.
fn size(mesh: &Mesh) -> f64 {
    let [low, high] = mesh.extent();
    (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max)
}

/// The nodes of a face in the order in which they lie round it, those in the middles of edges between their corners.
fn ring(face: &Face, mesh: &Mesh) -> Vec<[f64; 3]> {
    let nodes = face.nodes();
    let order: &[usize] = if nodes.len() == 6 { &[0, 3, 1, 4, 2, 5] } else { &[0, 1, 2, 3] };
    let around = order.iter().filter_map(|&place| nodes.get(place));
    around.map(|&node| mesh.coordinates()[node as usize]).collect()
}

fn mean(points: &[[f64; 3]]) -> [f64; 3] {
    let sum = points.iter().fold([0.0; 3], |sum, point| std::array::from_fn(|i| sum[i] + point[i]));
    sum.map(|component| component / points.len() as f64)
}

/// Length of a vector across an axis, if there is one.
fn across(vector: [f64; 3], axis: Option<[f64; 3]>) -> f64 {
    let along = axis.map_or(0.0, |axis| (0..3).map(|i| vector[i] * axis[i]).sum());
    norm(std::array::from_fn(|i| vector[i] - along * axis.map_or(0.0, |axis| axis[i])))
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn norm(vector: [f64; 3]) -> f64 {
    vector.iter().map(|component| component * component).sum::<f64>().sqrt()
}
