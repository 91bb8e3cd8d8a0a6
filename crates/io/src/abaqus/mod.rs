//! Abaqus input files: nodes, 8-node bricks, sets and surfaces. What else they say is passed over with a warning.

mod keyword;
mod sets;

use std::collections::BTreeMap;

use estar_mesh::{ElementLabel, NodeLabel};

use crate::MeshFile;
use crate::assembly::{Assembly, NodeIndex};
use crate::error::{Located, Place, Problem, Unsupported, excerpt};
use keyword::{Keyword, Line, Lines};
use sets::{Members, SetDefinition, SetKind, Sets, SurfaceDefinition};

/// What an element is to a hex mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shape {
    Hex,
    /// Quads and lines only name faces and nodes.
    Quad,
    Line,
    /// Of no use, and harmless.
    PassedOver,
}

impl Shape {
    /// The shape of an element type; an error's advice for solids that are not 8-node bricks.
    fn of(element_type: &str) -> Result<Self, &'static str> {
        const QUADS: [&str; 7] = ["CPS4", "CPE4", "CAX4", "S4", "M3D4", "SFM3D4", "R3D4"];
        const LINES: [&str; 5] = ["T2D2", "T3D2", "B31", "B21", "R2D2"];
        let is_type = |base: &str| {
            let rest = element_type.strip_prefix(base);
            rest.is_some_and(|letters| letters.bytes().all(|byte| byte.is_ascii_uppercase()))
        };
        if is_type("C3D8") || is_type("DC3D8") {
            Ok(Shape::Hex)
        } else if element_type.starts_with("C3D") || element_type.starts_with("DC3D") || element_type.starts_with("SC")
        {
            Err("mesh the volume with 8-node bricks (C3D8 or C3D8R)")
        } else if QUADS.into_iter().any(is_type) {
            Ok(Shape::Quad)
        } else if LINES.into_iter().any(is_type) {
            Ok(Shape::Line)
        } else {
            Ok(Shape::PassedOver)
        }
    }

    fn node_count(self) -> usize {
        match self {
            Shape::Hex => 8,
            Shape::Quad => 4,
            Shape::Line => 2,
            Shape::PassedOver => 0,
        }
    }
}

/// An element by the numbers of the file.
#[derive(Debug)]
struct Element {
    label: u64,
    shape: Shape,
    nodes: [u64; 8],
    line: u64,
    /// Its index among the hexes, if it is one.
    index: u32,
}

/// Where in the hierarchy of parts and instances a line is.
#[derive(Debug, Default)]
struct Level {
    part_count: usize,
    instance_count: usize,
    in_part: bool,
    in_assembly: bool,
    in_instance: bool,
}

#[derive(Debug, Default)]
struct Reader {
    level: Level,
    node_labels: Vec<NodeLabel>,
    coordinates: Vec<[f64; 3]>,
    elements: Vec<Element>,
    hex_count: u32,
    sets: Sets,
    /// By type: how many, the first, and where.
    unsupported: BTreeMap<String, (u64, u64, u64, &'static str)>,
    passed_over: BTreeMap<String, u64>,
}

/// Reads an Abaqus input file.
pub(crate) fn read(bytes: &[u8]) -> Result<MeshFile, Located> {
    let mut reader = Reader::default();
    let mut lines = Lines::new(bytes);
    while let Some(line) = lines.next() {
        if !line.is_keyword() {
            return Err(line.syntax(format!("expected a keyword, found: {}", excerpt(line.text.as_bytes()))));
        }
        let keyword = Keyword::parse(&line, &mut lines)?;
        reader.keyword(&keyword, &mut lines)?;
    }
    reader.finish()
}

impl Reader {
    fn keyword(&mut self, keyword: &Keyword, lines: &mut Lines) -> Result<(), Located> {
        if let Some(file) = keyword.value("INPUT") {
            let what = format!("*{}, INPUT={file}", keyword.name);
            return Err(keyword.not_supported(what, "paste the other file's lines into this one"));
        }
        match keyword.name.as_str() {
            "NODE" => self.nodes(keyword, lines),
            "ELEMENT" => self.elements(keyword, lines),
            "NSET" => self.set(keyword, lines, SetKind::Nodes),
            "ELSET" => self.set(keyword, lines, SetKind::Elements),
            "SURFACE" => self.surface(keyword, lines),
            "INCLUDE" => Err(keyword.not_supported("*INCLUDE".into(), "paste the other file's lines into this one")),
            "NGEN" | "NFILL" | "NCOPY" | "ELGEN" | "ELCOPY" | "NMAP" | "SYSTEM" => {
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
                while lines.next_data().is_some() {}
                Ok(())
            }
        }
    }

