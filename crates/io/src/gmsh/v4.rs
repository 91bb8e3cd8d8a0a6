//! Formats 4.1 and 4.0, which differ in the order and the width of some numbers.
//!
//! The sections may come in any order: `$Elements` is framed where it is met, its counts compared with the size of the file,
//! and its numbers are read when all nodes are known. So a bad header costs nothing.

use std::collections::{BTreeMap, HashMap};

use estar_mesh::{ElementNodes, Face, NodeLabel};

use super::element_type::{ElementType, Use, swap_order};
use super::groups::{Level, PhysicalGroups};
use super::{next_section, section_end, skip_section};
use crate::MeshFile;
use crate::assembly::{Assembly, LabelIndex};
use crate::cursor::Cursor;
use crate::error::{Located, Place, Problem};

/// The physical groups of each geometric entity, by dimension and number.
type EntityGroups = HashMap<(usize, i32), Vec<i32>>;

/// Which of the two formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Version {
    V40,
    V41,
}

impl Version {
    /// A number of a node or an element.
    fn label(self, cursor: &mut Cursor, what: &'static str) -> Result<u64, Located> {
        if self == Self::V41 {
            return cursor.size(what);
        }
        let at = *cursor;
        let value = cursor.int(what)?;
        u64::try_from(value).map_err(|_| at.fail(Problem::BadValue { what, value: i128::from(value) }))
    }

    /// Bytes that such a number takes.
    fn label_size(self) -> u64 {
        if self == Self::V41 { 8 } else { 4 }
    }

    /// Dimension and number of the entity that opens a block.
    fn entity(self, cursor: &mut Cursor) -> Result<(i32, i32), Located> {
        let first = cursor.int("an entity's dimension or number")?;
        let second = cursor.int("an entity's dimension or number")?;
        Ok(if self == Self::V41 { (first, second) } else { (second, first) })
    }
}

/// Nodes in the order of the file.
#[derive(Debug)]
struct Nodes {
    labels: Vec<NodeLabel>,
    coordinates: Vec<[f64; 3]>,
}

#[derive(Debug)]
struct ElementBlock<'a> {
    entity: (usize, i32),
    element_type: ElementType,
    count: u64,
    version: Version,
    /// At the first element.
    start: Cursor<'a>,
}

pub(super) fn read(mut cursor: Cursor, version: Version, format: String) -> Result<MeshFile, Located> {
    let mut physical = PhysicalGroups::default();
    let mut entity_groups = EntityGroups::new();
    let (mut nodes, mut elements) = (None, None);
    while let Some(name) = next_section(&mut cursor)? {
        let second = |section| Err(cursor.fail(Problem::SecondSection { section }));
        match name {
            b"PhysicalNames" => physical.read_names(&mut cursor)?,
            b"Entities" => read_entities(&mut cursor, version, &mut entity_groups)?,
            b"Nodes" if nodes.is_some() => return second("Nodes"),
            b"Nodes" => nodes = Some(read_nodes(&mut cursor, version)?),
            b"Elements" if elements.is_some() => return second("Elements"),
            b"Elements" => elements = Some(frame_elements(&mut cursor, version)?),
            b"PartitionedEntities" => return Err(cursor.fail(Problem::Partitioned)),
            other => skip_section(&mut cursor, other)?,
        }
    }
    let missing = |section| Problem::MissingSection { section, before: "" }.at(Place::File);
    let nodes = nodes.ok_or_else(|| missing("Nodes"))?;
    let elements = elements.ok_or_else(|| missing("Elements"))?;
    refuse_unsupported(&elements, &entity_groups)?;
    if nodes.labels.is_empty() || elements.iter().all(|block| block.count == 0) {
        return Err(Problem::NoVolume.at(Place::File));
    }

    let index = LabelIndex::of_nodes(&nodes.labels).map_err(|problem| problem.at(Place::File))?;
    let mut assembly = Assembly { coordinates: nodes.coordinates, node_labels: nodes.labels, ..Assembly::default() };
    for block in &elements {
        let dimension = block.element_type.dimension;
        if block.count == 0 {
            continue;
        }
        let groups: Vec<usize> = match entity_groups.get(&block.entity) {
            Some(numbers) => {
                numbers.iter().map(|number| physical.position(dimension, Level::Physical, *number)).collect()
            }
            None => vec![physical.position(dimension, Level::Entity, block.entity.1)],
        };
        match block.element_type.usage() {
            Use::Solid(shape) => {
                let first = assembly.elements.len() as u32;
                // the count was compared with the size of the file
                assembly.elements.reserve(shape, block.count as usize);
                assembly.element_labels.reserve(block.count as usize);
                block.for_each(&index, |label, mut nodes| {
                    swap_order(shape, &mut nodes);
                    assembly.add(label, shape, &nodes);
                })?;
                for &group in &groups {
                    physical.group_mut(group).elements.extend(first..assembly.elements.len() as u32);
                }
            }
            Use::Face => {
                for &group in &groups {
                    let faces = &mut physical.group_mut(group).faces;
                    block.for_each(&index, |_, nodes| faces.extend(Face::new(&nodes)))?;
                }
            }
            Use::Nodes => {
                for &group in &groups {
                    let of_group = &mut physical.group_mut(group).nodes;
                    block.for_each(&index, |_, nodes| of_group.extend(nodes))?;
                }
            }
            Use::Unsupported => {}
        }
    }
    if assembly.elements.is_empty() {
        return Err(Problem::NoVolume.at(Place::File));
    }
    assembly.groups = physical.finish(&mut assembly.warnings);
    assembly.finish(format).map_err(|problem| problem.at(Place::File))
}

