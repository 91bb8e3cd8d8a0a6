//! Where elements of a mesh lie on one another without being joined, in words: for `check`, `run` and `mesh info`.

use estar_deck::format::{number_of, short};
use estar_mesh::conformity::{Conformity, MismatchKind};

/// Something about a mesh that is probably not meant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Doubt {
    /// What was found, how often and where.
    pub message: String,
    /// What to do about it.
    pub help: String,
}

/// What was found in a mesh whose coordinates are in `unit`, which is empty where it is not known.
pub fn doubts(found: &Conformity, unit: &str) -> Vec<Doubt> {
    [
        coincident(found, unit),
        mismatches(found, unit),
        hanging(found, unit),
        between_bodies(found, unit),
        hinges(found, unit),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn coincident(found: &Conformity, unit: &str) -> Option<Doubt> {
    let first = found.coincident.first()?;
    let largest = found.coincident.iter().map(|coincident| coincident.distance).fold(0.0, f64::max);
    let shortest = found.coincident.iter().map(|coincident| coincident.length).fold(f64::INFINITY, f64::min);
    let apart = if largest == 0.0 { "exactly".to_owned() } else { format!("within {}", length(largest, unit)) };
    let message = format!(
        "{} {apart} at the place of another without being joined to it, such as node {} and node {} at {}",
        number_of(found.coincident.len(), "node lies", "nodes lie"),
        first.other,
        first.node,
        place(&first.position, unit)
    );
    // above the distance by a factor of 2 to 20, and far below an edge
    let exponent = match largest {
        0.0 => (1e-6 * shortest).log10().floor(),
        _ => (2.0 * largest).log10().ceil(),
    };
    let joins = match unit {
        "m" => format!("`merge = \"1e{exponent} m\"` in [mesh] joins these nodes"),
        // of a file without a deck nobody knows the unit
        _ => format!(
            "`merge` in [mesh] joins these nodes (\"1e{exponent} m\" of a file in m, \"1e{exponent} mm\" of one in mm)"
        ),
    };
    let help = format!(
        "the mesh is not connected there: {joins}, and meshers can, too (in Gmsh: Coherence Mesh); without that they come apart freely"
    );
    Some(Doubt { message, help })
}

fn mismatches(found: &Conformity, unit: &str) -> Option<Doubt> {
    let first = found.mismatches.first()?;
    let kinds = [
        (MismatchKind::QuadOnTriangles, "quad that lies on two triangles", "quads that lie on two triangles each"),
        (
            MismatchKind::CrossedDiagonals,
            "pair of triangles on a pair with the other diagonal",
            "pairs of triangles on pairs with the other diagonal",
        ),
        (
            MismatchKind::MiddleNodes,
            "triangle on one with other nodes in the middle of its edges",
            "triangles on others with other nodes in the middle of their edges",
        ),
    ];
    let of_kind = |&(kind, one, many): &(MismatchKind, &str, &str)| {
        let count = found.mismatches.iter().filter(|mismatch| mismatch.kind == kind).count();
        (count > 0).then(|| number_of(count, one, many))
    };
    let counted: Vec<String> = kinds.iter().filter_map(of_kind).collect();
    let message = format!(
        "faces of the mesh do not match: {}, such as between elements {} and {} at {}",
        counted.join(", "),
        first.elements[0],
        first.elements[1],
        place(&first.centre, unit)
    );
    let help = "the elements on either side move apart between their common nodes, and the stress is wrong there, by 10 to 25 % \
                in uniaxial strain: divide both sides alike, or put pyramids between hexes and tets";
    Some(Doubt { message, help: help.to_owned() })
}

fn hanging(found: &Conformity, unit: &str) -> Option<Doubt> {
    let hanging: Vec<_> = found.hanging.iter().filter(|hanging| !hanging.is_between_bodies).collect();
    let first = hanging.first()?;
    let message = format!(
        "{} on a face or an edge of an element that does not have it (a hanging node), such as node {} on element {} at {}",
        number_of(hanging.len(), "node lies", "nodes lie"),
        first.node,
        first.element,
        place(&first.position, unit)
    );
    let help = "elements come apart there and pass through each other: neighbours must share whole faces";
    Some(Doubt { message, help: help.to_owned() })
}

fn between_bodies(found: &Conformity, unit: &str) -> Option<Doubt> {
    let hanging: Vec<_> = found.hanging.iter().filter(|hanging| hanging.is_between_bodies).collect();
    let first = hanging.first()?;
    let message = format!(
        "{} on a face of another body that does not have it, such as node {} on element {} at {}",
        number_of(hanging.len(), "node of one body lies", "nodes of one body lie"),
        first.node,
        first.element,
        place(&first.position, unit)
    );
    let help = "the bodies lie on one another, but nothing joins them: mesh them as one, with common faces, or alike and with \
                `merge` in [mesh]";
    Some(Doubt { message, help: help.to_owned() })
}

fn hinges(found: &Conformity, unit: &str) -> Option<Doubt> {
    let first = found.hinges.first()?;
    let message = format!(
        "{} pieces of a body that share no face, such as node {} at {}",
        number_of(found.hinges.len(), "node alone holds together", "nodes alone hold together"),
        first.node,
        place(&first.position, unit)
    );
    let help = "a shared node or edge is a hinge without stiffness: join the pieces by whole faces, or part them";
    Some(Doubt { message, help: help.to_owned() })
}

/// A length with its unit.
pub fn length(value: f64, unit: &str) -> String {
    if unit.is_empty() { short(value) } else { format!("{} {unit}", short(value)) }
}

fn place(position: &[f64; 3], unit: &str) -> String {
    // x + 0 is 0 for both zeros
    let [x, y, z] = position.map(|x| short(x + 0.0));
    if unit.is_empty() { format!("({x}, {y}, {z})") } else { format!("({x}, {y}, {z}) {unit}") }
}
