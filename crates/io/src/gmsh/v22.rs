//! Format 2.2 (and 2.0, 2.1, which differ in nothing read here).

use std::collections::{BTreeMap, HashMap};

use estar_mesh::{ElementNodes, Face, NodeLabel};

use super::element_type::{ElementType, Use, swap_order};
use super::groups::{Level, PhysicalGroups};
use super::{next_section, section_end, skip_section};
use crate::MeshFile;
use crate::assembly::{Assembly, LabelIndex};
use crate::cursor::Cursor;
use crate::error::{Located, Place, Problem};

/// More tags than partitions and groups ever give an element.
const MOST_TAGS: i32 = 1_000_000;

pub(super) fn read(mut cursor: Cursor, format: String) -> Result<MeshFile, Located> {
    let mut physical = PhysicalGroups::default();
    let mut assembly = Assembly::default();
    let mut index = None;
    let mut has_elements = false;
    while let Some(name) = next_section(&mut cursor)? {
        let second = |section| Err(cursor.fail(Problem::SecondSection { section }));
        match (name, &index) {
            (b"PhysicalNames", _) => physical.read_names(&mut cursor)?,
            (b"Nodes", Some(_)) => return second("Nodes"),
            (b"Nodes", None) => {
                read_nodes(&mut cursor, &mut assembly)?;
                index = Some(LabelIndex::of_nodes(&assembly.node_labels).map_err(|problem| problem.at(Place::File))?);
            }
            (b"Elements", _) if has_elements => return second("Elements"),
            (b"Elements", Some(index)) => {
                has_elements = true;
                Reader { index, physical: &mut physical, assembly: &mut assembly, solids_by_nodes: HashMap::new() }
                    .read_elements(&mut cursor)?;
            }
            (b"Elements", None) => {
                return Err(cursor.fail(Problem::MissingSection { section: "Nodes", before: " before $Elements" }));
            }
            (other, _) => skip_section(&mut cursor, other)?,
        }
    }
    for (found, section) in [(index.is_some(), "Nodes"), (has_elements, "Elements")] {
        if !found {
            return Err(Problem::MissingSection { section, before: "" }.at(Place::File));
        }
    }
    if assembly.elements.is_empty() {
        return Err(Problem::NoVolume.at(Place::File));
    }
    assembly.groups = physical.finish(&mut assembly.warnings);
    assembly.finish(format).map_err(|problem| problem.at(Place::File))
}

/// A count that opens a section: text, on a line of its own, in binary files too.
fn count_line(cursor: &mut Cursor, what: &'static str) -> Result<u64, Located> {
    let at = *cursor;
    let line = cursor.line();
    std::str::from_utf8(line)
        .ok()
        .and_then(|text| text.parse().ok())
        .ok_or_else(|| at.fail(Problem::NotANumber { what, found: crate::error::excerpt(line) }))
}

/// A label, which this format writes as `int`.
fn label(cursor: &mut Cursor, what: &'static str) -> Result<u64, Located> {
    if !cursor.binary {
        return cursor.size(what);
    }
    let at = *cursor;
    let value = cursor.int(what)?;
    u64::try_from(value).map_err(|_| at.fail(Problem::BadValue { what, value: i128::from(value) }))
}

fn read_nodes(cursor: &mut Cursor, assembly: &mut Assembly) -> Result<(), Located> {
    cursor.within = "$Nodes";
    let count = count_line(cursor, "the number of nodes")?;
    cursor.check_room("nodes", count, 4, 28)?;
    assembly.coordinates.reserve(count as usize);
    assembly.node_labels.reserve(count as usize);
    for _ in 0..count {
        assembly.node_labels.push(NodeLabel(label(cursor, "a node's number")?));
        let mut position = [0.0; 3];
        for value in &mut position {
            *value = cursor.double("a coordinate")?;
        }
        assembly.coordinates.push(position);
    }
    section_end(cursor, "Nodes")
}

struct Reader<'a> {
    index: &'a LabelIndex,
    physical: &'a mut PhysicalGroups,
    assembly: &'a mut Assembly,
    /// An element of several physical groups is written once for each, under another number.
    solids_by_nodes: HashMap<ElementNodes, (u32, Option<(Level, i32)>)>,
}

