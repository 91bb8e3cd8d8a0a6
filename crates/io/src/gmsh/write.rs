//! Writing Gmsh 4.1.

use std::collections::{HashMap, HashSet};
use std::io::{self, Write};
use std::path::Path;

use estar_mesh::{Face, Group, GroupKind, Mesh, Shape};

use super::element_type::{LINE2, POINT, QUAD4, TRIANGLE3, TRIANGLE6, solid_code, swap_order};
use crate::atomic::AtomicFile;

/// Writes a mesh in Gmsh's format 4.1, as text or bytes, such that reading it gives the same mesh.
///
/// Each group becomes a physical group. The nodes of a curve group are joined by lines in their order, since a file has
/// no other way to say that they are on a curve.
///
/// # Errors
/// What the system says; [`io::ErrorKind::InvalidInput`] if a group's name has a quote or a line end or is there twice, or element numbers
/// leave no room for those of the groups' faces.
pub fn write_gmsh(out: &mut impl Write, mesh: &Mesh, binary: bool) -> io::Result<()> {
    let mut physical_names = String::new();
    let mut taken = HashSet::new();
    for ((number, group), name) in (1..).zip(mesh.groups()).zip(mesh.full_names()) {
        let dimension = dimension(group.kind);
        let refused = |what| {
            let message = format!("the group name {name:?} {what}; rename it");
            Err(io::Error::new(io::ErrorKind::InvalidInput, message))
        };
        if name.contains(['"', '\n', '\r']) {
            return refused("has a quote or a line end");
        }
        physical_names += &format!("{dimension} {number} \"{name}\"\n");
        if !taken.insert((dimension, name.clone())) {
            return refused("is that of two groups of one dimension");
        }
    }
    let blocks = blocks(mesh)?;

    let mut out = Numbers { out, binary };
    let file_type = i32::from(binary);
    out.text(&format!("$MeshFormat\n4.1 {file_type} 8\n"))?;
    if binary {
        out.ints(&[1])?;
        out.text("\n")?;
    }
    out.text("$EndMeshFormat\n")?;
    if !mesh.groups().is_empty() {
        let count = mesh.groups().len();
        out.text(&format!("$PhysicalNames\n{count}\n{physical_names}$EndPhysicalNames\n"))?;
    }
    out.entities(&blocks)?;
    out.nodes(mesh)?;
    out.elements(&blocks)
}

/// [`write_gmsh`] into a file, which is written whole or not at all.
///
/// # Errors
/// As [`write_gmsh`].
pub fn write_gmsh_file(path: &Path, mesh: &Mesh, binary: bool) -> io::Result<()> {
    let mut file = AtomicFile::create(path)?;
    write_gmsh(&mut file, mesh, binary)?;
    file.commit()
}

fn dimension(kind: GroupKind) -> usize {
    match kind {
        GroupKind::Point | GroupKind::Nodes => 0,
        GroupKind::Curve => 1,
        GroupKind::Surface => 2,
        GroupKind::Volume => 3,
    }
}

/// The elements of one geometric entity.
struct Block {
    dimension: usize,
    /// The entity's number, unique within its dimension.
    entity: i32,
    physical: Vec<i32>,
    element_type: i32,
    /// Number and nodes of each element, one after another.
    words: Vec<u64>,
    words_each: usize,
    /// A point's position, or the mesh's extent.
    bounds: Vec<f64>,
}

/// One entity for every shape and combination of volume groups that an element is in, and at least one for every other group.
fn blocks(mesh: &Mesh) -> io::Result<Vec<Block>> {
    let extent: Vec<f64> = mesh.extent().concat();
    let label = |node: u32| mesh.node_labels()[node as usize].0;
    let mut memberships: Vec<Vec<i32>> = vec![Vec::new(); mesh.element_count()];
    for (number, group) in (1..).zip(mesh.groups()) {
        for &element in &group.elements {
            memberships[element as usize].push(number);
        }
    }
    let mut position: HashMap<(Shape, Vec<i32>), usize> = HashMap::new();
    let mut blocks: Vec<Block> = Vec::new();
    for (element, membership) in memberships.into_iter().enumerate() {
        let shape = mesh.elements().shape(element);
        let block = *position.entry((shape, membership)).or_insert_with_key(|(_, physical)| {
            blocks.push(Block {
                dimension: 3,
                entity: blocks.len() as i32 + 1,
                physical: physical.clone(),
                element_type: solid_code(shape),
                words: Vec::new(),
                words_each: 1 + shape.node_count(),
                bounds: extent.clone(),
            });
            blocks.len() - 1
        });
        let words = &mut blocks[block].words;
        words.push(mesh.element_labels()[element].0);
        let first = words.len();
        words.extend(mesh.elements().nodes(element).iter().map(|&node| label(node)));
        swap_order(shape, &mut words[first..]);
    }

    let mut next_number = mesh.element_labels().iter().map(|number| number.0).max().unwrap_or(0);
    let mut number = || {
        next_number = next_number.checked_add(1).ok_or_else(|| {
            io::Error::new(io::ErrorKind::InvalidInput, "element numbers leave no room for the groups' faces; renumber")
        })?;
        Ok::<u64, io::Error>(next_number)
    };
    let mut entity = 0;
    for (physical, group) in (1..).zip(mesh.groups()) {
        for (element_type, elements, bounds) in boundary_elements(mesh, group, &extent) {
            entity += 1;
            let words_each = 1 + elements.first().map_or(0, Vec::len);
            let mut words = Vec::with_capacity(words_each * elements.len());
            for nodes in elements {
                words.push(number()?);
                words.extend(nodes.into_iter().map(label));
            }
            let dimension = dimension(group.kind);
            blocks.push(Block { dimension, entity, physical: vec![physical], element_type, words, words_each, bounds });
        }
    }
    Ok(blocks)
}

