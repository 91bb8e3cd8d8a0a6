//! Abaqus input files: nodes, bricks, wedges, pyramids, tets, sets and surfaces. What else they say is passed over with a warning.

mod keyword;
mod sets;

use std::collections::BTreeMap;

use arrayvec::ArrayVec;
use estar_mesh::{MOST_NODES, NodeLabel, Shape};

use crate::MeshFile;
use crate::assembly::{Assembly, NodeIndex};
use crate::error::{Located, Place, Problem, Unsupported, excerpt};
use keyword::{Keyword, Line, Lines};
use sets::{Members, SetDefinition, SetKind, Sets, SurfaceDefinition};

/// What an element is to a mesh of solids.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Use {
    Solid(Shape),
    /// A face of so many nodes, which only names faces.
    Face(usize),
    /// A line of so many nodes, which only names nodes.
    Line(usize),
    /// Of no use, and harmless.
    PassedOver,
}

impl Use {
    /// The use of an element type; an error's advice for solids that are not supported.
    fn of(element_type: &str) -> Result<Self, &'static str> {
        const SOLIDS: [(&str, Shape); 5] = [
            ("C3D8", Shape::Hex8),
            ("C3D6", Shape::Wedge6),
            ("C3D5", Shape::Pyramid5),
            ("C3D4", Shape::Tet4),
            ("C3D10", Shape::Tet10),
        ];
        const QUADS: [&str; 7] = ["CPS4", "CPE4", "CAX4", "S4", "M3D4", "SFM3D4", "R3D4"];
        const TRIANGLES: [&str; 8] = ["CPS3", "CPE3", "CAX3", "S3", "STRI3", "M3D3", "SFM3D3", "R3D3"];
        const TRIANGLES_OF_SIX: [&str; 6] = ["CPS6", "CPE6", "CAX6", "STRI65", "M3D6", "SFM3D6"];
        const LINES: [&str; 5] = ["T2D2", "T3D2", "B31", "B21", "R2D2"];
        const LINES_OF_THREE: [&str; 4] = ["T2D3", "T3D3", "B32", "B22"];
        let is_type = |base: &str| {
            let rest = element_type.strip_prefix(base);
            rest.is_some_and(|letters| letters.bytes().all(|byte| byte.is_ascii_uppercase()))
        };
        let is_any = |types: &[&str]| types.iter().any(|base| is_type(base));
        // diffusive elements are those of the same shape
        let solid = element_type.strip_prefix('D').unwrap_or(element_type);
        let is_solid = |base: &str| {
            solid.strip_prefix(base).is_some_and(|letters| letters.bytes().all(|byte| byte.is_ascii_uppercase()))
        };
        if let Some((_, shape)) = SOLIDS.into_iter().find(|(base, _)| is_solid(base)) {
            Ok(Self::Solid(shape))
        } else if solid.starts_with("C3D") || element_type.starts_with("SC") {
            Err("mesh the volume with C3D8, C3D6, C3D4 or C3D10 (or what has as many nodes, such as C3D8R or C3D10M)")
        } else if is_any(&QUADS) {
            Ok(Self::Face(4))
        } else if is_any(&TRIANGLES) {
            Ok(Self::Face(3))
        } else if is_any(&TRIANGLES_OF_SIX) {
            Ok(Self::Face(6))
        } else if is_any(&LINES) {
            Ok(Self::Line(2))
        } else if is_any(&LINES_OF_THREE) {
            Ok(Self::Line(3))
        } else {
            Ok(Self::PassedOver)
        }
    }

    fn node_count(self) -> usize {
        match self {
            Self::Solid(shape) => shape.node_count(),
            Self::Face(count) | Self::Line(count) => count,
            Self::PassedOver => 0,
        }
    }
}

/// An element by the numbers of the file.
#[derive(Debug)]
struct Element {
    label: u64,
    usage: Use,
    nodes: ArrayVec<u64, MOST_NODES>,
    line: u64,
    /// Its index among the solids, if it is one.
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
    solid_count: u32,
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
            return Err(keyword.syntax("*ELEMENT needs a TYPE, such as C3D8 or C3D10".into()));
        };
        let usage = Use::of(&element_type);
        let word_count = 1 + usage.map_or(0, Use::node_count);
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
            match usage {
                Err(advice) => {
                    // How many nodes it has is not known here: one that ends with a comma goes on.
                    let tally = self.unsupported.entry(element_type.clone()).or_insert((0, label, first_line, advice));
                    tally.0 += u64::from(!line.goes_on());
                    if !line.goes_on() {
                        words.clear();
                    }
                }
                Ok(Use::PassedOver) => {
                    if !line.goes_on() {
                        *self.passed_over.entry(format!("ELEMENT, TYPE={element_type}")).or_default() += 1;
                        self.sets.passed_over_elements.insert(label);
                        words.clear();
                    }
                }
                Ok(usage) if words.len() >= word_count => {
                    if words.len() > word_count {
                        let message =
                            format!("element {label}: {} nodes instead of {}", words.len() - 1, word_count - 1);
                        return Err(line.syntax(message));
                    }
                    let nodes = words[1..].iter().copied().collect();
                    self.elements.push(Element { label, usage, nodes, line: first_line, index: self.solid_count });
                    self.solid_count += u32::from(matches!(usage, Use::Solid(_)));
                    members.push(Members::One(label));
                    words.clear();
                }
                Ok(_) => {}
            }
        }
        if usage.is_ok() && !words.is_empty() {
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
            let of_element = nodes.nodes(element.label, &element.nodes);
            let of_element = of_element.map_err(|problem| problem.at(Place::Line(element.line)))?;
            if let Use::Solid(shape) = element.usage {
                assembly.add(element.label, shape, &of_element);
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
