//! Abaqus input files: nodes, bricks, wedges, pyramids, tets, sets and surfaces, in parts and instances or without, in one file
//! or several. What else they say is passed over and counted.

mod build;
mod element_type;
mod keyword;
mod placement;
mod scope;
mod sets;
mod source;

use std::collections::BTreeMap;
use std::path::Path;

use crate::MeshFile;
use crate::error::{Located, Problem, ReadError, excerpt};
use crate::other_format::ls_dyna;
use element_type::Use;
use keyword::{Keyword, Line, Lines, Origin, checked_name, unquoted};
use placement::{Coordinates, Placement};
use scope::{Element, Scope};
use sets::{FaceChoice, Members, SetDefinition, SetKind, SurfaceContent, SurfaceDefinition, member};

/// Whose lines these are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Level {
    /// Of no part: all of a file without parts, or the assembly and what follows it.
    #[default]
    Outer,
    Part(usize),
    Instance(usize),
}

/// A part where it is placed.
#[derive(Debug)]
struct Instance {
    name: Option<String>,
    part: String,
    placement: Placement,
    /// What the instance has beside its part; all of it where it was meshed as an instance.
    own: Scope,
    origin: Origin,
}

/// Elements of a type that is no solid, or one that cannot be used.
#[derive(Debug)]
struct Tally {
    usage: Use,
    count: u64,
    first: u64,
    origin: Origin,
}

#[derive(Debug, Default)]
struct Reader {
    level: Level,
    outer: Scope,
    parts: Vec<(String, Scope)>,
    instances: Vec<Instance>,
    /// By type.
    others: BTreeMap<String, Tally>,
    passed_over: BTreeMap<String, u64>,
}

/// Reads an Abaqus input file, which lies at the path if it is a file, and has so many bytes at most with all that it includes.
pub(crate) fn read(bytes: &[u8], name: &str, path: Option<&Path>, limit: u64) -> Result<MeshFile, ReadError> {
    let sources = source::load(bytes, name, path, limit)?;
    let located = read_lines(Lines::new(&sources));
    located.map_err(|located| {
        let source = sources.get(located.source as usize).map_or(name, |source| &source.name);
        located.in_file(source)
    })
}

fn read_lines(mut lines: Lines) -> Result<MeshFile, Located> {
    let mut reader = Reader::default();
    while let Some(line) = lines.next() {
        if !line.is_keyword() {
            return Err(line.syntax(format!("expected a keyword, found: {}", excerpt(line.text.as_bytes()))));
        }
        let keyword = Keyword::parse(&line, &mut lines);
        if keyword.name.starts_with("ELEMENT_") {
            return Err(line.fail(ls_dyna()));
        }
        reader.keyword(&keyword, &mut lines)?;
    }
    reader.mesh_file()
}

impl Reader {
    fn keyword(&mut self, keyword: &Keyword, lines: &mut Lines) -> Result<(), Located> {
        match keyword.name.as_str() {
            "NODE" => self.nodes(keyword, lines),
            "ELEMENT" => self.elements(keyword, lines),
            "NSET" => self.set(keyword, lines, SetKind::Nodes),
            "ELSET" => self.set(keyword, lines, SetKind::Elements),
            "SURFACE" => self.surface(keyword, lines),
            "SYSTEM" => self.system(keyword, lines),
            "INCLUDE" => match keyword.value("INPUT") {
                // its lines have come in
                Some(_) => Ok(()),
                None => Err(keyword.syntax("*INCLUDE needs INPUT=file".into())),
            },
            "NGEN" | "NFILL" | "NCOPY" | "ELGEN" | "ELCOPY" | "NMAP" => {
                let what = format!("*{}", keyword.name);
                Err(keyword.not_supported(what, "write every node and element out, as Abaqus/CAE does"))
            }
            "PART" | "ASSEMBLY" | "INSTANCE" | "END PART" | "END ASSEMBLY" | "END INSTANCE" => {
                self.hierarchy(keyword, lines)
            }
            name => {
                if !matches!(name, "HEADING" | "PREPRINT") {
                    *self.passed_over.entry(name.to_owned()).or_default() += 1;
                }
                lines.skip_data();
                Ok(())
            }
        }
    }

    fn scope(&mut self) -> &mut Scope {
        match self.level {
            Level::Outer => &mut self.outer,
            Level::Part(part) => &mut self.parts[part].1,
            Level::Instance(instance) => &mut self.instances[instance].own,
        }
    }