impl ElementBlock<'_> {
    /// Calls `visit` with the number of each element and the indices of its nodes.
    fn for_each(&self, index: &LabelIndex, mut visit: impl FnMut(u64, ElementNodes)) -> Result<(), Located> {
        let mut cursor = self.start;
        let mut nodes = Vec::new();
        for _ in 0..self.count {
            let at = cursor;
            let label = self.version.label(&mut cursor, "an element's number")?;
            nodes.clear();
            for _ in 0..self.element_type.node_count {
                nodes.push(self.version.label(&mut cursor, "a node's number")?);
            }
            visit(label, index.nodes(label, &nodes).map_err(|problem| problem.at(at.next_place()))?);
        }
        Ok(())
    }
}

/// Notes the physical groups of every entity.
fn read_entities(cursor: &mut Cursor, version: Version, groups: &mut EntityGroups) -> Result<(), Located> {
    cursor.within = "$Entities";
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = cursor.size("the number of entities")?;
    }
    for (dimension, count) in counts.into_iter().enumerate() {
        // A point has its position, everything else a bounding box, as points have in 4.0.
        let coordinate_count = if dimension == 0 && version == Version::V41 { 3 } else { 6 };
        for _ in 0..count {
            let tag = cursor.int("an entity's number")?;
            cursor.skip("an entity's bounds", coordinate_count, 1, 8)?;
            let physical_count = cursor.size("the number of an entity's physical groups")?;
            cursor.check_room("physical groups", physical_count, 1, 4)?;
            let mut physical = Vec::new();
            for _ in 0..physical_count {
                physical.push(cursor.int("a physical group's number")?);
            }
            if dimension > 0 {
                let boundary_count = cursor.size("the number of an entity's boundaries")?;
                cursor.skip("boundaries", boundary_count, 1, 4)?;
            }
            if !physical.is_empty() {
                groups.insert((dimension, tag), physical);
            }
        }
    }
    section_end(cursor, "Entities")
}

/// The totals that open `$Nodes` and `$Elements`: blocks and entries. The least and greatest number, in 4.1, are of no use.
fn totals(cursor: &mut Cursor, version: Version) -> Result<(u64, u64), Located> {
    let block_count = cursor.size("the number of blocks")?;
    let total = cursor.size("the total")?;
    if version == Version::V41 {
        cursor.size("the least number")?;
        cursor.size("the greatest number")?;
    }
    Ok((block_count, total))
}

/// An error unless the parts add up to the total.
fn add_up(
    cursor: &Cursor,
    what: &'static str,
    announced: u64,
    parts: impl Iterator<Item = u64>,
) -> Result<(), Located> {
    // Every part was compared with the size of the file: no overflow.
    let found: u64 = parts.sum();
    if found == announced { Ok(()) } else { Err(cursor.fail(Problem::CountMismatch { what, announced, found })) }
}

