//! The lines of an Abaqus file: comments, keywords with parameters, data.

use std::borrow::Cow;

use super::source::Source;
use crate::error::{Located, Place, Problem, excerpt, visible_name};

/// A line of one of the files.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Origin {
    /// Which file, the first being 0.
    pub source: u32,
    /// Counted from 1.
    pub line: u64,
}

impl Origin {
    pub fn fail(self, problem: Problem) -> Located {
        Located { source: self.source, ..problem.at(Place::Line(self.line)) }
    }
}

/// A line that says something.
#[derive(Debug, Clone)]
pub(super) struct Line<'a> {
    /// Without surrounding white space; bytes that are not text replaced.
    pub text: Cow<'a, str>,
    pub origin: Origin,
    /// Where it starts in its file.
    pub start: usize,
}

impl Line<'_> {
    pub fn is_keyword(&self) -> bool {
        self.text.starts_with('*')
    }

    /// True when the last field is followed by another line's.
    pub fn goes_on(&self) -> bool {
        self.text.ends_with(',')
    }

    pub fn fail(&self, problem: Problem) -> Located {
        self.origin.fail(problem)
    }

    pub fn syntax(&self, message: String) -> Located {
        self.fail(Problem::Syntax { message })
    }

    /// What is between the commas.
    pub fn fields(&self) -> Fields<'_> {
        fields(&self.text)
    }

    /// A node's or an element's number.
    pub fn label(&self, what: &'static str, field: &str) -> Result<u64, Located> {
        field.parse().map_err(|_| self.fail(Problem::NotANumber { what, found: excerpt(field.as_bytes()) }))
    }

    /// A real number, with `D` for the exponent allowed as Fortran writes it.
    pub fn real(&self, what: &'static str, field: &str) -> Result<f64, Located> {
        let number = field.parse().or_else(|_| field.replace(['d', 'D'], "e").parse());
        number.map_err(|_| self.fail(Problem::NotANumber { what, found: excerpt(field.as_bytes()) }))
    }

    /// Real numbers, of which an empty field is 0, and how many there were.
    pub fn reals<const COUNT: usize>(&self, what: &'static str) -> Result<([f64; COUNT], usize), Located> {
        let mut numbers = [0.0; COUNT];
        let mut count = 0;
        for (number, field) in numbers.iter_mut().zip(self.fields()) {
            count += 1;
            if !field.is_empty() {
                *number = self.real(what, field)?;
            }
        }
        Ok((numbers, count))
    }
}

/// The fields of a line: a comma in quotes is part of a field.
#[derive(Debug)]
pub(super) struct Fields<'a> {
    rest: Option<&'a str>,
    has_quotes: bool,
}

pub(super) fn fields(text: &str) -> Fields<'_> {
    Fields { rest: Some(text), has_quotes: text.contains('"') }
}

impl<'a> Iterator for Fields<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        let rest = self.rest?;
        let mut is_inside = false;
        let ends = |byte: &u8| {
            is_inside ^= *byte == b'"' && self.has_quotes;
            *byte == b',' && !is_inside
        };
        let end = rest.as_bytes().iter().position(ends);
        self.rest = end.map(|end| &rest[end + 1..]);
        Some(rest[..end.unwrap_or(rest.len())].trim())
    }
}

/// A line before it is text.
#[derive(Debug, Clone, Copy)]
struct RawLine<'a> {
    bytes: &'a [u8],
    origin: Origin,
    start: usize,
}

/// Where a file is read.
#[derive(Debug)]
struct Frame {
    source: usize,
    at: usize,
    number: u64,
    insertion: usize,
}

/// The lines that are neither empty nor comments, of a file and of those that it includes.
#[derive(Debug)]
pub(super) struct Lines<'a> {
    sources: &'a [Source<'a>],
    stack: Vec<Frame>,
    ahead: Option<RawLine<'a>>,
    /// Where the last file ended, and the number of its last line.
    end: (usize, u64),
}

