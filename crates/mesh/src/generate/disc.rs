//! An O-grid of the unit disc: a core of quads with bulged sides, and rings around it.
//!
//! ```text
//!        . - ~ ~ - .
//!     .'  \   |   /  '.         a straight square core would leave 90° + 135° + 135° at its corners;
//!    /   .-~~~+~~~-.   \        bulged sides make the three angles there 120° each
//!   |---|----------|---|
//!    \   '-___+___-'   /
//!     '.  /   |   \  .'
//!        ' - _ _ - '
//! ```

use std::f64::consts::TAU;

/// How far a core corner is drawn in: p(u, v) = a (1 − δ u² v²) (u, v). The sides meet the corner under
/// arctan(2δ/(1 − 3δ)) to the axes, 15° for this δ, so that the corner angle is 120°.
const CORNER_DRAW: f64 = 0.0955;
/// The core's half side a lies between these, where the ring's quads stay well shaped.
const CORE_BOUNDS: [f64; 2] = [0.25, 0.62];
/// The ring's cells lengthen this much against the core's: along the diagonals the core takes more of the radius.
const CORE_SHARE: f64 = 0.95;

/// A quad mesh of the unit disc or of its quarter x, y ≥ 0.
pub(super) struct Disc {
    pub points: Vec<[f64; 2]>,
    /// Counter-clockwise.
    pub quads: Vec<[u32; 4]>,
    /// Edges on the circle, counter-clockwise.
    pub side: Vec<[u32; 2]>,
    /// Edges on the plane x = 0, with the disc on their left; empty for the full disc.
    pub on_x: Vec<[u32; 2]>,
    /// Edges on the plane y = 0, with the disc on their left; empty for the full disc.
    pub on_y: Vec<[u32; 2]>,
    /// The centre.
    pub centre: u32,
    /// The point (1, 0).
    pub east: u32,
}

/// How many quads a quarter of the disc has.
pub(super) fn quarter_quad_count(core: u32, rings: u32) -> f64 {
    f64::from(core) * f64::from(core) + 2.0 * f64::from(core) * f64::from(rings)
}

/// The disc with `core` × `core` quads in each quarter's core and `rings` rings around it.
pub(super) fn disc(core: u32, rings: u32, full: bool) -> Disc {
    let m = i64::from(core);
    let low = if full { -m } else { 0 };
    let width = m - low + 1;
    let core_node = |i: i64, j: i64| ((j - low) * width + (i - low)) as u32;
    let a = (CORE_SHARE * f64::from(core) / f64::from(core + rings)).clamp(CORE_BOUNDS[0], CORE_BOUNDS[1]);

    let mut points = Vec::new();
    for j in low..=m {
        for i in low..=m {
            let (u, v) = (i as f64 / m as f64, j as f64 / m as f64);
            let scale = a * (1.0 - CORNER_DRAW * u * u * v * v);
            points.push([scale * u, scale * v]);
        }
    }
    let mut quads = Vec::new();
    for j in low..m {
        for i in low..m {
            quads.push([core_node(i, j), core_node(i + 1, j), core_node(i + 1, j + 1), core_node(i, j + 1)]);
        }
    }

    // The core's rim, counter-clockwise from (m, 0): a quarter of it has 2m segments.
    let segment_count = if full { 8 * m } else { 2 * m };
    let rim_count = if full { segment_count } else { segment_count + 1 };
    let rim: Vec<u32> = (0..rim_count)
        .map(|s| {
            // Where segment s starts on the square, one corner after another.
            let (i, j) = match s {
                s if s <= m => (m, s),
                s if s <= 3 * m => (2 * m - s, m),
                s if s <= 5 * m => (-m, 4 * m - s),
                s if s <= 7 * m => (s - 6 * m, -m),
                s => (m, s - 8 * m),
            };
            core_node(i, j)
        })
        .collect();
    let first_ring_node = points.len() as u32;
    for ring in 1..=rings {
        let t = f64::from(ring) / f64::from(rings);
        for (s, &inner) in rim.iter().enumerate() {
            let circle = on_circle(s as i64, m);
            let inner = points[inner as usize];
            points.push([0, 1].map(|axis| (1.0 - t) * inner[axis] + t * circle[axis]));
        }
    }
    let ring_node = |ring: u32, s: i64| {
        let s = (s % rim_count) as usize;
        if ring == 0 { rim[s] } else { first_ring_node + (ring - 1) * rim_count as u32 + s as u32 }
    };
    for ring in 0..rings {
        for s in 0..segment_count {
            quads.push([
                ring_node(ring, s),
                ring_node(ring + 1, s),
                ring_node(ring + 1, s + 1),
                ring_node(ring, s + 1),
            ]);
        }
    }

    let side = (0..segment_count).map(|s| [ring_node(rings, s), ring_node(rings, s + 1)]).collect();
    let (mut on_x, mut on_y) = (Vec::new(), Vec::new());
    if !full {
        let along_x = (0..=m).map(|i| core_node(i, 0)).chain((1..=rings).map(|ring| ring_node(ring, 0)));
        let along_y = (0..=m).map(|j| core_node(0, j)).chain((1..=rings).map(|ring| ring_node(ring, 2 * m)));
        on_y = edges(along_x);
        on_x = edges(along_y).into_iter().map(|[from, to]| [to, from]).collect();
    }
    Disc { points, quads, side, on_x, on_y, centre: core_node(0, 0), east: ring_node(rings, 0) }
}

/// The point of the circle where segment `s` starts; a quarter turn has 2m of them. Exact on the axes, so that
/// symmetry planes are planes.
fn on_circle(s: i64, m: i64) -> [f64; 2] {
    match (s % (2 * m) == 0, s / (2 * m) % 4) {
        (true, 0) => [1.0, 0.0],
        (true, 1) => [0.0, 1.0],
        (true, 2) => [-1.0, 0.0],
        (true, _) => [0.0, -1.0],
        _ => {
            let angle = TAU * s as f64 / (8 * m) as f64;
            [angle.cos(), angle.sin()]
        }
    }
}

fn edges(nodes: impl Iterator<Item = u32>) -> Vec<[u32; 2]> {
    let nodes: Vec<u32> = nodes.collect();
    nodes.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}
