//! Which group a name stands for, where groups of several kinds or owners have it.

use std::collections::HashMap;

use crate::{Face, FaceKey, Group, GroupKind, Mesh};

/// What of a group is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wanted {
    /// Elements: of volumes.
    Elements,
    /// Faces: of surfaces.
    Faces,
    /// Nodes, which every group has. A node set goes before its namesakes of other kinds.
    Nodes,
}

impl Wanted {
    /// Whether groups of this kind have it.
    pub fn is_had_by(self, kind: GroupKind) -> bool {
        match self {
            Self::Elements => kind == GroupKind::Volume,
            Self::Faces => kind == GroupKind::Surface,
            Self::Nodes => true,
        }
    }

    /// The kinds of group that have it, in words.
    pub fn kinds(self) -> &'static str {
        match self {
            Self::Elements => "volume",
            Self::Faces => "surface",
            Self::Nodes => "volume, surface, curve, point or node set",
        }
    }

    /// Whether it makes no difference which of two groups is taken.
    fn is_same(self, one: &Group, other: &Group) -> bool {
        match self {
            Self::Elements => one.elements == other.elements,
            Self::Nodes => one.nodes == other.nodes,
            Self::Faces => {
                let keys = |group: &Group| {
                    let mut keys: Vec<FaceKey> = group.faces.iter().map(Face::key).collect();
                    keys.sort_unstable();
                    keys
                };
                one.faces.len() == other.faces.len() && keys(one) == keys(other)
            }
        }
    }
}

/// Why a name stands for no group.
#[derive(Debug, Clone, PartialEq)]
pub enum GroupError<'a> {
    /// No group has the name.
    Unknown,
    /// Only this group, and others like it, have the name, and it has not what is wanted.
    OtherKind(&'a Group),
    /// Several groups would serve, and it makes a difference which.
    Ambiguous(Vec<&'a Group>),
}

impl Mesh {
    /// The group that a name stands for where something is wanted of it. The name is a group's own, or a full one: with an owner
    /// before it (`assembly.foot`), a kind (`surface.foot`), or both (`assembly.surface.foot`).
    ///
    /// # Errors
    /// That there is none, or more than one.
    pub fn find(&self, name: &str, wanted: Wanted) -> Result<&Group, GroupError<'_>> {
        let mut named: Vec<&Group> = self.groups().iter().filter(|group| group.name == name).collect();
        if named.is_empty() {
            named = self.groups().iter().filter(|group| is_full_name(name, group)).collect();
        }
        let Some(&some) = named.first() else { return Err(GroupError::Unknown) };
        let mut fitting: Vec<&Group> = named.into_iter().filter(|group| wanted.is_had_by(group.kind)).collect();
        if wanted == Wanted::Nodes && fitting.iter().any(|group| group.kind == GroupKind::Nodes) {
            fitting.retain(|group| group.kind == GroupKind::Nodes);
        }
        match fitting[..] {
            [] => Err(GroupError::OtherKind(some)),
            [first, ref others @ ..] if others.iter().all(|other| wanted.is_same(first, other)) => Ok(first),
            _ => Err(GroupError::Ambiguous(fitting)),
        }
    }

    /// The shortest name by which [`Mesh::find`] finds the group.
    pub fn name_to_find(&self, group: &Group, wanted: Wanted) -> String {
        let (name, kind) = (&group.name, group.kind.qualifier());
        let owner = group.owners.first();
        let full = match owner {
            Some(owner) => vec![name.clone(), format!("{owner}.{name}"), format!("{owner}.{kind}.{name}")],
            None => vec![name.clone(), format!("{kind}.{name}")],
        };
        let stands_for_it = |full: &&String| self.find(full, wanted).is_ok_and(|found| wanted.is_same(found, group));
        full.iter().find(stands_for_it).or(full.last()).unwrap_or(name).clone()
    }

    /// Those names of all groups that have what is wanted.
    pub fn names_to_find(&self, wanted: Wanted) -> Vec<String> {
        let fitting = || self.groups().iter().filter(|group| wanted.is_had_by(group.kind));
        let mut counts: HashMap<&str, usize> = HashMap::new();
        fitting().for_each(|group| *counts.entry(&group.name).or_default() += 1);
        let name = |group: &Group| match counts.get(group.name.as_str()) {
            Some(1) => group.name.clone(),
            _ => self.name_to_find(group, wanted),
        };
        fitting().map(name).collect()
    }

    /// The names of all groups, each with its owner before it where another group of its kind has the name.
    pub fn full_names(&self) -> Vec<String> {
        let mut counts: HashMap<(&str, GroupKind), usize> = HashMap::new();
        self.groups().iter().for_each(|group| *counts.entry((&group.name, group.kind)).or_default() += 1);
        let full_name = |group: &Group| match (counts.get(&(&group.name, group.kind)), group.owners.first()) {
            (Some(2..), Some(owner)) => format!("{owner}.{}", group.name),
            _ => group.name.clone(),
        };
        self.groups().iter().map(full_name).collect()
    }
}

