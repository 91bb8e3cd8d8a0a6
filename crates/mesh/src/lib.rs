//! Meshes: nodes, elements of any mix of shapes, named groups, their quality, an order that is kind to the cache, and structured
//! generators. Knows no physics and no file format.
//!
//! A [`Mesh`] is valid once it exists: every index is in range, every coordinate finite, every label used once,
//! every group known by its name, kind and owner. Whether its elements are any *good* is a different question, answered by [`quality::QualityReport`].
//!
//! ```
//! use estar_mesh::generate::{BoxSpec, box_mesh};
//! use estar_mesh::quality::QualityReport;
//!
//! let spec = BoxSpec::new([2.0, 1.0, 1.0], [4, 2, 2])?;
//! let mesh = box_mesh(&spec);
//! assert_eq!((mesh.element_count(), mesh.node_count()), (16, 45));
//! assert!(QualityReport::new(&mesh).errors().is_empty());
//! # Ok::<(), estar_mesh::generate::SpecError>(())
//! ```

mod body;
pub mod conformity;
mod elements;
mod face;
pub mod generate;
mod group;
pub mod hex;
mod label;
mod lookup;
mod merge;
mod mesh;
mod order;
mod point_tree;
mod points;
pub mod quality;
mod shape;

pub use body::{Body, Connectivity, OuterFace};
pub use elements::Elements;
pub use face::{Face, FaceKey};
pub use group::{Group, GroupKind};
pub use label::{ElementLabel, NodeLabel};
pub use lookup::{GroupError, Wanted};
pub use merge::{MergeError, Merged};
pub use mesh::{FaceError, Mesh, MeshError};
pub use order::{Renumbering, locality_order};
pub use point_tree::PointTree;
pub use shape::{ElementNodes, MOST_NODES, Shape};
