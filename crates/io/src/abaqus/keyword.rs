//! The lines of an Abaqus file: comments, keywords with parameters, data.

use std::borrow::Cow;

use crate::error::{Located, Place, Problem, excerpt, visible_name};

/// A line that says something.
#[derive(Debug, Clone)]
pub(super) struct Line<'a> {
    /// Without surrounding white space; bytes that are not text replaced.
    pub text: Cow<'a, str>,
    /// Counted from 1.
    pub number: u64,
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
        problem.at(Place::Line(self.number))
    }

    pub fn syntax(&self, message: String) -> Located {
        self.fail(Problem::Syntax { message })
    }

    /// What is between the commas.
    pub fn fields(&self) -> impl Iterator<Item = &str> {
        self.text.split(',').map(str::trim)
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
}

/// The lines of a file that are neither empty nor comments.
#[derive(Debug, Clone)]
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    number: u64,
}

impl<'a> Lines<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, number: 0 }
    }

    /// The next line, unless it is a keyword.
    pub fn next_data(&mut self) -> Option<Line<'a>> {
        let before = self.clone();
        match self.next() {
            Some(line) if !line.is_keyword() => Some(line),
            _ => {
                *self = before;
                None
            }
        }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        while !self.rest.is_empty() {
            let end = self.rest.iter().position(|byte| *byte == b'\n').unwrap_or(self.rest.len());
            let line = self.rest[..end].trim_ascii();
            self.rest = &self.rest[self.rest.len().min(end + 1)..];
            self.number += 1;
            if !line.is_empty() && !line.starts_with(b"**") {
                return Some(Line { text: String::from_utf8_lossy(line), number: self.number });
            }
        }
        None
    }
}

/// `*NAME, KEY=value, FLAG`.
#[derive(Debug)]
pub(super) struct Keyword {
    /// In capitals, single spaces.
    pub name: String,
    parameters: Vec<(String, String)>,
    pub line: u64,
}

impl Keyword {
    /// A keyword line, with those it goes on to.
    pub fn parse(first: &Line, lines: &mut Lines) -> Result<Self, Located> {
        let mut text = first.text.clone().into_owned();
        while text.ends_with(',') {
            match lines.next_data() {
                Some(line) => text += &line.text,
                None => break,
            }
        }
        let mut fields = text[1..].split(',').map(str::trim);
        let name = fields.next().unwrap_or_default().split_ascii_whitespace().collect::<Vec<_>>().join(" ");
        let parameters = fields
            .filter(|field| !field.is_empty())
            .map(|field| {
                let (key, value) = field.split_once('=').unwrap_or((field, ""));
                (key.trim().to_ascii_uppercase(), value.trim().trim_matches('"').to_owned())
            })
            .collect();
        Ok(Self { name: name.to_ascii_uppercase(), parameters, line: first.number })
    }

    pub fn has(&self, key: &str) -> bool {
        self.parameters.iter().any(|(name, _)| name == key)
    }

    pub fn value(&self, key: &str) -> Option<&str> {
        self.parameters.iter().find(|(name, _)| name == key).map(|(_, value)| value.as_str())
    }

    /// The value of a parameter that names something.
    pub fn name_value(&self, key: &str) -> Result<Option<String>, Located> {
        let line = Line { text: Cow::Borrowed(""), number: self.line };
        self.value(key).map(|name| checked_name(&line, name)).transpose()
    }

    pub fn syntax(&self, message: String) -> Located {
        Problem::Syntax { message }.at(Place::Line(self.line))
    }

    pub fn not_supported(&self, what: String, advice: &'static str) -> Located {
        Problem::NotSupported { what, advice }.at(Place::Line(self.line))
    }
}

/// A name that is there and is text.
pub(super) fn checked_name(line: &Line, name: &str) -> Result<String, Located> {
    if name.is_empty() {
        Err(line.syntax("a name is missing".into()))
    } else if name.contains('\u{fffd}') {
        Err(line.fail(Problem::NameNotUtf8))
    } else {
        visible_name(name).map_err(|problem| line.fail(problem))
    }
}