/// Whether the name is the group's own with its owner or its kind before it.
fn is_full_name(name: &str, group: &Group) -> bool {
    let Some(before) = name.strip_suffix(group.name.as_str()).and_then(|before| before.strip_suffix('.')) else {
        return false;
    };
    let kind = group.kind.qualifier();
    let is_owner = |word: &str| group.owners.iter().any(|owner| owner == word);
    let without_kind = before.strip_suffix(kind).and_then(|before| before.strip_suffix('.'));
    before == kind || is_owner(before) || without_kind.is_some_and(is_owner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{BoxSpec, box_mesh};

    fn owned(group: Group, owners: &[&str]) -> Group {
        Group { owners: owners.iter().map(|&owner| owner.to_owned()).collect(), ..group }
    }

    /// Two hexes; `foot` is three groups, `half` a volume of the part and one of the assembly.
    fn mesh() -> Mesh {
        let bricks = box_mesh(&BoxSpec::new([2.0, 1.0, 1.0], [2, 1, 1]).unwrap());
        let faces = bricks.group("x_min").unwrap().faces.clone();
        let groups = vec![
            Group::volume("foot", vec![0]),
            Group::surface("foot", faces),
            Group::node_set("foot", vec![0, 3]),
            owned(Group::volume("half", vec![0]), &["part", "P-1"]),
            owned(Group::volume("half", vec![1]), &["assembly"]),
            Group::volume("twin", vec![0, 1]),
            Group::point("twin", (0..12).collect()),
        ];
        let (nodes, labels) = (bricks.coordinates().to_vec(), bricks.node_labels().to_vec());
        Mesh::new(nodes, labels, bricks.elements().clone(), bricks.element_labels().to_vec(), groups).unwrap()
    }

    #[test]
    fn a_place_gets_what_it_asks_for() {
        let mesh = mesh();
        let kind = |name, wanted| mesh.find(name, wanted).unwrap().kind;
        assert_eq!(kind("foot", Wanted::Nodes), GroupKind::Nodes);
        assert_eq!(kind("foot", Wanted::Elements), GroupKind::Volume);
        assert_eq!(kind("foot", Wanted::Faces), GroupKind::Surface);
        assert_eq!(kind("surface.foot", Wanted::Nodes), GroupKind::Surface);
        assert!(matches!(mesh.find("half", Wanted::Faces), Err(GroupError::OtherKind(_))));
        assert_eq!(mesh.find("nobody.foot", Wanted::Nodes), Err(GroupError::Unknown));
    }

    #[test]
    fn namesakes_of_other_owners_are_told_by_their_full_names() {
        let mesh = mesh();
        let Err(GroupError::Ambiguous(both)) = mesh.find("half", Wanted::Elements) else { panic!("not told apart") };
        let names: Vec<String> = both.iter().map(|group| mesh.name_to_find(group, Wanted::Elements)).collect();
        assert_eq!(names, ["part.half", "assembly.half"]);
        assert_eq!(mesh.find("part.half", Wanted::Elements).unwrap().elements, [0]);
        assert_eq!(mesh.find("P-1.half", Wanted::Elements).unwrap().elements, [0]);
        assert_eq!(mesh.find("assembly.half", Wanted::Nodes).unwrap().elements, [1]);
        assert_eq!(mesh.find("assembly.volume.half", Wanted::Nodes).unwrap().elements, [1]);
        assert_eq!(mesh.full_names(), ["foot", "foot", "foot", "part.half", "assembly.half", "twin", "twin"]);
        assert_eq!(mesh.names_to_find(Wanted::Elements), ["foot", "part.half", "assembly.half", "twin"]);
    }

    #[test]
    fn namesakes_with_the_same_members_are_no_question() {
        assert_eq!(mesh().find("twin", Wanted::Nodes).unwrap().nodes.len(), 12);
    }
}
