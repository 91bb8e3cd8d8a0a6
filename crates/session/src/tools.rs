//! Rigid tools of a deck: their names, what the solver is given, and what of their geometry and motion cannot work.

use estar_deck::Deck;
use estar_deck::diagnostics::{Diagnostic, Diagnostics};
use estar_deck::model::{RigidWallTable, WallSurface};
use estar_mesh::{Connectivity, Face, Mesh};
use estar_solver::Curve;
use estar_solver::model::{Model, RigidWall, WallMotion, WallShape};
use std::collections::HashMap;

/// Times at which motions are looked at, beside the points of their curves.
const SAMPLES: usize = 256;

/// From how many edges of a face on a radius has a force that hardly depends on the place: 8 %, 0.8 edges deep (docs/forming.md).
const WELL_RESOLVED: u32 = 4;

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
        let help = format!(
            "a radius of at least {edge:.4e} m, or elements of at most {radius:.4e} m where it meets them; at that size the force still \
             depends by up to half on the place between the nodes, from {WELL_RESOLVED} times the radius on by at most 8 % once the \
             tool is 0.8 edges deep"
        );
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
    let (message, tool_acts) = match (inside, deepest_in_a_face(wall, mesh, connectivity)) {
        (Some(element), _) => {
            let label = mesh.element_labels()[element].0;
            (format!("the tool begins inside of element {label}, between its nodes"), "")
        }
        (None, Some((depth, element))) => {
            let label = mesh.element_labels()[element as usize].0;
            let message = format!(
                "the tool begins {depth:.3e} m deep in a face of element {label}, between its nodes, and would not press there"
            );
            (message, ": it acts on nodes")
        }
        (None, None) => return,
    };
    let help = format!("the body is outside of the tool{tool_acts}; move the tool");
    diagnostics.push(Diagnostic::error(message).at(entry.span, "this tool").help(help));
}

/// Into how many parts the sides of a face are divided where a tool is sought between its nodes.
const PARTS_OF_SIDE: usize = 8;

/// How much of the bulge of a surface over a face is not known: near the ends of an arc of angle θ, 1/cos(θ/2) − cos(θ/2), which
/// is 0.29 at 60°.
const DOUBT_OF_BULGE: f64 = 0.3;

/// Faces that meet under a smaller angle than 61° stand for one smooth surface: this is its cosine.
const SMOOTH: f64 = 0.48;

/// A tool lies before a face where the direction to its axis is within 60° of the face's normal: this is its cosine.
const FACING: f64 = 0.5;

