//! Physical groups: numbers with a dimension, most of them with a name.

use std::collections::{BTreeMap, HashMap};

use estar_mesh::{Group, GroupKind};

use super::section_end;
use crate::cursor::Cursor;
use crate::error::{Located, Problem, excerpt, visible_name};

/// The kind of group of each dimension.
const KINDS: [GroupKind; 4] = [GroupKind::Point, GroupKind::Curve, GroupKind::Surface, GroupKind::Volume];

/// A physical group is known by its dimension and its number.
type Key = (usize, i32);

/// The physical groups of a file, filled element by element.
#[derive(Debug, Default)]
pub(super) struct PhysicalGroups {
    names: BTreeMap<Key, String>,
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
    pub fn position(&mut self, dimension: usize, number: i32) -> usize {
        let key = (dimension, number.saturating_abs());
        *self.position.entry(key).or_insert_with(|| {
            let kind = KINDS[dimension];
            let name = self.names.get(&key).cloned().unwrap_or_else(|| format!("{kind}_{}", key.1));
            let group = Group { name, kind, nodes: Vec::new(), elements: Vec::new(), faces: Vec::new() };
            self.groups.push((key, group));
            self.groups.len() - 1
        })
    }

    pub fn group_mut(&mut self, position: usize) -> &mut Group {
        &mut self.groups[position].1
    }

    /// All groups: volumes, surfaces, curves, points, each by number.
    pub fn finish(self) -> Result<Vec<Group>, Problem> {
        for (key, name) in &self.names {
            if !self.position.contains_key(key) {
                return Err(Problem::EmptyGroup { name: name.clone(), kind: KINDS[key.0] });
            }
        }
        let mut groups = self.groups;
        groups.sort_by_key(|((dimension, number), _)| (KINDS.len() - dimension, *number));
        Ok(groups.into_iter().map(|(_, group)| group).collect())
    }
}

fn physical_name(line: &str) -> Option<(Key, String)> {
    let (dimension, rest) = line.split_once(|c: char| c.is_ascii_whitespace())?;
    let (number, quoted) = rest.trim_start().split_once(|c: char| c.is_ascii_whitespace())?;
    let name = quoted.trim().strip_prefix('"')?.strip_suffix('"')?;
    let dimension: usize = dimension.parse().ok()?;
    let number: i32 = number.parse().ok()?;
    (dimension < KINDS.len() && !name.is_empty()).then(|| ((dimension, number.saturating_abs()), name.to_owned()))
}