impl Reader<'_> {
    fn read_elements(&mut self, cursor: &mut Cursor) -> Result<(), Located> {
        cursor.within = "$Elements";
        let count = count_line(cursor, "the number of elements")?;
        cursor.check_room("elements", count, 4, 8)?;
        let mut unsupported: BTreeMap<i32, (ElementType, u64, u64, Place)> = BTreeMap::new();
        let (mut tags, mut nodes) = (Vec::new(), Vec::new());
        let mut done = 0;
        while done < count {
            // Text: number type tag-count tags nodes. Bytes: type element-count tag-count, then elements without them.
            let at = *cursor;
            let text_label = if cursor.binary { None } else { Some(label(cursor, "an element's number")?) };
            let code = cursor.int("an element type")?;
            let block_count = if cursor.binary { cursor.int("the number of elements of a block")? } else { 1 };
            let tag_count = cursor.int("the number of tags")?;
            if !(0..=MOST_TAGS).contains(&tag_count) {
                return Err(at.fail(Problem::BadValue { what: "the number of tags", value: i128::from(tag_count) }));
            }
            let block_count = match u64::try_from(block_count) {
                Ok(number) if number > 0 && number <= count - done => number,
                _ => {
                    let what = "the number of elements of a block";
                    return Err(at.fail(Problem::BadValue { what, value: i128::from(block_count) }));
                }
            };
            let Some(element_type) = ElementType::of(code) else {
                let element = text_label.map_or_else(|| label(cursor, "an element's number"), Ok)?;
                return Err(at.fail(Problem::UnknownElementType { element, code: i64::from(code) }));
            };
            for _ in 0..block_count {
                let place = if cursor.binary { cursor.place() } else { at.place() };
                let element = text_label.map_or_else(|| label(cursor, "an element's number"), Ok)?;
                tags.clear();
                for _ in 0..tag_count {
                    tags.push(cursor.int("a tag")?);
                }
                nodes.clear();
                for _ in 0..element_type.node_count {
                    nodes.push(label(cursor, "a node of an element")?);
                }
                // The first tag is the physical group, the second the entity; 0 is none.
                let tag = |place: usize| tags.get(place).copied().filter(|number| *number != 0);
                let physical = tag(0).map(|number| (Level::Physical, number));
                let group = physical.or(tag(1).map(|number| (Level::Entity, number)));
                if element_type.usage() != Use::Unsupported {
                    self.add(element, element_type, &nodes, group).map_err(|problem| problem.at(place))?;
                } else if element_type.dimension == 3 || physical.is_some() {
                    unsupported.entry(code).or_insert((element_type, 0, element, place)).1 += 1;
                }
            }
            done += block_count;
        }
        section_end(cursor, "Elements")?;
        let mut unsupported: Vec<_> = unsupported.into_values().collect();
        unsupported.sort_by_key(|(element_type, ..)| 3 - element_type.dimension);
        match unsupported.first() {
            None => Ok(()),
            Some(&(.., place)) => {
                let list = unsupported.into_iter().map(|(kind, count, first, _)| kind.unsupported(count, first));
                Err(Problem::UnsupportedElements(list.collect()).at(place))
            }
        }
    }

    fn add(
        &mut self,
        element: u64,
        kind: ElementType,
        nodes: &[u64],
        group: Option<(Level, i32)>,
    ) -> Result<(), Problem> {
        let position = group.map(|(level, number)| self.physical.position(kind.dimension, level, number));
        if position.is_none() && !matches!(kind.usage(), Use::Solid(_)) {
            return Ok(());
        }
        let mut nodes = self.index.nodes(element, nodes)?;
        let number = group;
        let group = position.map(|position| self.physical.group_mut(position));
        match (kind.usage(), group) {
            (Use::Solid(shape), group) => {
                swap_order(shape, &mut nodes);
                let solid = match self.solids_by_nodes.get(&nodes) {
                    Some(&(first, first_number)) if first_number != number => first,
                    _ => {
                        let solid = self.assembly.add(element, shape, &nodes);
                        self.solids_by_nodes.insert(nodes, (solid, number));
                        solid
                    }
                };
                if let Some(group) = group {
                    group.elements.push(solid);
                }
            }
            (Use::Face, Some(group)) => group.faces.extend(Face::new(&nodes)),
            (_, Some(group)) => group.nodes.extend(nodes),
            (_, None) => {}
        }
        Ok(())
    }
}
