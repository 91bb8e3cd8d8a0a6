//! Sets and surfaces: defined in any order of elements and nodes, resolved when everything is known.

use std::cell::{Cell, RefCell};
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
    /// The faces of the surfaces of each body, by name in capitals.
    surface_faces: Vec<HashMap<String, Vec<Face>>>,
    /// Sets and surfaces with nothing that a mesh of solids has.
    without_members: Vec<String>,
    /// Faces that are left out of a surface, by its name: they are edges, or on elements that are no solids.
    no_faces: BTreeMap<String, u64>,
    /// Numbers of ranges that are not there, by the set's name.
    gaps: RefCell<BTreeMap<String, u64>>,
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
            surface_faces: Vec::new(),
            without_members: Vec::new(),
            no_faces: BTreeMap::new(),
            gaps: RefCell::default(),
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
        let gaps = self.gaps.into_inner();
        if !gaps.is_empty() {
            let names = and_more(gaps.iter().map(|(name, count)| format!("\"{name}\" ({count})")));
            warnings.push(format!("numbers of ranges (GENERATE) that are not there are left out: {names}"));
        }
        if !self.no_faces.is_empty() {
            let names = and_more(self.no_faces.iter().map(|(name, count)| format!("\"{name}\" ({count})")));
            warnings.push(format!("members of surfaces that are no faces of solids or shells are left out: {names}"));
        }
        Ok(self.groups)
    }

    /// The members of every set of a body. A set may name others wherever they are written, but none that names it.
    fn resolved(&mut self, body: usize) -> Result<Resolved, Located> {
        let scope = self.bodies[body].scope;
        // a set may be written in several pieces
        let mut pieces: Vec<Vec<&SetDefinition>> = Vec::new();
        let mut position = HashMap::new();
        for set in &scope.sets {
            let at = *position.entry((set.kind, set.name.to_ascii_uppercase())).or_insert(pieces.len());
            if at == pieces.len() {
                pieces.push(Vec::new());
            }
            pieces[at].push(set);
        }
        let needed = |set: &SetDefinition, member: &Members| {
            let (kind, name) = match member {
                Members::Named(name) => (set.kind, name),
                Members::NodesOf(name) => (SetKind::Elements, name),
                Members::One(_) | Members::Range { .. } | Members::Own(_) => return None,
            };
            let own = |name: &str| position.get(&(kind, name.to_ascii_uppercase())).copied();
            let is_own = |instance: &str| self.body_named(body, instance) == Some(body);
            match &set.instance {
                Some(instance) => own(name).filter(|_| is_own(instance)),
                None => own(name)
                    .or_else(|| name.rsplit_once('.').and_then(|(owner, name)| own(name).filter(|_| is_own(owner)))),
            }
        };
        let needs: Vec<Vec<usize>> = pieces
            .iter()
            .map(|pieces| pieces.iter().flat_map(|set| set.members.iter().filter_map(|m| needed(set, m))).collect())
            .collect();
        let order = in_order(&needs).map_err(|at| in_a_circle(&pieces[at][0].name, pieces[at][0].origin))?;
        let mut resolved = Resolved::new();
        for set in order.into_iter().flat_map(|at| &pieces[at]) {
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
                    let of_set =
                        of_set.ok_or_else(|| self.missing_set(body, name, SetKind::Elements, elements, set.origin))?;
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
            Members::Range { first, last, step } => self.range(body, set, [*first, *last, *step], places)?,
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
                    _ => return Err(self.missing_set(body, name, kind, full, origin)),
                }
            }
            Members::NodesOf(_) => {}
        }
        Ok(())
    }

    /// The members of a range of numbers. Those that are not there are counted, and one at least must be.
    fn range(
        &self,
        body: usize,
        set: &SetDefinition,
        [first, last, step]: [u64; 3],
        places: &mut Vec<u32>,
    ) -> Result<(), Located> {
        let instance = set.instance.as_deref();
        let of_body = |which: usize| {
            let scope = self.bodies[which].scope;
            if set.kind == SetKind::Nodes { scope.node_labels.len() } else { scope.elements.len() }
        };
        let wanted = ((last - first) / step).saturating_add(1);
        let named = set.instance.as_deref().and_then(|instance| self.body_named(body, instance));
        let there = of_body(named.unwrap_or(body)) + self.only_instance(body).map_or(0, of_body);
        let before = places.len();
        if wanted <= 4 * there as u64 {
            let numbers = (0..wanted).map(|count| first + count * step);
            places.extend(numbers.filter_map(|label| self.place(body, set.kind, label, instance)));
        } else {
            // a range may be far longer than the file: ask what is there
            let is_in = |label: &u64| (first..=last).contains(label) && (label - first).is_multiple_of(step);
            let mut labels: Vec<u64> =
                self.bodies.iter().flat_map(|body| labels_of(body.scope, set.kind)).filter(is_in).collect();
            labels.sort_unstable();
            labels.dedup();
            places.extend(labels.into_iter().filter_map(|label| self.place(body, set.kind, label, instance)));
        }
        let found = places.len() - before;
        self.take_room(found, set.origin)?;
        if found == 0 {
            let what = if set.kind == SetKind::Nodes { "node" } else { "element" };
            return Err(missing(&set.name, what, &first.to_string(), set.origin));
        }
        if (found as u64) < wanted {
            *self.gaps.borrow_mut().entry(set.name.clone()).or_default() += wanted - found as u64;
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

    /// The faces of a surface, of a body or of the instance before its name.
    fn surface(&self, body: usize, name: &str) -> Option<&Vec<Face>> {
        let of_body = |which: usize, name: &str| self.surface_faces.get(which)?.get(&name.to_ascii_uppercase());
        of_body(body, name).or_else(|| of_body(self.only_instance(body)?, name)).or_else(|| {
            let (owner, name) = name.rsplit_once('.')?;
            of_body(self.body_named(body, owner)?, name)
        })
    }

    /// That a set is not there, and what of its name is.
    fn missing_set(&self, body: usize, group: &str, kind: SetKind, name: &str, origin: Origin) -> Located {
        let (other, a_set) = match kind {
            SetKind::Nodes => (SetKind::Elements, "an element set"),
            SetKind::Elements => (SetKind::Nodes, "a node set"),
        };
        let what = if kind == SetKind::Nodes { "node set" } else { "element set" };
        let is_named = |set: &SetDefinition| set.kind == other && set.name.eq_ignore_ascii_case(name);
        let is_set = self.bodies[body].scope.sets.iter().any(is_named);
        let is_surface = self.surface_known(body, name);
        match (is_set, is_surface) {
            (true, _) => of_other_kind(group, what, name, a_set, origin),
            (_, true) => of_other_kind(group, what, name, "a surface", origin),
            _ => {
                let of_kind = |set: &&SetDefinition| set.kind == kind;
                self.missing_name(group, "set", name, origin, |scope| {
                    scope.sets.iter().filter(of_kind).map(|set| set.name.as_str()).collect()
                })
            }
        }
    }

    fn missing_surface(&self, body: usize, group: &str, name: &str, origin: Origin) -> Located {
        let is_named = |set: &&SetDefinition| set.name.eq_ignore_ascii_case(name);
        match self.bodies[body].scope.sets.iter().find(is_named).map(|set| set.kind) {
            Some(SetKind::Nodes) => of_other_kind(group, "surface", name, "a node set", origin),
            Some(SetKind::Elements) => of_other_kind(group, "surface", name, "an element set", origin),
            None => self.missing_name(group, "surface", name, origin, |scope| {
                scope.surfaces.iter().map(|surface| surface.name.as_str()).collect()
            }),
        }
    }

    fn surface_known(&self, body: usize, name: &str) -> bool {
        self.bodies[body].scope.surfaces.iter().any(|surface| surface.name.eq_ignore_ascii_case(name))
    }

    /// That a name is not there, and which instances have it.
    fn missing_name(
        &self,
        group: &str,
        what: &'static str,
        name: &str,
        origin: Origin,
        names: impl Fn(&'a Scope) -> Vec<&'a str>,
    ) -> Located {
        let own = name.rsplit_once('.').map_or(name, |(_, own)| own);
        let has = |body: &&Body<'a>| names(body.scope).iter().any(|other| other.eq_ignore_ascii_case(own));
        let full: Vec<String> = self.bodies[..self.instance_count]
            .iter()
            .filter(has)
            .filter_map(|body| Some(format!("{}.{own}", body.instance.as_ref()?)))
            .collect();
        let hint = if full.is_empty() { String::new() } else { format!("; it has {}", and_more(full)) };
        let (group, label) = (group.to_owned(), name.to_owned());
        origin.fail(Problem::MissingMember { group: group.into(), what, label: label.into(), hint: hint.into() })
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
        // a surface may be written in several pieces, and name others wherever they are written
        let mut order: Vec<(String, &String)> = Vec::new();
        let mut pieces: Vec<Vec<&SurfaceDefinition>> = Vec::new();
        let mut position = HashMap::new();
        for surface in &self.bodies[body].scope.surfaces {
            let key = surface.name.to_ascii_uppercase();
            let at = *position.entry(key.clone()).or_insert(pieces.len());
            if at == pieces.len() {
                pieces.push(Vec::new());
                order.push((key, &surface.name));
            }
            pieces[at].push(surface);
        }
        let needed = |surface: &SurfaceDefinition| -> Vec<usize> {
            let own = |name: &str| position.get(&name.to_ascii_uppercase()).copied();
            match &surface.content {
                SurfaceContent::Union(names) => names.iter().filter_map(|name| own(name)).collect(),
                SurfaceContent::Faces(members) => {
                    let names = members.iter().filter_map(|member| match member {
                        (Members::Named(name), FaceChoice::Free) => Some(name),
                        _ => None,
                    });
                    let is_set = |name: &str| self.set(body, &self.sets[body], SetKind::Elements, name, None).is_some();
                    names.filter(|name| !is_set(name)).filter_map(|name| own(name)).collect()
                }
            }
        };
        let needs: Vec<Vec<usize>> =
            pieces.iter().map(|pieces| pieces.iter().flat_map(|surface| needed(surface)).collect()).collect();
        let sequence = in_order(&needs).map_err(|at| in_a_circle(&pieces[at][0].name, pieces[at][0].origin))?;
        self.surface_faces.push(HashMap::new());
        for surface in sequence.into_iter().flat_map(|at| &pieces[at]) {
            let faces = match &surface.content {
                SurfaceContent::Faces(members) => self.faces(body, surface, members)?,
                SurfaceContent::Union(names) => {
                    let mut all = Vec::new();
                    for name in names {
                        let faces = self.surface(body, name);
                        let faces =
                            faces.ok_or_else(|| self.missing_surface(body, &surface.name, name, surface.origin))?;
                        self.take_room(faces.len(), surface.origin)?;
                        all.extend(faces);
                    }
                    all
                }
            };
            self.surface_faces[body].entry(surface.name.to_ascii_uppercase()).or_default().extend(faces);
        }
        let tail = self.groups.split_off(first_group);
        let gives_way = |group: &Group| {
            let faces = self.surface_faces[body].get(&group.name.to_ascii_uppercase());
            group.kind == GroupKind::Surface && faces.is_some_and(|faces| !faces.is_empty())
        };
        self.groups.extend(tail.into_iter().filter(|group| !gives_way(group)));
        for (key, name) in order {
            let name = self.spellings.entry(key.clone()).or_insert_with(|| name.clone()).clone();
            // those of the last body, which is outside of all parts, nobody names any more
            let known = &mut self.surface_faces[body];
            let faces = if body < self.instance_count { known.get(&key).cloned() } else { known.remove(&key) };
            let faces = faces.unwrap_or_default();
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
            if let (Members::Named(other), FaceChoice::Free) = (member, choice)
                && self.set(body, &self.sets[body], SetKind::Elements, other, None).is_none()
                && let Some(of_surface) = self.surface(body, other)
            {
                self.take_room(of_surface.len(), *origin)?;
                faces.extend(of_surface);
                continue;
            }
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
    let own = name.rsplit_once('.').map_or(&*name, |(_, own)| own);
    let is_number = |text: &str| text.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '+');
    if own.is_empty() || name == field && is_number(own) && own.parse::<u64>().is_err() {
        let found = crate::error::excerpt(field.as_bytes());
        return Err(origin.fail(Problem::NotANumber { what: "a member of a set", found }));
    }
    Ok(Members::Named(checked_name(origin, &name)?.into()))
}

fn labels_of(scope: &Scope, kind: SetKind) -> Vec<u64> {
    match kind {
        SetKind::Nodes => scope.node_labels.clone(),
        SetKind::Elements => scope.elements.iter().map(|element| element.label).collect(),
    }
}

fn missing(group: &str, what: &'static str, label: &str, origin: Origin) -> Located {
    let (group, label, hint) = (group.to_owned(), label.to_owned(), String::new());
    origin.fail(Problem::MissingMember { group: group.into(), what, label: label.into(), hint: hint.into() })
}

fn of_other_kind(group: &str, what: &str, name: &str, is: &str, origin: Origin) -> Located {
    let message = format!("\"{group}\" refers to the {what} {name}, but {name} is {is}");
    origin.fail(Problem::Syntax { message })
}

fn in_a_circle(name: &str, origin: Origin) -> Located {
    let message = format!("\"{name}\" is made of what is made of it, or of what names itself so");
    origin.fail(Problem::Syntax { message })
}

/// An order in which each comes behind all that it needs but itself; one of a circle where there is none.
fn in_order(needs: &[Vec<usize>]) -> Result<Vec<usize>, usize> {
    let mut missing = vec![0_usize; needs.len()];
    let mut needed_by = vec![Vec::new(); needs.len()];
    for (at, needs) in needs.iter().enumerate() {
        for &need in needs.iter().filter(|&&need| need != at) {
            missing[at] += 1;
            needed_by[need].push(at);
        }
    }
    let mut order: Vec<usize> = (0..needs.len()).filter(|&at| missing[at] == 0).collect();
    let mut done = 0;
    while let Some(&at) = order.get(done) {
        done += 1;
        for &other in &needed_by[at] {
            missing[other] -= 1;
            if missing[other] == 0 {
                order.push(other);
            }
        }
    }
    match missing.iter().position(|&missing| missing > 0) {
        None => Ok(order),
        Some(at) => Err(at),
    }
}
