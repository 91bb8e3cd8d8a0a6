//! Format 4.1, through the crate `mshio`.
//!
//! `mshio` turns `$Nodes` and `$Elements` into numbers. It is only handed files that it handles well: counts are
//! compared with the size of the file first, so that a bad header costs nothing and meets none of its panics.
//! What it leaves out is read here: physical names and the groups of each entity, and node numbers, which it drops
//! when they have no gaps although their order is free.

use std::collections::{BTreeMap, HashMap};

use estar_mesh::{ElementLabel, NodeLabel};

use super::element_type::{ElementType, HEX8, LINE2, POINT, QUAD4};
use super::groups::PhysicalGroups;
use super::{next_section, section_end, skip_section};
use crate::MeshFile;
use crate::assembly::{Assembly, NodeIndex};
use crate::cursor::Cursor;
use crate::error::{Located, Place, Problem};

/// The physical groups of each geometric entity, by dimension and number.
type EntityGroups = HashMap<(usize, i32), Vec<i32>>;

/// What is known of a section before its numbers are read.
#[derive(Debug)]
struct Framed<'a, Block> {
    blocks: Vec<Block>,
    /// From after the section's totals to its end.
    body: Cursor<'a>,
    end: usize,
    total: u64,
}

#[derive(Debug)]
struct NodeBlock {
    labels: Vec<NodeLabel>,
}

#[derive(Debug)]
struct ElementBlock<'a> {
    entity: (usize, i32),
    element_type: ElementType,
    count: u64,
    /// At the first element.
    start: Cursor<'a>,
}

pub(super) fn read(bytes: &[u8], mut cursor: Cursor, format: String) -> Result<MeshFile, Located> {
    let mut physical = PhysicalGroups::default();
    let mut entity_groups = EntityGroups::new();
    let (mut nodes, mut elements) = (None, None);
    while let Some(name) = next_section(&mut cursor)? {
        let second = |section| Err(cursor.fail(Problem::SecondSection { section }));
        match name {
            b"PhysicalNames" => physical.read_names(&mut cursor)?,
            b"Entities" => read_entities(&mut cursor, &mut entity_groups)?,
            b"Nodes" if nodes.is_some() => return second("Nodes"),
            b"Nodes" => nodes = Some(frame_nodes(&mut cursor)?),
            b"Elements" if elements.is_some() => return second("Elements"),
            b"Elements" => elements = Some(frame_elements(&mut cursor)?),
            b"PartitionedEntities" => return Err(cursor.fail(Problem::Partitioned)),
            other => skip_section(&mut cursor, other)?,
        }
    }
    let missing = |section| Problem::MissingSection { section, before: "" }.at(Place::File);
    let nodes = nodes.ok_or_else(|| missing("Nodes"))?;
    let elements = elements.ok_or_else(|| missing("Elements"))?;
    refuse_unsupported(&elements.blocks, &entity_groups)?;

    let parsed = parse(bytes, &nodes, &elements)?;
    let (Some(parsed_nodes), Some(parsed_elements)) = (parsed.data.nodes, parsed.data.elements) else {
        return Err(missing("Nodes"));
    };

    let mut assembly = Assembly::default();
    // The parser splits words such as 1-1 in two: then it reads other numbers than were counted.
    let damaged =
        || Problem::Parser { message: "the numbers are not as Gmsh writes them; export the mesh again".into() };
    for (block, framed) in parsed_nodes.node_blocks.into_iter().zip(nodes.blocks) {
        if block.nodes.len() != framed.labels.len() {
            return Err(damaged().at(nodes.body.place()));
        }
        assembly.coordinates.extend(block.nodes.iter().map(|node| [node.x, node.y, node.z]));
        assembly.node_labels.extend(framed.labels);
    }
    let index = NodeIndex::new(&assembly.node_labels);
    for (block, framed) in parsed_elements.element_blocks.into_iter().zip(&elements.blocks) {
        if block.elements.len() as u64 != framed.count || block.element_type as i32 != framed.element_type.code {
            return Err(damaged().at(framed.start.place()));
        }
        let dimension = framed.element_type.dimension;
        let groups: Vec<usize> = entity_groups
            .get(&framed.entity)
            .into_iter()
            .flatten()
            .map(|number| physical.position(dimension, *number))
            .collect();
        if framed.element_type.code == HEX8 {
            let first = assembly.hexes.len() as u32;
            for (k, element) in block.elements.iter().enumerate() {
                let corners = index.corners(element.element_tag, &element.nodes);
                assembly.hexes.push(corners.map_err(|problem| problem.at(framed.place_of(k)))?);
                assembly.hex_labels.push(ElementLabel(element.element_tag));
            }
            for &group in &groups {
                physical.group_mut(group).hexes.extend(first..assembly.hexes.len() as u32);
            }
        } else if !groups.is_empty() {
            for (k, element) in block.elements.iter().enumerate() {
                let located = |problem: Problem| problem.at(framed.place_of(k));
                let tag = element.element_tag;
                for &group in &groups {
                    let group = physical.group_mut(group);
                    match framed.element_type.code {
                        QUAD4 => group.faces.push(index.corners(tag, &element.nodes).map_err(located)?),
                        LINE2 => group.nodes.extend(index.corners::<2>(tag, &element.nodes).map_err(located)?),
                        POINT => group.nodes.extend(index.corners::<1>(tag, &element.nodes).map_err(located)?),
                        _ => {}
                    }
                }
            }
        }
    }
    assembly.groups = physical.finish().map_err(|problem| problem.at(Place::File))?;
    assembly.finish(format).map_err(|problem| problem.at(Place::File))
}

