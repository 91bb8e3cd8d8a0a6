//! Format 4.1.
//!
//! The sections may come in any order: `$Elements` is framed where it is met, its counts compared with the size of the file,
//! and its numbers are read when all nodes are known. So a bad header costs nothing.

use std::collections::{BTreeMap, HashMap};

use estar_mesh::{ElementNodes, Face, NodeLabel};

use super::element_type::{ElementType, Use, swap_order};
use super::groups::PhysicalGroups;
use super::{next_section, section_end, skip_section};
use crate::MeshFile;
use crate::assembly::{Assembly, NodeIndex};
use crate::cursor::Cursor;
use crate::error::{Located, Place, Problem};

/// The physical groups of each geometric entity, by dimension and number.
type EntityGroups = HashMap<(usize, i32), Vec<i32>>;

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
    /// At the first element.
    start: Cursor<'a>,
}

pub(super) fn read(mut cursor: Cursor, format: String) -> Result<MeshFile, Located> {
    let mut physical = PhysicalGroups::default();
    let mut entity_groups = EntityGroups::new();
    let (mut nodes, mut elements) = (None, None);
    while let Some(name) = next_section(&mut cursor)? {
        let second = |section| Err(cursor.fail(Problem::SecondSection { section }));
        match name {
            b"PhysicalNames" => physical.read_names(&mut cursor)?,
            b"Entities" => read_entities(&mut cursor, &mut entity_groups)?,
            b"Nodes" if nodes.is_some() => return second("Nodes"),
            b"Nodes" => nodes = Some(read_nodes(&mut cursor)?),
            b"Elements" if elements.is_some() => return second("Elements"),
            b"Elements" => elements = Some(frame_elements(&mut cursor)?),
            b"PartitionedEntities" => return Err(cursor.fail(Problem::Partitioned)),
            other => skip_section(&mut cursor, other)?,
        }
    }
    let missing = |section| Problem::MissingSection { section, before: "" }.at(Place::File);
    let nodes = nodes.ok_or_else(|| missing("Nodes"))?;
    let elements = elements.ok_or_else(|| missing("Elements"))?;
    refuse_unsupported(&elements, &entity_groups)?;
    if nodes.labels.is_empty() || elements.iter().all(|block| block.count == 0) {
        return Err(Problem::Mesh(estar_mesh::MeshError::NoElements).at(Place::File));
    }

    let index = NodeIndex::new(&nodes.labels);
    let mut assembly = Assembly { coordinates: nodes.coordinates, node_labels: nodes.labels, ..Assembly::default() };
    for block in &elements {
        let dimension = block.element_type.dimension;
        let groups: Vec<usize> = entity_groups
            .get(&block.entity)
            .into_iter()
            .flatten()
            .map(|number| physical.position(dimension, *number))
            .collect();
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
    assembly.groups = physical.finish().map_err(|problem| problem.at(Place::File))?;
    assembly.finish(format).map_err(|problem| problem.at(Place::File))
}

impl ElementBlock<'_> {
    /// Calls `visit` with the number of each element and the indices of its nodes.
    fn for_each(&self, index: &NodeIndex, mut visit: impl FnMut(u64, ElementNodes)) -> Result<(), Located> {
        let mut cursor = self.start;
        let mut nodes = Vec::new();
        for _ in 0..self.count {
            let at = cursor;
            let label = cursor.size("an element's number")?;
            nodes.clear();
            for _ in 0..self.element_type.node_count {
                nodes.push(cursor.size("a node's number")?);
            }
            visit(label, index.nodes(label, &nodes).map_err(|problem| problem.at(at.next_place()))?);
        }
        Ok(())
    }
}