/// The entities of a surface, curve or point group: type, nodes of each element, bounds.
fn boundary_elements(mesh: &Mesh, group: &Group, extent: &[f64]) -> Vec<(i32, Vec<Vec<u32>>, Vec<f64>)> {
    match group.kind {
        GroupKind::Volume => Vec::new(),
        GroupKind::Surface => {
            let of_type = |code: i32, node_count: usize| {
                let faces = group.faces.iter().map(Face::nodes).filter(|nodes| nodes.len() == node_count);
                (code, faces.map(<[u32]>::to_vec).collect::<Vec<_>>(), extent.to_vec())
            };
            let all = [of_type(QUAD4, 4), of_type(TRIANGLE3, 3), of_type(TRIANGLE6, 6)];
            all.into_iter().filter(|(_, faces, _)| !faces.is_empty()).collect()
        }
        GroupKind::Curve => {
            let mut lines: Vec<Vec<u32>> = group.nodes.windows(2).map(<[u32]>::to_vec).collect();
            if let [only] = group.nodes[..] {
                lines.push(vec![only, only]);
            }
            vec![(LINE2, lines, extent.to_vec())]
        }
        GroupKind::Point | GroupKind::Nodes => group
            .nodes
            .iter()
            .map(|&node| (POINT, vec![vec![node]], mesh.coordinates()[node as usize].to_vec()))
            .collect(),
    }
}

/// Writes numbers as text or bytes.
struct Numbers<'a, W: Write> {
    out: &'a mut W,
    binary: bool,
}

impl<W: Write> Numbers<'_, W> {
    fn text(&mut self, text: &str) -> io::Result<()> {
        self.out.write_all(text.as_bytes())
    }

    fn sizes(&mut self, values: &[u64]) -> io::Result<()> {
        self.numbers(values, |value| value.to_le_bytes())
    }

    fn ints(&mut self, values: &[i32]) -> io::Result<()> {
        self.numbers(values, |value| value.to_le_bytes())
    }

    fn doubles(&mut self, values: &[f64]) -> io::Result<()> {
        self.numbers(values, |value| value.to_le_bytes())
    }

    /// `Debug` prints the shortest digits that read back as the same number, with an exponent where that is shorter.
    fn numbers<T: std::fmt::Debug, const SIZE: usize>(
        &mut self,
        values: &[T],
        bytes: impl Fn(&T) -> [u8; SIZE],
    ) -> io::Result<()> {
        for value in values {
            if self.binary {
                self.out.write_all(&bytes(value))?;
            } else {
                write!(self.out, "{value:?} ")?;
            }
        }
        Ok(())
    }

    fn end_of_line(&mut self) -> io::Result<()> {
        if self.binary { Ok(()) } else { self.text("\n") }
    }

    fn entities(&mut self, blocks: &[Block]) -> io::Result<()> {
        self.text("$Entities\n")?;
        let of_dimension = |dimension| blocks.iter().filter(move |block| block.dimension == dimension);
        self.sizes(&[0, 1, 2, 3].map(|dimension| of_dimension(dimension).count() as u64))?;
        self.end_of_line()?;
        for dimension in 0..4 {
            for block in of_dimension(dimension) {
                self.ints(&[block.entity])?;
                self.doubles(&block.bounds)?;
                self.sizes(&[block.physical.len() as u64])?;
                self.ints(&block.physical)?;
                if dimension > 0 {
                    // No boundary is recorded: the mesh is all there is.
                    self.sizes(&[0])?;
                }
                self.end_of_line()?;
            }
        }
        self.text(if self.binary { "\n$EndEntities\n" } else { "$EndEntities\n" })
    }

    fn nodes(&mut self, mesh: &Mesh) -> io::Result<()> {
        let labels = mesh.node_labels().iter().map(|label| label.0);
        let (least, greatest) = (labels.clone().min().unwrap_or(1), labels.clone().max().unwrap_or(1));
        let count = mesh.node_count() as u64;
        self.text("$Nodes\n")?;
        self.sizes(&[1, count, least, greatest])?;
        self.end_of_line()?;
        // All nodes on the first volume.
        self.ints(&[3, 1, 0])?;
        self.sizes(&[count])?;
        self.end_of_line()?;
        for label in labels {
            self.sizes(&[label])?;
            self.end_of_line()?;
        }
        for position in mesh.coordinates() {
            self.doubles(position)?;
            self.end_of_line()?;
        }
        self.text(if self.binary { "\n$EndNodes\n" } else { "$EndNodes\n" })
    }

    fn elements(&mut self, blocks: &[Block]) -> io::Result<()> {
        let numbers = blocks.iter().flat_map(|block| block.words.iter().step_by(block.words_each));
        let (least, greatest) = (numbers.clone().min().unwrap_or(&1), numbers.clone().max().unwrap_or(&1));
        self.text("$Elements\n")?;
        self.sizes(&[blocks.len() as u64, numbers.clone().count() as u64, *least, *greatest])?;
        self.end_of_line()?;
        for block in blocks {
            // The dimension is 0 to 3.
            self.ints(&[block.dimension as i32, block.entity, block.element_type])?;
            self.sizes(&[(block.words.len() / block.words_each) as u64])?;
            self.end_of_line()?;
            for words in block.words.chunks_exact(block.words_each) {
                self.sizes(words)?;
                self.end_of_line()?;
            }
        }
        self.text(if self.binary { "\n$EndElements\n" } else { "$EndElements\n" })
    }
}