impl ElementBlock<'_> {
    /// Where an element is in the file; only asked for when something is wrong with it.
    fn place_of(&self, element: usize) -> Place {
        let mut cursor = self.start;
        let word_count = 1 + self.element_type.node_count as u64;
        match cursor.skip("elements", element as u64, word_count, 8 * word_count) {
            Ok(()) => {
                if !cursor.binary {
                    cursor.skip_white_space();
                }
                cursor.place()
            }
            Err(_) => self.start.place(),
        }
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

fn frame_nodes<'a>(cursor: &mut Cursor<'a>) -> Result<Framed<'a, NodeBlock>, Located> {
    cursor.within = "$Nodes";
    let (block_count, total) = totals(cursor)?;
    let body = *cursor;
    let mut blocks = Vec::new();
    for _ in 0..block_count {
        cursor.int("an entity's dimension")?;
        cursor.int("an entity's number")?;
        if cursor.int("the parametric flag")? != 0 {
            return Err(cursor.fail(Problem::Parametric));
        }
        let count = cursor.size("the number of nodes of a block")?;
        cursor.check_room("nodes", count, 4, 32)?;
        let mut labels = Vec::with_capacity(count as usize);
        for _ in 0..count {
            labels.push(NodeLabel(cursor.size("a node's number")?));
        }
        cursor.skip("coordinates", count, 3, 24)?;
        blocks.push(NodeBlock { labels });
    }
    add_up(cursor, "nodes", total, blocks.iter().map(|block| block.labels.len() as u64))?;
    let end = cursor.position();
    section_end(cursor, "Nodes")?;
    Ok(Framed { blocks, body, end, total })
}

fn frame_elements<'a>(cursor: &mut Cursor<'a>) -> Result<Framed<'a, ElementBlock<'a>>, Located> {
    cursor.within = "$Elements";
    let (block_count, total) = totals(cursor)?;
    let body = *cursor;
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
    let end = cursor.position();
    section_end(cursor, "Elements")?;
    Ok(Framed { blocks, body, end, total })
}

/// An error if elements that are used are of a type that is not: any solid, and any other that is in a group.
fn refuse_unsupported(blocks: &[ElementBlock], entity_groups: &EntityGroups) -> Result<(), Located> {
    let mut found: BTreeMap<i32, (ElementType, u64, Cursor)> = BTreeMap::new();
    for block in blocks {
        let used = block.element_type.dimension == 3 || entity_groups.contains_key(&block.entity);
        if block.count > 0 && used && !block.element_type.is_supported() {
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

type ParsedFile = mshio::MshFile<u64, i32, f64>;

/// `mshio` on the two sections it is needed for, under a header of our own.
fn parse(bytes: &[u8], nodes: &Framed<NodeBlock>, elements: &Framed<ElementBlock>) -> Result<ParsedFile, Located> {
    if nodes.total == 0 || elements.total == 0 {
        return Err(Problem::Mesh(estar_mesh::MeshError::NoHexes).at(Place::File));
    }
    let binary = nodes.body.binary;
    let mut file = Vec::new();
    if binary {
        file.extend_from_slice(b"$MeshFormat\n4.1 1 8\n\x01\0\0\0\n$EndMeshFormat\n");
    } else {
        file.extend_from_slice(b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n");
    }
    // Where each section starts in the parser's file, and in the user's.
    let mut origins = Vec::new();
    let sections = [
        ("Nodes", nodes.blocks.len(), nodes.total, nodes.body, nodes.end),
        ("Elements", elements.blocks.len(), elements.total, elements.body, elements.end),
    ];
    for (section, block_count, total, body, end) in sections {
        file.extend_from_slice(format!("${section}\n").as_bytes());
        // Least and greatest number both 1: else the parser builds maps that nobody reads.
        let totals = [block_count as u64, total, 1, 1];
        if binary {
            file.extend(totals.iter().flat_map(|number| number.to_le_bytes()));
        } else {
            file.extend_from_slice(totals.map(|number| number.to_string()).join(" ").as_bytes());
        }
        origins.push((file.len(), body));
        file.extend_from_slice(&bytes[body.position()..end]);
        file.extend_from_slice(format!("\n$End{section}\n").as_bytes());
    }

    mshio::parse_msh_bytes(&file).map_err(|error| {
        let kind = error.first_msh_error().map_or_else(|| "not as Gmsh writes it".to_owned(), |kind| kind.to_string());
        let at = error.backtrace.first().map_or(0, |(rest, _)| file.len() - rest.len());
        let place = origins.iter().rev().find(|(start, _)| *start <= at).map_or(Place::File, |(start, body)| {
            let mut cursor = *body;
            cursor.skip_bytes(at - start);
            cursor.place()
        });
        Problem::Parser { message: format!("{kind} The file is damaged: export it again") }.at(place)
    })
}