/// Notes the physical groups of every entity.
fn read_entities(cursor: &mut Cursor, groups: &mut EntityGroups) -> Result<(), Located> {
    cursor.within = "$Entities";
    let mut counts = [0; 4];
    for count in &mut counts {
        *count = cursor.size("the number of entities")?;
    }
    for (dimension, count) in counts.into_iter().enumerate() {
        // A point has its position, everything else a bounding box.
        let coordinate_count = if dimension == 0 { 3 } else { 6 };
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

/// The totals that open `$Nodes` and `$Elements`: blocks and entries. The least and greatest number are of no use.
fn totals(cursor: &mut Cursor) -> Result<(u64, u64), Located> {
    let block_count = cursor.size("the number of blocks")?;
    let total = cursor.size("the total")?;
    cursor.size("the least number")?;
    cursor.size("the greatest number")?;
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

fn read_nodes(cursor: &mut Cursor) -> Result<Nodes, Located> {
    cursor.within = "$Nodes";
    let (block_count, total) = totals(cursor)?;
    let mut nodes = Nodes { labels: Vec::new(), coordinates: Vec::new() };
    for _ in 0..block_count {
        cursor.int("an entity's dimension")?;
        cursor.int("an entity's number")?;
        if cursor.int("the parametric flag")? != 0 {
            return Err(cursor.fail(Problem::Parametric));
        }
        let count = cursor.size("the number of nodes of a block")?;
        cursor.check_room("nodes", count, 4, 32)?;
        nodes.labels.reserve(count as usize);
        nodes.coordinates.reserve(count as usize);
        for _ in 0..count {
            nodes.labels.push(NodeLabel(cursor.size("a node's number")?));
        }
        for _ in 0..count {
            let mut position = [0.0; 3];
            for coordinate in &mut position {
                *coordinate = cursor.double("a coordinate")?;
            }
            nodes.coordinates.push(position);
        }
    }
    add_up(cursor, "nodes", total, [nodes.labels.len() as u64].into_iter())?;
    section_end(cursor, "Nodes")?;
    Ok(nodes)
}

fn frame_elements<'a>(cursor: &mut Cursor<'a>) -> Result<Vec<ElementBlock<'a>>, Located> {
    cursor.within = "$Elements";
    let (block_count, total) = totals(cursor)?;
    let mut blocks = Vec::new();
    for _ in 0..block_count {
        let at = *cursor;
        let dimension = cursor.int("an entity's dimension")?;
        let tag = cursor.int("an entity's number")?;
        let code = cursor.int("an element type")?;
        let count = cursor.size("the number of elements of a block")?;
        let start = *cursor;
        let Some(element_type) = ElementType::of(code) else {
            let element = cursor.size("an element's number")?;
            return Err(start.fail(Problem::UnknownElementType { element, code: i64::from(code) }));
        };
        if usize::try_from(dimension) != Ok(element_type.dimension) {
            return Err(at.fail(Problem::BadValue { what: "an entity's dimension", value: i128::from(dimension) }));
        }
        let word_count = 1 + element_type.node_count as u64;
        cursor.skip("elements", count, word_count, 8 * word_count)?;
        blocks.push(ElementBlock { entity: (element_type.dimension, tag), element_type, count, start });
    }
    add_up(cursor, "elements", total, blocks.iter().map(|block| block.count))?;
    section_end(cursor, "Elements")?;
    Ok(blocks)
}

/// An error if elements that are used are of a type that is not: any solid, and any other that is in a group.
fn refuse_unsupported(blocks: &[ElementBlock], entity_groups: &EntityGroups) -> Result<(), Located> {
    let mut found: BTreeMap<i32, (ElementType, u64, Cursor)> = BTreeMap::new();
    for block in blocks {
        let used = block.element_type.dimension == 3 || entity_groups.contains_key(&block.entity);
        if block.count > 0 && used && block.element_type.usage() == Use::Unsupported {
            let tally = found.entry(block.element_type.code).or_insert((block.element_type, 0, block.start));
            tally.1 += block.count;
        }
    }
    let mut unsupported = Vec::new();
    let place = found.values().next().map(|(_, _, start)| start.place());
    for (element_type, count, mut start) in found.into_values() {
        unsupported.push((element_type.dimension, element_type.unsupported(count, start.size("an element's number")?)));
    }
    // Solids first: they are what the others follow from.
    unsupported.sort_by_key(|(dimension, _)| 3 - dimension);
    match place {
        Some(place) => Err(Problem::UnsupportedElements(unsupported.into_iter().map(|(_, u)| u).collect()).at(place)),
        None => Ok(()),
    }
}