fn read_nodes(cursor: &mut Cursor, version: Version) -> Result<Nodes, Located> {
    cursor.within = "$Nodes";
    let (block_count, total) = totals(cursor, version)?;
    let mut nodes = Nodes { labels: Vec::new(), coordinates: Vec::new() };
    for _ in 0..block_count {
        let at = *cursor;
        let (dimension, _) = version.entity(cursor)?;
        if !(0..=3).contains(&dimension) {
            return Err(at.fail(Problem::BadValue { what: "an entity's dimension", value: i128::from(dimension) }));
        }
        // behind its position each node may have parameters, as many as its entity has dimensions
        let has_parameters = cursor.int("the parametric flag")? != 0;
        let parameter_count = if has_parameters { dimension as u64 } else { 0 };
        let count = cursor.size("the number of nodes of a block")?;
        let numbers = 3 + parameter_count;
        cursor.check_room("nodes", count, 1 + numbers, version.label_size() + 8 * numbers)?;
        nodes.labels.reserve(count as usize);
        nodes.coordinates.reserve(count as usize);
        if version == Version::V41 {
            for _ in 0..count {
                nodes.labels.push(NodeLabel(cursor.size("a node's number")?));
            }
        }
        for _ in 0..count {
            if version == Version::V40 {
                nodes.labels.push(NodeLabel(version.label(cursor, "a node's number")?));
            }
            let mut position = [0.0; 3];
            for coordinate in &mut position {
                *coordinate = cursor.double("a coordinate")?;
            }
            for _ in 0..parameter_count {
                cursor.double("a parameter of a node")?;
            }
            nodes.coordinates.push(position);
        }
    }
    add_up(cursor, "nodes", total, [nodes.labels.len() as u64].into_iter())?;
    section_end(cursor, "Nodes")?;
    Ok(nodes)
}

fn frame_elements<'a>(cursor: &mut Cursor<'a>, version: Version) -> Result<Vec<ElementBlock<'a>>, Located> {
    cursor.within = "$Elements";
    let (block_count, total) = totals(cursor, version)?;
    let mut blocks = Vec::new();
    for _ in 0..block_count {
        let at = *cursor;
        let (dimension, tag) = version.entity(cursor)?;
        let code = cursor.int("an element type")?;
        let count = cursor.size("the number of elements of a block")?;
        let start = *cursor;
        let Some(element_type) = ElementType::of(code) else {
            let element = version.label(cursor, "an element's number")?;
            return Err(start.fail(Problem::UnknownElementType { element, code: i64::from(code) }));
        };
        if usize::try_from(dimension) != Ok(element_type.dimension) {
            return Err(at.fail(Problem::BadValue { what: "an entity's dimension", value: i128::from(dimension) }));
        }
        let word_count = 1 + element_type.node_count as u64;
        cursor.skip("elements", count, word_count, version.label_size() * word_count)?;
        let entity = (element_type.dimension, tag);
        blocks.push(ElementBlock { entity, element_type, count, version, start });
    }
    add_up(cursor, "elements", total, blocks.iter().map(|block| block.count))?;
    section_end(cursor, "Elements")?;
    Ok(blocks)
}

/// An error if elements that are used are of a type that is not: any solid, and any other that is in a group.
fn refuse_unsupported(blocks: &[ElementBlock], entity_groups: &EntityGroups) -> Result<(), Located> {
    let mut found: BTreeMap<i32, (&ElementBlock, u64)> = BTreeMap::new();
    for block in blocks {
        let used = block.element_type.dimension == 3 || entity_groups.contains_key(&block.entity);
        if block.count > 0 && used && block.element_type.usage() == Use::Unsupported {
            found.entry(block.element_type.code).or_insert((block, 0)).1 += block.count;
        }
    }
    let mut unsupported = Vec::new();
    let place = found.values().next().map(|(block, _)| block.start.place());
    for (block, count) in found.into_values() {
        let first = block.version.label(&mut block.start.clone(), "an element's number")?;
        unsupported.push((block.element_type.dimension, block.element_type.unsupported(count, first)));
    }
    // Solids first: they are what the others follow from.
    unsupported.sort_by_key(|(dimension, _)| 3 - dimension);
    match place {
        Some(place) => Err(Problem::UnsupportedElements(unsupported.into_iter().map(|(_, u)| u).collect()).at(place)),
        None => Ok(()),
    }
}