/// How deep a tool begins in a face between its nodes, and the face's element.
///
/// A body that is hollow where the tool is, as a hole that the tool fills, has flat faces that reach into the tool: the surface for
/// which they stand does not. It lies half-way between a face and the planes through the corners, each across the mean normal there
/// (Boubekeur and Alexa 2008, Phong tessellation), and both are to be in the tool.
fn deepest_in_a_face(wall: &RigidWall, mesh: &Mesh, connectivity: &Connectivity) -> Option<(f64, u32)> {
    let corners_of = |face: &Face| -> Vec<u32> {
        let corners = if face.nodes().len() == 6 { 3 } else { face.nodes().len() };
        face.nodes()[..corners].to_vec()
    };
    let places = |corners: &[u32]| corners.iter().map(|&node| mesh.coordinates()[node as usize]).collect::<Vec<_>>();
    let is_near = |corners: &[[f64; 3]]| {
        let centre = mean(corners);
        let reach = corners.iter().map(|corner| norm(minus(*corner, centre))).fold(0.0, f64::max);
        wall.gap(&centre, 0.0) < reach
    };
    let near = connectivity.outer_faces.iter().filter(|outer| is_near(&places(&corners_of(&outer.face))));
    let near: Vec<(Vec<u32>, u32)> = near.map(|outer| (corners_of(&outer.face), outer.element)).collect();
    if near.is_empty() {
        return None;
    }
    let mut around: HashMap<u32, Vec<[f64; 3]>> =
        near.iter().flat_map(|(corners, _)| corners).map(|&node| (node, Vec::new())).collect();
    for outer in &connectivity.outer_faces {
        let corners = corners_of(&outer.face);
        if corners.iter().any(|node| around.contains_key(node)) {
            let area = area(&places(&corners));
            for node in corners {
                around.entry(node).and_modify(|areas| areas.push(area));
            }
        }
    }
    let mut deepest: Option<(f64, u32)> = None;
    for (corners, element) in near {
        let face_normal = unit(area(&places(&corners)));
        let normal_at = |node: &u32| {
            let smooth = around[node].iter().filter(|area| dot(unit(**area), face_normal) > SMOOTH);
            unit(smooth.fold([0.0; 3], |sum, area| std::array::from_fn(|i| sum[i] + area[i])))
        };
        let normals: Vec<[f64; 3]> = corners.iter().map(normal_at).collect();
        let corners = places(&corners);
        for shares in shares_within(corners.len()) {
            let point = weighted(&corners, &shares);
            if dot(towards(wall, &point), face_normal) < FACING {
                continue;
            }
            let on_planes: Vec<[f64; 3]> = corners
                .iter()
                .zip(&normals)
                .map(|(corner, normal)| {
                    let height = dot(minus(point, *corner), *normal);
                    std::array::from_fn(|i| point[i] - 0.5 * height * normal[i])
                })
                .collect();
            let on_surface = weighted(&on_planes, &shares);
            let doubt = DOUBT_OF_BULGE * norm(minus(on_surface, point)) + 1e-9 * size(mesh);
            let depth = -wall.gap(&point, 0.0).max(wall.gap(&on_surface, 0.0));
            if depth > doubt && deepest.is_none_or(|(known, _)| depth > known) {
                deepest = Some((depth, element));
            }
        }
    }
    deepest
}

