//! Sets and surfaces: defined in any order of elements and nodes, resolved when everything is known.

use std::cell::Cell;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::ops::Range;

use estar_mesh::{Elements, Face, FaceKey, Group, GroupKind};
use rayon::prelude::*;

use super::element_type::Use;
use super::keyword::{Origin, checked_name, unquoted};
use super::scope::{Element, Index, Scope};
use crate::error::{Located, Problem, and_more};

/// What a set is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum SetKind {
    Nodes,
    Elements,
}

/// What a data line puts into a set.
#[derive(Debug, Clone)]
pub(super) enum Members {
    One(u64),
    Range {
        first: u64,
        last: u64,
        step: u64,
    },
    /// A set, or a number or set behind the name of an instance.
    Named(Box<str>),
    /// Those of the same scope from one place to another.
    Own(Range<u32>),
    NodesOf(Box<str>),
}

#[derive(Debug, Clone)]
pub(super) struct SetDefinition {
    pub kind: SetKind,
    pub name: String,
    /// Whose numbers the members are, where the keyword says it.
    pub instance: Option<String>,
    pub members: Vec<Members>,
    /// Made by Abaqus/CAE for its own surfaces: not a group.
    pub is_internal: bool,
    pub origin: Origin,
}

impl SetDefinition {
    /// The same set behind other nodes and elements.
    pub fn shifted(&self, nodes: u32, elements: u32) -> Self {
        let offset = if self.kind == SetKind::Nodes { nodes } else { elements };
        let mut shifted = self.clone();
        for member in &mut shifted.members {
            if let Members::Own(range) = member {
                *range = range.start + offset..range.end + offset;
            }
        }
        shifted
    }
}

/// Which faces of an element a surface takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FaceChoice {
    /// S1 is 0.
    Numbered(usize),
    /// SPOS or SNEG: a shell itself.
    Side,
    /// All that are on no other element.
    Free,
    /// An edge or an end, which is no face.
    NoFace,
}

#[derive(Debug, Clone)]
pub(super) enum SurfaceContent {
    Faces(Vec<(Members, FaceChoice)>),
    Union(Vec<String>),
}

#[derive(Debug, Clone)]
pub(super) struct SurfaceDefinition {
    pub name: String,
    pub content: SurfaceContent,
    pub origin: Origin,
}

/// A scope in the mesh: an instance of a part, or what stands outside of all parts.
#[derive(Debug)]
pub(super) struct Body<'a> {
    pub scope: &'a Scope,
    pub index: &'a Index,
    /// The name of the instance, if it is one that has a name.
    pub instance: Option<String>,
    /// Names of the level, as [`Group::owners`] has them.
    pub owners: Vec<String>,
    /// How many nodes, elements and solids of other bodies come before its own.
    pub node_offset: u32,
    pub element_offset: u32,
    pub solid_offset: u32,
}

/// All the members that the sets of a file may have together.
const MOST_MEMBERS: u64 = 100_000_000;

/// Members by their places in all bodies, ascending, of sets by kind and name in capitals.
type Resolved = HashMap<(SetKind, String), Vec<u32>>;

/// The groups of all bodies, and what was left out of them.
pub(super) struct GroupMaker<'a> {
    bodies: &'a [Body<'a>],
    solids: &'a Elements,
    /// How many of the first bodies are instances of parts.
    instance_count: usize,
    sets: Vec<Resolved>,
    room: Cell<u64>,
    /// How each name is written, by the name in capitals.
    spellings: HashMap<String, String>,
    groups: Vec<Group>,
    /// Sets and surfaces with nothing that a mesh of solids has.
    without_members: Vec<String>,
    /// Faces that are left out of a surface, by its name: they are edges, or on elements that are no solids.
    no_faces: BTreeMap<String, u64>,
}