    fn hierarchy(&mut self, keyword: &Keyword, lines: &mut Lines) -> Result<(), Located> {
        match keyword.name.as_str() {
            "PART" => {
                let name = keyword.name_value("NAME")?.unwrap_or_else(|| format!("part-{}", self.parts.len() + 1));
                if self.parts.iter().any(|(other, _)| other.eq_ignore_ascii_case(&name)) {
                    return Err(keyword.syntax(format!("a second *PART with the name {name}")));
                }
                self.level = Level::Part(self.parts.len());
                self.parts.push((name, Scope::default()));
            }
            "INSTANCE" => {
                if keyword.has("LIBRARY") || keyword.has("INSTANCE") {
                    let what = "an *INSTANCE of another job".into();
                    return Err(keyword.not_supported(what, "write its nodes and elements into this file"));
                }
                let name = keyword.name_value("NAME")?;
                let is_namesake = |other: &Instance| match (&other.name, &name) {
                    (Some(other), Some(name)) => other.eq_ignore_ascii_case(name),
                    _ => false,
                };
                if self.instances.iter().any(is_namesake) {
                    return Err(
                        keyword.syntax(format!("a second *INSTANCE with the name {}", name.unwrap_or_default()))
                    );
                }
                let Some(part) = keyword.name_value("PART")? else {
                    return Err(keyword.syntax("*INSTANCE needs PART=name".into()));
                };
                let placement = placement_of_instance(lines)?;
                self.level = Level::Instance(self.instances.len());
                let (own, origin) = (Scope::default(), keyword.origin);
                self.instances.push(Instance { name, part, placement, own, origin });
            }
            _ => self.level = Level::Outer,
        }
        lines.skip_data();
        Ok(())
    }

    fn system(&mut self, keyword: &Keyword, lines: &mut Lines) -> Result<(), Located> {
        const WHAT: &str = "a coordinate of *SYSTEM";
        let Some(line) = lines.next_data() else {
            self.scope().system = None;
            return Ok(());
        };
        let (points, count) = line.reals::<6>(WHAT)?;
        let third = lines.next_data().map(|line| line.reals::<3>(WHAT)).transpose()?;
        lines.skip_data();
        let [a, b, c, d, e, f] = points;
        let on_first = (count > 3).then_some([d, e, f]);
        let system = Placement::of_points([a, b, c], on_first, third.map(|(point, _)| point));
        let Some(system) = system else {
            return Err(keyword.syntax("the points of *SYSTEM are one, or lie on one line".into()));
        };
        self.scope().system = Some(system);
        Ok(())
    }

    fn nodes(&mut self, keyword: &Keyword, lines: &mut Lines) -> Result<(), Located> {
        let coordinates = match keyword.value("SYSTEM").map(str::to_ascii_uppercase).as_deref() {
            None | Some("R" | "RECTANGULAR") => Coordinates::Rectangular,
            Some("C" | "CYLINDRICAL") => Coordinates::Cylindrical,
            Some("S" | "SPHERICAL") => Coordinates::Spherical,
            Some(other) => {
                let message = format!("SYSTEM={}: give R, C or S", excerpt(other.as_bytes()));
                return Err(keyword.syntax(message));
            }
        };
        let name = keyword.name_value("NSET")?;
        let scope = self.scope();
        if scope.node_origin == Origin::default() {
            scope.node_origin = keyword.origin;
        }
        let is_plain = coordinates == Coordinates::Rectangular && scope.system.is_none();
        let first = scope.node_labels.len();
        while let Some(line) = lines.next_data() {
            let mut fields = line.fields();
            let label = line.label("a node's number", fields.next().unwrap_or_default())?;
            let mut position = [0.0; 3];
            for (value, field) in position.iter_mut().zip(fields) {
                // An empty field is 0.
                *value = if field.is_empty() { 0.0 } else { line.real("a coordinate", field)? };
            }
            if !is_plain {
                position = coordinates.rectangular(position);
                position = scope.system.unwrap_or_default().apply(position);
            }
            scope.node_labels.push(label);
            scope.coordinates.push(position);
        }
        if let Some(name) = name {
            // a mesh has fewer than 2³² nodes
            let own = Members::Own(first as u32..scope.node_labels.len() as u32);
            scope.sets.push(definition(SetKind::Nodes, name, vec![own], keyword.origin));
        }
        Ok(())
    }