    /// One part and one instance of it where it stands are as good as none.
    fn hierarchy(&mut self, keyword: &Keyword, lines: &mut Lines) -> Result<(), Located> {
        const FLAT: &str = "write a flat input file of one part, placed where it was made";
        let level = &mut self.level;
        match keyword.name.as_str() {
            "PART" => (level.part_count, level.in_part) = (level.part_count + 1, true),
            "END PART" => level.in_part = false,
            "ASSEMBLY" => level.in_assembly = true,
            "END ASSEMBLY" => level.in_assembly = false,
            "INSTANCE" => (level.instance_count, level.in_instance) = (level.instance_count + 1, true),
            _ => level.in_instance = false,
        }
        if level.part_count > 1 {
            return Err(keyword.not_supported("more than one *PART".into(), FLAT));
        }
        if level.instance_count > 1 {
            return Err(keyword.not_supported("more than one *INSTANCE".into(), FLAT));
        }
        while let Some(line) = lines.next_data() {
            for field in line.fields() {
                if keyword.name == "INSTANCE" && line.real("a translation or rotation", field)? != 0.0 {
                    let what = "an *INSTANCE that is moved or turned".into();
                    return Err(line.fail(Problem::NotSupported { what, advice: FLAT }));
                }
            }
        }
        Ok(())
    }

    fn nodes(&mut self, keyword: &Keyword, lines: &mut Lines) -> Result<(), Located> {
        if self.level.in_assembly && !self.level.in_instance {
            let what = "a *NODE of the assembly (a reference point)".into();
            return Err(keyword.not_supported(what, "remove it: only nodes of the part are read"));
        }
        let first = self.node_labels.len();
        while let Some(line) = lines.next_data() {
            let mut fields = line.fields();
            let label = line.label("a node's number", fields.next().unwrap_or_default())?;
            let mut position = [0.0; 3];
            for (value, field) in position.iter_mut().zip(fields) {
                // An empty field is 0.
                *value = if field.is_empty() { 0.0 } else { line.real("a coordinate", field)? };
            }
            self.node_labels.push(NodeLabel(label));
            self.coordinates.push(position);
        }
        if let Some(name) = keyword.name_value("NSET")? {
            let members = self.node_labels[first..].iter().map(|label| Members::One(label.0)).collect();
            self.sets.define(SetKind::Nodes, name, SetDefinition { members, is_internal: false, line: keyword.line });
        }
        Ok(())
    }

    fn elements(&mut self, keyword: &Keyword, lines: &mut Lines) -> Result<(), Located> {
        let Some(element_type) = keyword.value("TYPE").map(str::to_ascii_uppercase) else {
            return Err(keyword.syntax("*ELEMENT needs TYPE=C3D8 or C3D8R".into()));
        };
        let shape = Shape::of(&element_type);
        let word_count = 1 + shape.map_or(0, Shape::node_count);
        let mut members = Vec::new();
        let mut words = Vec::new();
        let mut first_line = keyword.line;
        while let Some(line) = lines.next_data() {
            if words.is_empty() {
                first_line = line.number;
            }
            for field in line.fields().filter(|field| !field.is_empty()) {
                words.push(line.label("a number of an element", field)?);
            }
            let label = words.first().copied().unwrap_or_default();
            match shape {
                Err(advice) => {
                    // How many nodes it has is not known here: one that ends with a comma goes on.
                    let tally = self.unsupported.entry(element_type.clone()).or_insert((0, label, first_line, advice));
                    tally.0 += u64::from(!line.goes_on());
                    if !line.goes_on() {
                        words.clear();
                    }
                }
                Ok(Shape::PassedOver) => {
                    if !line.goes_on() {
                        *self.passed_over.entry(format!("ELEMENT, TYPE={element_type}")).or_default() += 1;
                        self.sets.passed_over_elements.insert(label);
                        words.clear();
                    }
                }
                Ok(shape) if words.len() >= word_count => {
                    if words.len() > word_count {
                        let message =
                            format!("element {label}: {} nodes instead of {}", words.len() - 1, word_count - 1);
                        return Err(line.syntax(message));
                    }
                    let mut nodes = [0; 8];
                    nodes.iter_mut().zip(&words[1..]).for_each(|(node, word)| *node = *word);
                    self.elements.push(Element { label, shape, nodes, line: first_line, index: self.hex_count });
                    self.hex_count += u32::from(shape == Shape::Hex);
                    members.push(Members::One(label));
                    words.clear();
                }
                Ok(_) => {}
            }
        }
        if shape.is_ok() && !words.is_empty() {
            let message = format!("element {}: {} nodes instead of {}", words[0], words.len() - 1, word_count - 1);
            return Err(Problem::Syntax { message }.at(Place::Line(first_line)));
        }
        if let Some(name) = keyword.name_value("ELSET")?
            && !members.is_empty()
        {
            let definition = SetDefinition { members, is_internal: false, line: keyword.line };
            self.sets.define(SetKind::Elements, name, definition);
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
            members.push(Members::NodesOf(elements));
        }
        while let Some(line) = lines.next_data() {
            if keyword.has("GENERATE") {
                let mut numbers = [0, 0, 1];
                for (number, field) in numbers.iter_mut().zip(line.fields()).filter(|(_, field)| !field.is_empty()) {
                    *number = line.label("a bound of a range", field)?;
                }
                let [first, last, step] = numbers;
                if step == 0 || last < first {
                    let message = format!("the range {first}, {last}, {step} has no members; give first, last, step");
                    return Err(line.syntax(message));
                }
                members.push(Members::Range { first, last, step });
            } else {
                for field in line.fields().filter(|field| !field.is_empty()) {
                    members.push(line.member(field)?);
                }
            }
        }
        let is_internal = keyword.has("INTERNAL");
        self.sets.define(kind, name, SetDefinition { members, is_internal, line: keyword.line });
        Ok(())
    }