/// Shares of the corners of a triangle or a quad in points all over it.
fn shares_within(corners: usize) -> Vec<Vec<f64>> {
    let steps = || (0..=PARTS_OF_SIDE).map(|step| step as f64 / PARTS_OF_SIDE as f64);
    let pairs = steps().flat_map(|u| steps().map(move |v| (u, v)));
    match corners {
        3 => pairs.filter(|(u, v)| u + v <= 1.0).map(|(u, v)| vec![1.0 - u - v, u, v]).collect(),
        _ => pairs.map(|(u, v)| vec![(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v]).collect(),
    }
}

/// The direction from a point to the axis or the centre of a tool at time 0.
fn towards(wall: &RigidWall, point: &[f64; 3]) -> [f64; 3] {
    let (centre, axis) = match wall.shape {
        WallShape::Plane { normal, .. } => return normal,
        WallShape::Cylinder { point, axis, .. } => (point, axis),
        WallShape::Sphere { centre, .. } => (centre, [0.0; 3]),
    };
    let moved = wall.displacement(0.0);
    let arm: [f64; 3] = std::array::from_fn(|i| centre[i] + moved[i] - point[i]);
    let along = dot(arm, axis);
    unit(std::array::from_fn(|i| arm[i] - along * axis[i]))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn weighted(points: &[[f64; 3]], shares: &[f64]) -> [f64; 3] {
    std::array::from_fn(|i| points.iter().zip(shares).map(|(point, share)| share * point[i]).sum())
}

/// The area of a face as a vector, from its corners: half the sum of x_k × x_{k+1}.
fn area(corners: &[[f64; 3]]) -> [f64; 3] {
    let next = corners.iter().cycle().skip(1);
    let cross =
        |a: &[f64; 3], b: &[f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let sum = corners.iter().zip(next).map(|(a, b)| cross(a, b));
    sum.fold([0.0; 3], |sum, term| std::array::from_fn(|i| sum[i] + 0.5 * term[i]))
}

fn unit(vector: [f64; 3]) -> [f64; 3] {
    let length = norm(vector);
    if length > 0.0 { vector.map(|component| component / length) } else { vector }
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

#[cfg(test)]
mod tests {
    use super::*;
    use estar_mesh::generate::{BoxSpec, box_mesh};
    use estar_mesh::{ElementLabel, Elements, NodeLabel, Shape};
    use std::f64::consts::TAU;

    fn depth(shape: WallShape, mesh: &Mesh) -> Option<f64> {
        let wall = RigidWall { shape, friction: 0.0, motion: None };
        deepest_in_a_face(&wall, mesh, &Connectivity::new(mesh)).map(|(depth, _)| depth)
    }

    fn is_about(found: Option<f64>, expected: f64) -> bool {
        found.is_some_and(|found| (found - expected).abs() < 1e-9)
    }

    #[test]
    fn a_tool_that_begins_in_a_face_between_its_nodes_is_found() {
        // elements of 0.25, and a tool over the middle of those of the top
        let mesh = box_mesh(&BoxSpec::new([1.0; 3], [4; 3]).unwrap());
        let sphere = |z: f64| WallShape::Sphere { centre: [0.625, 0.625, z], radius: 0.26 };
        let cylinder = |z: f64| WallShape::Cylinder { point: [0.625, 0.0, z], axis: [0.0, 1.0, 0.0], radius: 0.26 };
        assert!(is_about(depth(sphere(1.24), &mesh), 0.02) && is_about(depth(cylinder(1.24), &mesh), 0.02));
        assert!(is_about(depth(cylinder(1.26 - 1e-6), &mesh), 1e-6));
        for above in [0.0, 1e-6, 0.1] {
            assert_eq!((depth(sphere(1.26 + above), &mesh), depth(cylinder(1.26 + above), &mesh)), (None, None));
        }
        // round the edge of the box
        let at_edge = |distance: f64| {
            let [x, z] = [1.0 + distance * 0.6, 1.0 + distance * 0.8];
            depth(WallShape::Cylinder { point: [x, 0.0, z], axis: [0.0, 1.0, 0.0], radius: 0.26 }, &mesh)
        };
        assert_eq!(at_edge(0.26 + 1e-9), None);
    }

    /// A ring of bricks, of radius 1 inside.
    fn ring_of_bricks(count: u32) -> Mesh {
        let node = |layer: u32, circle: u32, place: u32| (layer * 2 + circle) * count + place % count;
        let place = |index: u32| {
            let (layer, circle, place) = (index / (2 * count), index / count % 2, index % count);
            let (radius, angle) = (1.0 + f64::from(circle), TAU * f64::from(place) / f64::from(count));
            [radius * angle.cos(), radius * angle.sin(), f64::from(layer)]
        };
        let mut elements = Elements::default();
        for k in 0..count {
            let bottom = [node(0, 0, k), node(0, 1, k), node(0, 1, k + 1), node(0, 0, k + 1)];
            let top = bottom.map(|index| index + 2 * count);
            elements.push(Shape::Hex8, &[bottom, top].concat());
        }
        let labels = (1..=u64::from(4 * count)).map(NodeLabel).collect();
        let element_labels = (1..=u64::from(count)).map(ElementLabel).collect();
        Mesh::new((0..4 * count).map(place).collect(), labels, elements, element_labels, Vec::new()).unwrap()
    }

    #[test]
    fn a_pin_may_fill_the_hole_that_a_mesh_makes_of_flat_faces() {
        for count in [6, 7, 8, 12, 40] {
            let mesh = ring_of_bricks(count);
            let pin =
                |radius: f64, at: f64| WallShape::Cylinder { point: [at, 0.0, 0.0], axis: [0.0, 0.0, 1.0], radius };
            for radius in [0.95, 0.99, 1.0] {
                assert_eq!(depth(pin(radius, 0.0), &mesh), None, "{count} bricks, a pin of {radius}");
            }
            assert!(depth(pin(1.1, 0.0), &mesh).is_some_and(|depth| depth > 0.08), "{count} bricks");
        }
    }
}