    fn elements(&mut self, keyword: &Keyword, lines: &mut Lines) -> Result<(), Located> {
        let Some(element_type) = keyword.value("TYPE").map(str::to_ascii_uppercase) else {
            return Err(keyword.syntax("*ELEMENT needs a TYPE, such as C3D8 or C3D10".into()));
        };
        let element_type = excerpt(element_type.as_bytes());
        let usage = match Use::of(&element_type) {
            // the assembly's own elements join its parts: their nodes have names of instances before them
            usage if self.level == Level::Outer && !self.parts.is_empty() && !is_solid(usage) => Use::LeftOut,
            usage => usage,
        };
        let node_count = usage.node_count(&element_type);
        let name = keyword.name_value("ELSET")?;
        let mut tally = Tally { usage, count: 0, first: 0, origin: keyword.origin };
        let scope = self.scope();
        let first = scope.elements.len();
        let mut words: Vec<u64> = Vec::new();
        let mut label = None;
        let mut origin = keyword.origin;
        while let Some(line) = lines.next_data() {
            let mut fields = line.fields().filter(|field| !field.is_empty());
            if label.is_none() {
                let Some(field) = fields.next() else { continue };
                label = Some(line.label("an element's number", field)?);
                origin = line.origin;
            }
            for field in fields {
                match field.parse() {
                    Ok(node) => words.push(node),
                    // behind the name of an instance
                    Err(_) if usage == Use::LeftOut => words.push(u64::MAX),
                    Err(_) => words.push(line.label("a number of an element", field)?),
                }
            }
            let is_whole = match node_count {
                Some(count) => words.len() >= count,
                None => !line.goes_on(),
            };
            // of what is left out it is enough to know that it is there
            let (Some(number), true) = (label, is_whole || usage == Use::LeftOut && !line.goes_on()) else { continue };
            if let (Some(count), true) = (node_count, matches!(usage, Use::Solid(_) | Use::Face(_) | Use::Line(_)))
                && words.len() > count
            {
                return Err(line.syntax(format!("element {number}: {} nodes instead of {count}", words.len())));
            }
            let start = scope.element_nodes.len();
            if usage != Use::LeftOut {
                scope.element_nodes.extend(&words);
            }
            let nodes = start..scope.element_nodes.len();
            scope.elements.push(Element { label: number, usage, nodes, origin });
            if tally.count == 0 {
                (tally.first, tally.origin) = (number, origin);
            }
            tally.count += 1;
            words.clear();
            label = None;
        }
        match (label, node_count) {
            (Some(label), Some(count)) if matches!(usage, Use::Solid(_) | Use::Face(_) | Use::Line(_)) => {
                let message = format!("element {label}: {} nodes instead of {count}", words.len());
                return Err(origin.fail(Problem::Syntax { message }));
            }
            // one more of what is of no use, however many nodes it has
            (Some(label), _) => {
                if tally.count == 0 {
                    (tally.first, tally.origin) = (label, origin);
                }
                tally.count += 1;
                let end = scope.element_nodes.len();
                scope.elements.push(Element { label, usage, nodes: end..end, origin });
            }
            (None, _) => {}
        }
        if let Some(name) = name {
            let own = Members::Own(first as u32..scope.elements.len() as u32);
            scope.sets.push(definition(SetKind::Elements, name, vec![own], keyword.origin));
        }
        if !is_solid(usage) && tally.count > 0 {
            let count = tally.count;
            self.others.entry(element_type).and_modify(|tally| tally.count += count).or_insert(tally);
        }
        Ok(())
    }

    fn set(&mut self, keyword: &Keyword, lines: &mut Lines, kind: SetKind) -> Result<(), Located> {
        let key = if kind == SetKind::Nodes { "NSET" } else { "ELSET" };
        let Some(name) = keyword.name_value(key)? else {
            return Err(keyword.syntax(format!("*{key} needs {key}=name")));
        };
        let mut members = Vec::new();
        if kind == SetKind::Nodes
            && let Some(elements) = keyword.name_value("ELSET")?
        {
            members.push(Members::NodesOf(elements.into()));
        }
        while let Some(line) = lines.next_data() {
            if keyword.has("GENERATE") {
                let mut numbers = [0, 0, 1];
                let mut count = 0;
                for (number, field) in numbers.iter_mut().zip(line.fields()).filter(|(_, field)| !field.is_empty()) {
                    *number = line.label("a bound of a range", field)?;
                    count += 1;
                }
                let [first, last, step] = if count == 1 { [numbers[0], numbers[0], 1] } else { numbers };
                if step == 0 || last < first {
                    let message = format!("the range {first}, {last}, {step} has no members; give first, last, step");
                    return Err(line.syntax(message));
                }
                members.push(Members::Range { first, last, step });
            } else {
                for field in line.fields().filter(|field| !field.is_empty()) {
                    members.push(member(line.origin, field)?);
                }
            }
        }
        let instance = keyword.name_value("INSTANCE")?;
        let is_internal = keyword.has("INTERNAL");
        let set = SetDefinition { instance, is_internal, ..definition(kind, name, members, keyword.origin) };
        self.scope().sets.push(set);
        Ok(())
    }