impl<'a> Lines<'a> {
    /// Those of the first file, with what it includes.
    pub fn new(sources: &'a [Source<'a>]) -> Self {
        Self::of_one(sources, 0)
    }

    /// Those of one of the files.
    pub fn of_one(sources: &'a [Source<'a>], source: usize) -> Self {
        Self { sources, stack: vec![Frame { source, at: 0, number: 0, insertion: 0 }], ahead: None, end: (0, 0) }
    }

    fn raw(&mut self) -> Option<RawLine<'a>> {
        if let Some(line) = self.ahead.take() {
            return Some(line);
        }
        loop {
            let frame = self.stack.last_mut()?;
            let source = &self.sources[frame.source];
            if let Some(insertion) = source.insertions.get(frame.insertion).filter(|next| next.at <= frame.at) {
                (frame.at, frame.number) = insertion.resume;
                frame.insertion += 1;
                self.stack.push(Frame { source: insertion.source, at: 0, number: 0, insertion: 0 });
                continue;
            }
            let rest = &source.bytes[frame.at..];
            if rest.is_empty() {
                self.end = (frame.at, frame.number);
                self.stack.pop();
                continue;
            }
            let end = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
            let bytes = rest[..end].trim_ascii();
            let start = frame.at;
            frame.at = source.bytes.len().min(start + end + 1);
            frame.number += 1;
            if !bytes.is_empty() && !bytes.starts_with(b"**") {
                // the number of files is limited
                let origin = Origin { source: frame.source as u32, line: frame.number };
                return Some(RawLine { bytes, origin, start });
            }
        }
    }

    fn peek(&mut self) -> Option<RawLine<'a>> {
        self.ahead = self.raw();
        self.ahead
    }

    /// Where the next line of this file is looked for, and the number of the line before.
    pub fn position(&self) -> (usize, u64) {
        match (&self.ahead, self.stack.last()) {
            (Some(line), _) => (line.start, line.origin.line - 1),
            (None, Some(frame)) => (frame.at, frame.number),
            (None, None) => self.end,
        }
    }

    /// The next line, unless it is a keyword.
    pub fn next_data(&mut self) -> Option<Line<'a>> {
        if self.peek()?.bytes.starts_with(b"*") { None } else { self.next() }
    }

    /// The next keyword; the data before it is passed over.
    pub fn next_keyword(&mut self) -> Option<Line<'a>> {
        self.skip_data();
        self.next()
    }

    pub fn skip_data(&mut self) {
        while self.peek().is_some_and(|line| !line.bytes.starts_with(b"*")) {
            self.ahead = None;
        }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        let RawLine { bytes, origin, start } = self.raw()?;
        Some(Line { text: String::from_utf8_lossy(bytes), origin, start })
    }
}

/// `*NAME, KEY=value, FLAG`.
#[derive(Debug)]
pub(super) struct Keyword {
    /// In capitals, single spaces.
    pub name: String,
    parameters: Vec<(String, String)>,
    pub origin: Origin,
}

impl Keyword {
    /// A keyword line, with those that it goes on to: a line that ends in a comma goes on where the next one has parameters.
    /// Many programs write a comma at the end that means nothing; what follows is data then.
    pub fn parse(first: &Line, lines: &mut Lines) -> Self {
        let mut text = first.text.clone().into_owned();
        while text.ends_with(',') && lines.peek().is_some_and(|line| is_parameters(line.bytes)) {
            if let Some(line) = lines.next() {
                text += &line.text;
            }
        }
        let mut fields = fields(&text[1..]);
        let name = fields.next().unwrap_or_default().split_ascii_whitespace().collect::<Vec<_>>().join(" ");
        let parameters = fields
            .filter(|field| !field.is_empty())
            .map(|field| {
                let (key, value) = field.split_once('=').unwrap_or((field, ""));
                (key.trim().to_ascii_uppercase(), unquoted(value).into_owned())
            })
            .collect();
        Self { name: name.to_ascii_uppercase(), parameters, origin: first.origin }
    }

    pub fn has(&self, key: &str) -> bool {
        self.parameters.iter().any(|(name, _)| name == key)
    }

    pub fn value(&self, key: &str) -> Option<&str> {
        self.parameters.iter().find(|(name, _)| name == key).map(|(_, value)| value.as_str())
    }

    /// The value of a parameter that names something.
    pub fn name_value(&self, key: &str) -> Result<Option<String>, Located> {
        self.value(key).map(|name| checked_name(self.origin, name)).transpose()
    }

    pub fn syntax(&self, message: String) -> Located {
        self.origin.fail(Problem::Syntax { message })
    }

    pub fn not_supported(&self, what: String, advice: &'static str) -> Located {
        self.origin.fail(Problem::NotSupported { what, advice })
    }
}

/// A name without quotes and without blanks around it. Of a full name, `"my part".set`, each may be in quotes.
pub(super) fn unquoted(name: &str) -> Cow<'_, str> {
    let name = name.trim();
    let inner = name.strip_prefix('"').and_then(|name| name.strip_suffix('"')).unwrap_or(name);
    if !inner.contains('"') {
        return inner.trim().into();
    }
    inner.replace('"', "").trim().to_owned().into()
}

/// Whether a line has parameters of a keyword, as against data, which has no equals sign and no such word.
fn is_parameters(line: &[u8]) -> bool {
    const FLAGS: [&[u8]; 4] = [b"GENERATE", b"INTERNAL", b"UNSORTED", b"ELEMENT BY ELEMENT"];
    let first = line.split(|byte| *byte == b',').next().unwrap_or_default().trim_ascii();
    let first_word = first.split(|byte| *byte == b'"').next().unwrap_or_default();
    !line.starts_with(b"*") && (first_word.contains(&b'=') || FLAGS.iter().any(|flag| first.eq_ignore_ascii_case(flag)))
}

/// A name that is there and is text.
pub(super) fn checked_name(origin: Origin, name: &str) -> Result<String, Located> {
    if name.is_empty() {
        Err(origin.fail(Problem::Syntax { message: "a name is missing".into() }))
    } else if name.contains('\u{fffd}') {
        Err(origin.fail(Problem::NameNotUtf8))
    } else {
        visible_name(name).map_err(|problem| origin.fail(problem))
    }
}
