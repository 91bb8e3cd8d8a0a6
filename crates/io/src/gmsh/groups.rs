//! Physical groups: numbers with a dimension, most of them with a name. A geometric entity that is in none is a group itself.

use std::collections::{BTreeMap, HashMap};

use estar_mesh::{Group, GroupKind};

use super::section_end;
use crate::cursor::Cursor;
use crate::error::{Located, Problem, and_more, excerpt, visible_name};

/// The kind of group of each dimension.
const KINDS: [GroupKind; 4] = [GroupKind::Point, GroupKind::Curve, GroupKind::Surface, GroupKind::Volume];

/// What a number stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Level {
    Physical,
    Entity,
}

/// A group is known by its level, its dimension and its number.
type Key = (usize, Level, i32);

/// The physical groups of a file, filled element by element.
#[derive(Debug, Default)]
pub(super) struct PhysicalGroups {
    /// Of physical groups, by dimension and number.
    names: BTreeMap<(usize, i32), String>,
    position: HashMap<Key, usize>,
    groups: Vec<(Key, Group)>,
}

impl PhysicalGroups {
    /// Reads `$PhysicalNames`, which is text in binary files too: `dimension number "name"` on each line.
    pub fn read_names(&mut self, cursor: &mut Cursor) -> Result<(), Located> {
        cursor.within = "$PhysicalNames";
        let at = *cursor;
        let count_line = cursor.line();
        let count: Option<u64> = std::str::from_utf8(count_line).ok().and_then(|text| text.parse().ok());
        let Some(count) = count else {
            return Err(at.fail(Problem::NotANumber { what: "the number of names", found: excerpt(count_line) }));
        };
        for _ in 0..count {
            let at = *cursor;
            let line = cursor.line();
            if line.is_empty() && cursor.rest().is_empty() {
                return Err(at.fail(Problem::Truncated { within: "$PhysicalNames" }));
            }
            if line.starts_with(b"$") {
                return Err(at.fail(Problem::SectionTooShort { within: "$PhysicalNames" }));
            }
            let text = std::str::from_utf8(line).map_err(|_| at.fail(Problem::NameNotUtf8))?;
            let Some((key, name)) = physical_name(text) else {
                let message = format!("expected: dimension, number, \"name\"; found: {}", excerpt(line));
                return Err(at.fail(Problem::Syntax { message }));
            };
            let name = visible_name(&name).map_err(|problem| at.fail(problem))?;
            self.names.insert(key, name);
        }
        section_end(cursor, "PhysicalNames")
    }

    /// The position of a group, by which it is filled. The sign of a number is an orientation, which is of no use here.
    pub fn position(&mut self, dimension: usize, level: Level, number: i32) -> usize {
        let number = number.saturating_abs();
        *self.position.entry((dimension, level, number)).or_insert_with(|| {
            let kind = KINDS[dimension];
            let name = self.names.get(&(dimension, number)).filter(|_| level == Level::Physical);
            let name = name.cloned().unwrap_or_else(|| format!("{kind}_{number}"));
            self.groups.push(((dimension, level, number), Group::new(name, kind)));
            self.groups.len() - 1
        })
    }

    pub fn group_mut(&mut self, position: usize) -> &mut Group {
        &mut self.groups[position].1
    }

    /// All groups: volumes, surfaces, curves, points, each by number. Those of one name and dimension are one group.
    pub fn finish(self, warnings: &mut Vec<String>) -> Vec<Group> {
        let without = self
            .names
            .iter()
            .filter(|&(&(dimension, number), _)| !self.position.contains_key(&(dimension, Level::Physical, number)));
        let without: Vec<String> =
            without.map(|((dimension, _), name)| format!("{} \"{name}\"", KINDS[*dimension])).collect();
        if !without.is_empty() {
            let names = if without.len() == 1 { "name stands" } else { "names stand" };
            let count = without.len();
            warnings.push(format!(
                "{count} {names} for no elements of the file, and no group is made: {}",
                and_more(without)
            ));
        }
        let mut sorted = self.groups;
        sorted.sort_by_key(|((dimension, level, number), _)| (KINDS.len() - dimension, *level, *number));
        let mut groups: Vec<Group> = Vec::new();
        let mut by_name: HashMap<(GroupKind, String), usize> = HashMap::new();
        for ((_, level, number), mut group) in sorted {
            match by_name.get(&(group.kind, group.name.clone())) {
                Some(&first) if level == Level::Physical => {
                    let known = &mut groups[first];
                    let (kind, name) = (group.kind, &group.name);
                    warnings.push(format!(
                        "the physical {kind} {number} is named \"{name}\" as another is: both are one group"
                    ));
                    known.elements.append(&mut group.elements);
                    known.faces.append(&mut group.faces);
                    known.nodes.append(&mut group.nodes);
                    continue;
                }
                // a physical group without a name, or one that is called as the entity
                Some(&first) => {
                    groups[first].owners = vec!["physical".to_owned()];
                    group.owners = vec!["entity".to_owned()];
                }
                None => {
                    by_name.insert((group.kind, group.name.clone()), groups.len());
                }
            }
            groups.push(group);
        }
        groups
    }
}

fn physical_name(line: &str) -> Option<((usize, i32), String)> {
    let (dimension, rest) = line.split_once(|c: char| c.is_ascii_whitespace())?;
    let (number, quoted) = rest.trim_start().split_once(|c: char| c.is_ascii_whitespace())?;
    // some programs fill names up with blanks
    let name = quoted.trim().strip_prefix('"')?.strip_suffix('"')?.trim();
    let dimension: usize = dimension.parse().ok()?;
    let number: i32 = number.parse().ok()?;
    (dimension < KINDS.len() && !name.is_empty()).then(|| ((dimension, number.saturating_abs()), name.to_owned()))
}