    fn surface(&mut self, keyword: &Keyword, lines: &mut Lines) -> Result<(), Located> {
        let Some(name) = keyword.name_value("NAME")? else {
            return Err(keyword.syntax("*SURFACE needs NAME=name".into()));
        };
        let origin = keyword.origin;
        let surface_type = keyword.value("TYPE").unwrap_or("ELEMENT").to_ascii_uppercase();
        let combine = keyword.value("COMBINE").map(str::to_ascii_uppercase);
        let content = match (surface_type.as_str(), combine.as_deref()) {
            ("NODE", None) => {
                let mut members = Vec::new();
                while let Some(line) = lines.next_data() {
                    members.extend(line.fields().next().map(|field| member(line.origin, field)).transpose()?);
                }
                self.scope().sets.push(definition(SetKind::Nodes, name, members, origin));
                return Ok(());
            }
            ("ELEMENT", None) => {
                let mut faces = Vec::new();
                while let Some(line) = lines.next_data() {
                    let mut fields = line.fields();
                    let members = member(line.origin, fields.next().unwrap_or_default())?;
                    faces.push((members, face_choice(&line, fields.next().unwrap_or_default())?));
                }
                SurfaceContent::Faces(faces)
            }
            ("ELEMENT", Some("UNION")) => {
                let mut names = Vec::new();
                while let Some(line) = lines.next_data() {
                    for field in line.fields().filter(|field| !field.is_empty()) {
                        names.push(checked_name(line.origin, &unquoted(field))?);
                    }
                }
                SurfaceContent::Union(names)
            }
            // rigid, of cuts, of other surfaces: no faces of the mesh
            _ => {
                let what = if combine.is_some() { "COMBINE" } else { "TYPE" };
                let value = combine.unwrap_or(surface_type);
                let kind = format!("SURFACE, {what}={}", excerpt(value.as_bytes()));
                *self.passed_over.entry(kind).or_default() += 1;
                lines.skip_data();
                return Ok(());
            }
        };
        self.scope().surfaces.push(SurfaceDefinition { name, content, origin });
        Ok(())
    }
}

fn is_solid(usage: Use) -> bool {
    matches!(usage, Use::Solid(_))
}

fn definition(kind: SetKind, name: String, members: Vec<Members>, origin: Origin) -> SetDefinition {
    SetDefinition { kind, name, instance: None, members, is_internal: false, origin }
}

/// The face that a line of a surface names behind the element or set.
fn face_choice(line: &Line, field: &str) -> Result<FaceChoice, Located> {
    let face = field.to_ascii_uppercase();
    let number_behind = |letter: char| face.strip_prefix(letter).and_then(|number| number.parse::<usize>().ok());
    match (face.as_str(), number_behind('S')) {
        ("", _) => Ok(FaceChoice::Free),
        ("SPOS" | "SNEG", _) => Ok(FaceChoice::Side),
        (_, Some(number @ 1..=6)) => Ok(FaceChoice::Numbered(number - 1)),
        ("END1" | "END2" | "EDGE" | "CIRC", _) => Ok(FaceChoice::NoFace),
        _ if number_behind('E').is_some() => Ok(FaceChoice::NoFace),
        _ => {
            let shown = excerpt(face.as_bytes());
            Err(line.syntax(format!(
                "face \"{shown}\": give S1 to S6 after the element or set, or SPOS or SNEG of a shell"
            )))
        }
    }
}

/// The data lines of an instance: a translation, then a turn about the axis through two points by an angle.
fn placement_of_instance(lines: &mut Lines) -> Result<Placement, Located> {
    const WHAT: &str = "a translation or rotation";
    let Some(first) = lines.next_data() else { return Ok(Placement::default()) };
    let (translation, _) = first.reals::<3>(WHAT)?;
    let mut turn = None;
    if let Some(second) = lines.next_data() {
        let ([a, b, c, d, e, f, angle], _) = second.reals::<7>(WHAT)?;
        turn = Some(([a, b, c], [d, e, f], angle));
    }
    let placement = Placement::moved(translation, turn);
    placement.ok_or_else(|| first.syntax("the two points of the rotation's axis are one".into()))
}