impl<'a> GroupMaker<'a> {
    pub fn new(bodies: &'a [Body<'a>], instance_count: usize, solids: &'a Elements) -> Self {
        Self {
            bodies,
            solids,
            instance_count,
            sets: Vec::new(),
            room: Cell::new(MOST_MEMBERS),
            spellings: HashMap::new(),
            groups: Vec::new(),
            without_members: Vec::new(),
            no_faces: BTreeMap::new(),
        }
    }

    /// The groups: of each body element sets, surfaces, node sets.
    pub fn groups(mut self, warnings: &mut Vec<String>) -> Result<Vec<Group>, Located> {
        for body in 0..self.bodies.len() {
            let resolved = self.resolved(body)?;
            self.sets.push(resolved);
            let first_group = self.groups.len();
            self.element_sets(body);
            self.surfaces(body, first_group)?;
            self.node_sets(body);
        }
        if !self.without_members.is_empty() {
            let names = and_more(self.without_members.iter().map(|name| format!("\"{name}\"")));
            let sets = if self.without_members.len() == 1 { "set or surface has" } else { "sets or surfaces have" };
            let count = self.without_members.len();
            warnings.push(format!("{count} {sets} no nodes or faces of solids, and no group is made of them: {names}"));
        }
        if !self.no_faces.is_empty() {
            let names = and_more(self.no_faces.iter().map(|(name, count)| format!("\"{name}\" ({count})")));
            warnings.push(format!("members of surfaces that are no faces of solids or shells are left out: {names}"));
        }
        Ok(self.groups)
    }

    /// The members of every set of a body. A set may name only sets before it, so that this ends.
    fn resolved(&mut self, body: usize) -> Result<Resolved, Located> {
        let mut resolved = Resolved::new();
        let scope = self.bodies[body].scope;
        for set in &scope.sets {
            let name = &set.name;
            if let Some(instance) = &set.instance
                && self.body_named(body, instance).is_none()
            {
                return Err(missing(name, "instance", instance, set.origin));
            }
            let mut places = Vec::new();
            for member in &set.members {
                if let Members::NodesOf(elements) = member {
                    let of_set = self.set(body, &resolved, SetKind::Elements, elements, set.instance.as_deref());
                    let of_set = of_set.ok_or_else(|| missing(name, "set", elements, set.origin))?;
                    self.take_room(2 * of_set.len(), set.origin)?;
                    for &place in of_set {
                        let (body, element) = self.element(place);
                        let nodes = &body.index.element_nodes[element.nodes.clone()];
                        places
                            .extend(nodes.iter().filter(|node| **node != u32::MAX).map(|node| node + body.node_offset));
                    }
                } else {
                    self.places(body, &resolved, member, set, &mut places)?;
                }
            }
            resolved.entry((set.kind, name.to_ascii_uppercase())).or_default().extend(places);
        }
        for members in resolved.values_mut() {
            members.sort_unstable();
            members.dedup();
        }
        Ok(resolved)
    }

    fn take_room(&self, count: usize, origin: Origin) -> Result<(), Located> {
        match self.room.get().checked_sub(count as u64) {
            Some(left) => {
                self.room.set(left);
                Ok(())
            }
            None => {
                let what = format!("more than {} million members of sets in all", MOST_MEMBERS / 1_000_000);
                Err(origin.fail(Problem::NotSupported { what, advice: "remove sets that are not used" }))
            }
        }
    }

    /// Adds the places of what a member of a set stands for.
    fn places(
        &self,
        body: usize,
        resolved: &Resolved,
        member: &Members,
        set: &SetDefinition,
        places: &mut Vec<u32>,
    ) -> Result<(), Located> {
        let (name, kind, origin, instance) = (&set.name, set.kind, set.origin, set.instance.as_deref());
        let what = if kind == SetKind::Nodes { "node" } else { "element" };
        let one = |label: u64, instance: Option<&str>| {
            let place = self.place(body, kind, label, instance);
            place.ok_or_else(|| missing(name, what, &label.to_string(), origin))
        };
        match member {
            Members::One(label) => {
                self.take_room(1, origin)?;
                places.push(one(*label, instance)?);
            }
            Members::Range { first, last, step } => {
                // ends at its first missing number, however far it goes
                let mut label = *first;
                while label <= *last {
                    self.take_room(1, origin)?;
                    places.push(one(label, instance)?);
                    match label.checked_add(*step) {
                        Some(next) => label = next,
                        None => break,
                    }
                }
            }
            Members::Own(range) => {
                let body = &self.bodies[body];
                let offset = if kind == SetKind::Nodes { body.node_offset } else { body.element_offset };
                self.take_room(range.len(), origin)?;
                places.extend(range.clone().map(|place| place + offset));
            }
            Members::Named(full) => {
                if let Some(of_set) = self.set(body, resolved, kind, full, instance) {
                    self.take_room(of_set.len(), origin)?;
                    places.extend(of_set);
                    return Ok(());
                }
                let own = full.rsplit_once('.').map_or(("", &**full), |(owner, own)| (owner, own));
                match (own, own.1.parse()) {
                    ((owner, _), Ok(label)) => places.push(one(label, Some(owner))?),
                    _ => return Err(missing(name, "set", full, origin)),
                }
            }
            Members::NodesOf(_) => {}
        }
        Ok(())
    }

    /// The body that a name of an instance stands for. A file without instances writes the name of one that it had.
    fn body_named(&self, own: usize, instance: &str) -> Option<usize> {
        let is_meant = |body: &Body| body.instance.as_ref().is_some_and(|name| name.eq_ignore_ascii_case(instance));
        match self.bodies[..self.instance_count].iter().position(is_meant) {
            None if self.instance_count == 0 => Some(own),
            // of one part without an instance
            None if self.instance_count == 1 && self.bodies[0].instance.is_none() => Some(0),
            position => position,
        }
    }

    /// Where else a number or a name of a body may be: outside of parts that of the only instance.
    fn only_instance(&self, body: usize) -> Option<usize> {
        (body == self.instance_count && self.instance_count == 1).then_some(0)
    }

    fn place(&self, body: usize, kind: SetKind, label: u64, instance: Option<&str>) -> Option<u32> {
        let within = |body: usize| {
            let body = &self.bodies[body];
            match kind {
                SetKind::Nodes => body.index.nodes.get(label).map(|place| place + body.node_offset),
                SetKind::Elements => body.index.elements.get(label).map(|place| place + body.element_offset),
            }
        };
        match instance {
            Some(instance) => within(self.body_named(body, instance)?),
            None => within(body).or_else(|| within(self.only_instance(body)?)),
        }
    }

    fn set<'b>(
        &'b self,
        body: usize,
        own: &'b Resolved,
        kind: SetKind,
        name: &str,
        instance: Option<&str>,
    ) -> Option<&'b Vec<u32>> {
        let of_body = |which: usize, name: &str| {
            let sets = if which == body { own } else { self.sets.get(which)? };
            sets.get(&(kind, name.to_ascii_uppercase()))
        };
        if let Some(instance) = instance {
            return of_body(self.body_named(body, instance)?, name);
        }
        of_body(body, name).or_else(|| of_body(self.only_instance(body)?, name)).or_else(|| {
            let (owner, name) = name.rsplit_once('.')?;
            of_body(self.body_named(body, owner)?, name)
        })
    }

    /// The element at a place, and its body.
    fn element(&self, place: u32) -> (&'a Body<'a>, &'a Element) {
        let body = self.bodies.partition_point(|body| body.element_offset <= place) - 1;
        // bodies without elements begin where the next one begins: the last of them has it
        let body = &self.bodies[body];
        (body, &body.scope.elements[(place - body.element_offset) as usize])
    }

    fn nodes_of(&self, place: u32) -> estar_mesh::ElementNodes {
        let (body, element) = self.element(place);
        body.index.nodes_of(element, body.node_offset)
    }

    fn solid_rank(&self, place: u32) -> u32 {
        let (body, _) = self.element(place);
        body.index.solid_rank[(place - body.element_offset) as usize] + body.solid_offset
    }

    /// Each set of a kind that becomes a group, once, as its name is written first.
    fn named(&mut self, body: usize, kind: SetKind) -> Vec<String> {
        let mut seen = HashSet::new();
        let sets = &self.bodies[body].scope.sets;
        sets.iter()
            .filter(|set| set.kind == kind && !set.is_internal && seen.insert(set.name.to_ascii_uppercase()))
            .map(|set| self.spellings.entry(set.name.to_ascii_uppercase()).or_insert_with(|| set.name.clone()).clone())
            .collect()
    }

    fn members(&self, body: usize, kind: SetKind, name: &str) -> &[u32] {
        self.sets[body].get(&(kind, name.to_ascii_uppercase())).map_or(&[], |members| &members[..])
    }

    fn add(&mut self, body: usize, group: Group) {
        self.groups.push(Group { owners: self.bodies[body].owners.clone(), ..group });
    }

    /// An element set is a group of the greatest dimension that it has elements of.
    fn element_sets(&mut self, body: usize) {
        for name in self.named(body, SetKind::Elements) {
            let (mut solids, mut faces, mut lines) = (Vec::new(), Vec::new(), Vec::new());
            for &place in self.members(body, SetKind::Elements, &name) {
                match self.element(place).1.usage {
                    Use::Solid(_) => solids.push(self.solid_rank(place)),
                    Use::Face(_) => faces.extend(Face::new(&self.nodes_of(place))),
                    Use::Line(_) => lines.extend(self.nodes_of(place)),
                    _ => {}
                }
            }
            if !solids.is_empty() {
                self.add(body, Group::volume(name, solids));
            } else if !faces.is_empty() {
                self.add(body, Group::surface(name, faces));
            } else if !lines.is_empty() {
                self.add(body, Group::curve(name, lines));
            } else {
                self.without_members.push(name);
            }
        }
    }

    fn node_sets(&mut self, body: usize) {
        for name in self.named(body, SetKind::Nodes) {
            match self.members(body, SetKind::Nodes, &name).to_vec() {
                none if none.is_empty() => self.without_members.push(name),
                nodes => self.add(body, Group::node_set(name, nodes)),
            }
        }
    }

    /// The surfaces of a body, whose groups begin with the given one. A set of shells gives way to a surface of its name.
    fn surfaces(&mut self, body: usize, first_group: usize) -> Result<(), Located> {
        let mut found: HashMap<String, Vec<Face>> = HashMap::new();
        let mut order = Vec::new();
        for surface in &self.bodies[body].scope.surfaces {
            let faces = match &surface.content {
                SurfaceContent::Faces(members) => self.faces(body, surface, members)?,
                SurfaceContent::Union(names) => {
                    let mut all = Vec::new();
                    for name in names {
                        let faces = found.get(&name.to_ascii_uppercase());
                        let faces = faces.ok_or_else(|| missing(&surface.name, "surface", name, surface.origin))?;
                        self.take_room(faces.len(), surface.origin)?;
                        all.extend(faces);
                    }
                    all
                }
            };
            let key = surface.name.to_ascii_uppercase();
            if !found.contains_key(&key) {
                order.push((key.clone(), &surface.name));
            }
            found.entry(key).or_default().extend(faces);
        }
        let tail = self.groups.split_off(first_group);
        let gives_way = |group: &Group| {
            let faces = found.get(&group.name.to_ascii_uppercase());
            group.kind == GroupKind::Surface && faces.is_some_and(|faces| !faces.is_empty())
        };
        self.groups.extend(tail.into_iter().filter(|group| !gives_way(group)));
        for (key, name) in order {
            let name = self.spellings.entry(key.clone()).or_insert_with(|| name.clone()).clone();
            let faces = found.remove(&key).unwrap_or_default();
            if faces.is_empty() {
                self.without_members.push(name);
                continue;
            }
            self.add(body, Group::surface(name, faces));
        }
        Ok(())
    }

    fn faces(
        &mut self,
        body: usize,
        surface: &SurfaceDefinition,
        members: &[(Members, FaceChoice)],
    ) -> Result<Vec<Face>, Located> {
        let SurfaceDefinition { name, origin, .. } = surface;
        let as_set = SetDefinition {
            kind: SetKind::Elements,
            name: name.clone(),
            instance: None,
            members: Vec::new(),
            is_internal: false,
            origin: *origin,
        };
        let (mut faces, mut candidates, mut no_faces) = (Vec::new(), Vec::new(), 0);
        for (member, choice) in members {
            let mut places = Vec::new();
            self.places(body, &self.sets[body], member, &as_set, &mut places)?;
            for place in places {
                let (_, element) = self.element(place);
                match (element.usage, choice) {
                    (Use::Solid(shape), FaceChoice::Numbered(number)) => {
                        // Abaqus numbers the faces as they are listed here
                        let Some(corners) = shape.faces().get(*number) else {
                            let face = format!("S{} of the {shape} {}", number + 1, element.label);
                            return Err(missing(name, "face", &face, *origin));
                        };
                        let nodes = self.nodes_of(place);
                        let nodes: Vec<u32> = corners.iter().filter_map(|&corner| nodes.get(corner).copied()).collect();
                        // a side of a collapsed hex may be no more than an edge
                        let distinct = (0..nodes.len()).filter(|&k| !nodes[..k].contains(&nodes[k])).count();
                        if distinct < 3 {
                            no_faces += 1;
                        } else {
                            faces.extend(Face::new(&nodes));
                        }
                    }
                    (Use::Solid(_), FaceChoice::Free) => candidates.push(self.solid_rank(place)),
                    // CalculiX calls the sides of a shell S1 and S2
                    (Use::Face(_), FaceChoice::Side | FaceChoice::Free | FaceChoice::Numbered(0 | 1)) => {
                        faces.extend(Face::new(&self.nodes_of(place)));
                    }
                    _ => no_faces += 1,
                }
            }
        }
        if !candidates.is_empty() {
            faces.extend(self.free_faces(&candidates));
        }
        if no_faces > 0 {
            *self.no_faces.entry(name.clone()).or_default() += no_faces;
        }
        Ok(faces)
    }

    /// The faces of solids that no other solid has.
    fn free_faces(&self, of: &[u32]) -> Vec<Face> {
        const OF_ANOTHER: u32 = u32::MAX;
        let mut is_in = vec![false; self.solids.len()];
        let mut is_near = vec![false; self.solids.all_nodes().iter().max().map_or(0, |&node| node as usize + 1)];
        let mut faces = Vec::new();
        for &solid in of.iter().filter(|&&solid| !std::mem::replace(&mut is_in[solid as usize], true)) {
            faces.extend(self.solids.faces(solid as usize));
            self.solids.nodes(solid as usize).iter().for_each(|&node| is_near[node as usize] = true);
        }
        // equal faces side by side: the first number of each tells which it is
        let mut keys: Vec<(FaceKey, u32)> = faces.iter().map(Face::key).zip(0..).collect();
        for other in (0..self.solids.len()).filter(|&solid| !is_in[solid]) {
            let near = self.solids.faces(other).filter(|face| face.nodes().iter().all(|&node| is_near[node as usize]));
            keys.extend(near.map(|face| (face.key(), OF_ANOTHER)));
        }
        keys.par_sort_unstable();
        let alone = keys.chunk_by(|one, next| one.0 == next.0).filter(|equal| equal.len() == 1).map(|equal| equal[0].1);
        let mut free: Vec<u32> = alone.filter(|&face| face != OF_ANOTHER).collect();
        free.sort_unstable();
        free.into_iter().map(|face| faces[face as usize]).collect()
    }
}

/// A member of a set or surface as it is written: a number, or a name.
pub(super) fn member(origin: Origin, field: &str) -> Result<Members, Located> {
    if let Ok(label) = field.parse() {
        return Ok(Members::One(label));
    }
    let name = unquoted(field);
    let own = name.rsplit_once('.').map_or(name, |(_, own)| own);
    let is_number = |text: &str| text.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '+');
    if own.is_empty() || name == field && is_number(own) && own.parse::<u64>().is_err() {
        let found = crate::error::excerpt(field.as_bytes());
        return Err(origin.fail(Problem::NotANumber { what: "a member of a set", found }));
    }
    Ok(Members::Named(checked_name(origin, name)?.into()))
}

fn missing(group: &str, what: &'static str, label: &str, origin: Origin) -> Located {
    origin.fail(Problem::MissingMember { group: group.to_owned(), what, label: label.to_owned() })
}