    fn surface(&mut self, keyword: &Keyword, lines: &mut Lines) -> Result<(), Located> {
        let Some(name) = keyword.name_value("NAME")? else {
            return Err(keyword.syntax("*SURFACE needs NAME=name".into()));
        };
        let surface_type = keyword.value("TYPE").unwrap_or("ELEMENT").to_ascii_uppercase();
        let mut faces = Vec::new();
        let mut nodes = Vec::new();
        while let Some(line) = lines.next_data() {
            let mut fields = line.fields();
            let member = line.member(fields.next().unwrap_or_default())?;
            match surface_type.as_str() {
                "NODE" => nodes.push(member),
                "ELEMENT" => {
                    let face = fields.next().unwrap_or_default().to_ascii_uppercase();
                    let number = face.strip_prefix('S').and_then(|number| number.parse::<usize>().ok());
                    match number {
                        Some(number @ 1..=6) => faces.push((member, number - 1)),
                        _ => {
                            let message = format!(
                                "face \"{}\": give S1 to S6 after the element or set",
                                excerpt(face.as_bytes())
                            );
                            return Err(line.syntax(message));
                        }
                    }
                }
                other => {
                    let what = format!("*SURFACE, TYPE={}", excerpt(other.as_bytes()));
                    return Err(keyword.not_supported(what, "use TYPE=ELEMENT or TYPE=NODE"));
                }
            }
        }
        if surface_type == "NODE" {
            let definition = SetDefinition { members: nodes, is_internal: false, line: keyword.line };
            self.sets.define(SetKind::Nodes, name, definition);
        } else {
            self.sets.surfaces.push(SurfaceDefinition { name, faces, line: keyword.line });
        }
        Ok(())
    }

    fn finish(self) -> Result<MeshFile, Located> {
        if let Some(&(_, _, line, _)) = self.unsupported.values().next() {
            let list = self.unsupported.into_iter().map(|(kind, (count, first, _, advice))| Unsupported {
                kind: format!("elements of type {kind}"),
                count,
                first,
                advice,
            });
            return Err(Problem::UnsupportedElements(list.collect()).at(Place::Line(line)));
        }
        let mut assembly =
            Assembly { coordinates: self.coordinates, node_labels: self.node_labels, ..Assembly::default() };
        for (name, count) in &self.passed_over {
            let times = if *count == 1 { "once" } else { "times" };
            let count = if *count == 1 { String::new() } else { format!("{count} ") };
            assembly.warnings.push(format!("*{name} ({count}{times}) is passed over: only the mesh is read"));
        }
        let nodes = NodeIndex::new(&assembly.node_labels);
        for element in &self.elements {
            let corners = nodes.corners::<8>(element.label, &element.nodes[..element.shape.node_count()]);
            let corners = corners.map_err(|problem| problem.at(Place::Line(element.line)))?;
            if element.shape == Shape::Hex {
                assembly.hexes.push(corners);
                assembly.hex_labels.push(ElementLabel(element.label));
            }
        }
        let elements = sets::Elements::new(&self.elements);
        let groups = self.sets.groups(&nodes, &elements, &mut assembly.warnings)?;
        assembly.groups = groups;
        assembly.finish("Abaqus".into()).map_err(|problem| problem.at(Place::File))
    }
}

impl Line<'_> {
    /// A member of a set: a number or the name of another set, either possibly behind the name of an instance.
    fn member(&self, field: &str) -> Result<Members, Located> {
        let field = field.trim_matches('"');
        let own = field.rsplit_once('.').map_or(field, |(_, own)| own);
        match own.parse() {
            Ok(label) => Ok(Members::One(label)),
            Err(_) if own.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '+') || own.is_empty() => {
                Err(self.fail(Problem::NotANumber { what: "a member of a set", found: excerpt(field.as_bytes()) }))
            }
            Err(_) => Ok(Members::Set(keyword::checked_name(self, own)?)),
        }
    }
}
