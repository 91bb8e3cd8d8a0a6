//! Faces of elements.

/// A face by its nodes, of which corners come first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Face {
    /// Three corners.
    Triangle3([u32; 3]),
    /// Four corners.
    Quad4([u32; 4]),
    /// Three corners and the middles of the edges from the first to the second, from there to the third, and back.
    Triangle6([u32; 6]),
}

/// What identifies a face whatever its orientation and first corner.
pub type FaceKey = [u32; 6];

impl Face {
    /// The face with these nodes, if that many make one.
    pub fn new(nodes: &[u32]) -> Option<Self> {
        match *nodes {
            [a, b, c] => Some(Self::Triangle3([a, b, c])),
            [a, b, c, d] => Some([a, b, c, d].into()),
            [a, b, c, d, e, f] => Some(Self::Triangle6([a, b, c, d, e, f])),
            _ => None,
        }
    }

    /// All its nodes.
    pub fn nodes(&self) -> &[u32] {
        match self {
            Self::Triangle3(nodes) => nodes,
            Self::Quad4(nodes) => nodes,
            Self::Triangle6(nodes) => nodes,
        }
    }

    /// The face with other nodes in the place of its own.
    pub fn map(self, node: impl Fn(u32) -> u32) -> Self {
        match self {
            Self::Triangle3(nodes) => Self::Triangle3(nodes.map(node)),
            Self::Quad4(nodes) => Self::Quad4(nodes.map(node)),
            Self::Triangle6(nodes) => Self::Triangle6(nodes.map(node)),
        }
    }

    /// The same face, seen from the other side.
    pub fn reversed(self) -> Self {
        match self {
            Self::Triangle3([a, b, c]) => Self::Triangle3([c, b, a]),
            Self::Quad4([a, b, c, d]) => Self::Quad4([d, c, b, a]),
            Self::Triangle6([a, b, c, ab, bc, ca]) => Self::Triangle6([c, b, a, bc, ab, ca]),
        }
    }

    /// Its nodes in ascending order, behind them numbers that no node has.
    pub fn key(&self) -> FaceKey {
        let mut key = [u32::MAX; 6];
        let nodes = self.nodes();
        key[..nodes.len()].copy_from_slice(nodes);
        key.sort_unstable();
        key
    }
}

/// A quad with one corner twice is a triangle.
impl From<[u32; 4]> for Face {
    fn from(nodes: [u32; 4]) -> Self {
        match nodes {
            [a, b, c, d] if c == d || d == a => Self::Triangle3([a, b, c]),
            [a, b, c, d] if a == b || b == c => Self::Triangle3([a, c, d]),
            _ => Self::Quad4(nodes),
        }
    }
}

impl From<[u32; 3]> for Face {
    fn from(nodes: [u32; 3]) -> Self {
        Self::Triangle3(nodes)
    }
}

impl From<[u32; 6]> for Face {
    fn from(nodes: [u32; 6]) -> Self {
        Self::Triangle6(nodes)
    }
}
