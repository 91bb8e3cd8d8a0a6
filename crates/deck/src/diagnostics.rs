//! Messages about input: what is wrong, where it stands in the source, and what would be right.

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use estar_io::{LONGEST_NAME, one_line, visible};
use serde::Serialize;
use std::fmt;
use std::ops::Range;

/// A piece of text of one source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Span {
    source: usize,
    start: usize,
    end: usize,
}

impl Span {
    /// The bytes `range` of the source.
    pub fn new(source: SourceId, range: Range<usize>) -> Self {
        Self { source: source.0, start: range.start, end: range.end }
    }

    /// What it is of the text of its source.
    pub fn text(self, source: &str) -> &str {
        source.get(self.start..self.end).unwrap_or_default()
    }

    /// Its first byte, as an empty span.
    pub fn beginning(self) -> Self {
        Self { end: self.start, ..self }
    }
}

/// A text of [`Sources`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SourceId(usize);

/// The texts that spans point into: the deck, and every override of the command line as a file of its own.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    texts: Vec<Source>,
}

#[derive(Clone, Debug)]
struct Source {
    name: String,
    text: String,
}

impl Sources {
    /// Adds a text under the name that messages show.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<String>) -> SourceId {
        self.texts.push(Source { name: name.into(), text: text.into() });
        SourceId(self.texts.len() - 1)
    }

    /// The name of the text that a span points into.
    pub fn name(&self, span: Span) -> Option<String> {
        self.texts.get(span.source).map(|source| source.name.clone())
    }

    /// Line and column of the beginning of a span, both from 1; columns count characters.
    pub fn position(&self, span: Span) -> (usize, usize) {
        let text = self.texts.get(span.source).map_or("", |source| source.text.as_str());
        let before = text.get(..span.start).unwrap_or(text);
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }
}

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The input cannot be used.
    Error,
    /// The input can be used, but is probably not what was meant.
    Warning,
}

/// One finding about the input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    severity: Severity,
    message: String,
    labels: Vec<(Span, String)>,
    help: Vec<String>,
}

impl Diagnostic {
    /// An error.
    pub fn error(message: impl Into<String>) -> Self {
        Self { severity: Severity::Error, message: bounded(message.into()), labels: Vec::new(), help: Vec::new() }
    }

    /// A warning.
    pub fn warning(message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(message) }
    }

    /// Underlines a span; the first one is where the fault is, others are what it contradicts.
    #[must_use]
    pub fn at(mut self, span: Span, label: impl Into<String>) -> Self {
        self.labels.push((span, bounded(label.into())));
        self
    }

    /// Adds what would be right.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help.push(bounded(help.into()));
        self
    }

    /// Adds what would be right, if there is something to say.
    #[must_use]
    pub fn help_if(self, help: Option<String>) -> Self {
        match help {
            Some(help) => self.help(help),
            None => self,
        }
    }

    /// How bad it is.
    pub fn severity(&self) -> Severity {
        self.severity
    }

    /// What is wrong, in one sentence.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// What would be right.
    pub fn helps(&self) -> &[String] {
        &self.help
    }

    /// Where the fault is.
    pub fn span(&self) -> Option<Span> {
        self.labels.first().map(|(span, _)| *span)
    }

    fn report<'a>(&'a self, sources: &'a Sources) -> Vec<Group<'a>> {
        let level = match self.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let mut group = Group::with_title(level.primary_title(&self.message));
        let mut shown: Vec<usize> = Vec::new();
        for (span, _) in &self.labels {
            if shown.contains(&span.source) {
                continue;
            }
            shown.push(span.source);
            let Some(source) = sources.texts.get(span.source) else { continue };
            let annotations = self.labels.iter().enumerate().filter(|(_, (s, _))| s.source == span.source);
            let snippet = Snippet::source(&source.text).path(one_line(&source.name)).annotations(annotations.map(
                |(index, (span, label))| {
                    let kind = if index == 0 { AnnotationKind::Primary } else { AnnotationKind::Context };
                    kind.span(underlined(&source.text, *span)).label(visible(label))
                },
            ));
            group = group.element(snippet);
        }
        vec![self.with_help(group)]
    }

    fn with_help<'a>(&'a self, group: Group<'a>) -> Group<'a> {
        // the renderer replaces what steers a terminal in titles and sources, but neither here nor in labels
        group.elements(self.help.iter().map(|help| Level::HELP.message(visible(help))))
    }
}

/// A text that is not longer than a message can be: what it quotes may be of any length.
fn bounded(text: String) -> String {
    const LONGEST: usize = 8000;
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}

/// Findings as a text for a terminal. Nothing in it steers the terminal but colours, if they were wanted.
#[derive(Clone, Debug, Default)]
pub struct Rendered(String);

impl Rendered {
    /// What the renderer made, where the only escapes are those of its colours.
    fn of(text: &str) -> Self {
        const ESCAPE: &str = "\u{1b}";
        Self(text.split(ESCAPE).map(visible).collect::<Vec<_>>().join(ESCAPE))
    }
}

impl fmt::Display for Rendered {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

/// The part of a span that is worth underlining: on one line, on character boundaries.
fn underlined(text: &str, span: Span) -> Range<usize> {
    let boundary = |mut index: usize| {
        index = index.min(text.len());
        while !text.is_char_boundary(index) {
            index -= 1;
        }
        index
    };
    let start = boundary(span.start);
    let end = boundary(span.end.max(span.start));
    let line = text[start..end].split(['\n', '\r']).next().unwrap_or_default();
    start..start + line.len()
}

/// Everything found in one go.
#[derive(Debug, Default)]
pub struct Diagnostics {
    found: Vec<Diagnostic>,
}

/// More messages than this help nobody.
const MOST_SHOWN: usize = 40;

impl Diagnostics {
    /// Adds a finding.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        self.found.push(diagnostic);
    }

    /// Adds findings.
    pub fn extend(&mut self, diagnostics: impl IntoIterator<Item = Diagnostic>) {
        self.found.extend(diagnostics);
    }

    /// How many of the findings are errors.
    pub fn error_count(&self) -> usize {
        self.found.iter().filter(|diagnostic| diagnostic.severity == Severity::Error).count()
    }

    /// Whether there is an error among the findings.
    pub fn has_errors(&self) -> bool {
        self.found.iter().any(|diagnostic| diagnostic.severity == Severity::Error)
    }

    /// The findings in the order of the text.
    pub fn sorted(&self) -> Vec<&Diagnostic> {
        let mut sorted: Vec<_> = self.found.iter().collect();
        sorted.sort_by_key(|diagnostic| diagnostic.span());
        sorted
    }

    /// All findings as a text for a terminal, coloured or plain.
    pub fn render(&self, sources: &Sources, coloured: bool) -> Rendered {
        let renderer = if coloured { Renderer::styled() } else { Renderer::plain() };
        let sorted = self.sorted();
        let mut text = String::new();
        for diagnostic in sorted.iter().take(MOST_SHOWN) {
            text.push_str(&renderer.render(&diagnostic.report(sources)));
            text.push_str("\n\n");
        }
        if sorted.len() > MOST_SHOWN {
            text.push_str(&format!("... and {} more\n\n", sorted.len() - MOST_SHOWN));
        }
        let count = |severity| sorted.iter().filter(|diagnostic| diagnostic.severity == severity).count();
        let errors = count(Severity::Error);
        if errors > 0 {
            text.push_str(&format!("{errors} error{} in the input\n", if errors == 1 { "" } else { "s" }));
        }
        Rendered::of(&text)
    }
}

/// Diagnostics with the texts that they point into.
#[derive(Debug, Default)]
pub struct Findings {
    /// The texts.
    pub sources: Sources,
    /// The diagnostics.
    pub diagnostics: Diagnostics,
}

/// A diagnostic as data.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// "error" or "warning".
    pub severity: &'static str,
    /// What is wrong.
    pub message: String,
    /// The file, or the override of the command line.
    pub file: Option<String>,
    /// The line, from 1.
    pub line: Option<usize>,
    /// The column, from 1.
    pub column: Option<usize>,
    /// What would be right.
    pub help: Vec<String>,
}

impl Finding {
    /// An error without a place.
    pub fn without_place(message: String) -> Self {
        Self { severity: "error", message, file: None, line: None, column: None, help: Vec::new() }
    }
}

impl Findings {
    /// All of them as text.
    pub fn render(&self, coloured: bool) -> Rendered {
        self.diagnostics.render(&self.sources, coloured)
    }

    /// All of them as data.
    pub fn data(&self) -> Vec<Finding> {
        let finding = |diagnostic: &&Diagnostic| {
            let place = diagnostic.span().map(|span| self.sources.position(span));
            Finding {
                severity: match diagnostic.severity {
                    Severity::Error => "error",
                    Severity::Warning => "warning",
                },
                message: diagnostic.message.clone(),
                file: diagnostic.span().and_then(|span| self.sources.name(span)),
                line: place.map(|(line, _)| line),
                column: place.map(|(_, column)| column),
                help: diagnostic.help.clone(),
            }
        };
        self.diagnostics.sorted().iter().map(finding).collect()
    }
}

/// The candidate most like `name`, if one is close enough to have been meant.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // the comparison takes the product of the lengths
    let is_name = |name: &&str| name.len() <= 4 * LONGEST_NAME;
    let candidates = candidates.into_iter().filter(is_name);
    Some(name).filter(is_name)?;
    let folded = |text: &str| text.to_lowercase().replace(['-', ' '], "_");
    let wanted = folded(name);
    let distance = |candidate: &str| strsim::damerau_levenshtein(&wanted, &folded(candidate));
    let (distance, best) = candidates.map(|candidate| (distance(candidate), candidate)).min()?;
    (distance <= (wanted.chars().count() / 3).max(1)).then_some(best)
}

/// Names in back quotes, separated by commas; of very many, the first.
pub fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    const MOST_LISTED: usize = 30;
    let mut names = names.into_iter();
    let quoted: Vec<_> = names.by_ref().take(MOST_LISTED).map(|name| format!("`{}`", one_line(name))).collect();
    let more = match names.count() {
        0 => String::new(),
        count => format!(", and {count} more"),
    };
    quoted.join(", ") + &more
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_name_is_suggested_only_when_close() {
        let names = ["young_modulus", "poisson_ratio", "density"];
        assert_eq!(nearest("youngs_modulus", names), Some("young_modulus"));
        assert_eq!(nearest("Young-modulus", names), Some("young_modulus"));
        assert_eq!(nearest("densty", names), Some("density"));
        assert_eq!(nearest("viscosity", names), None);
        assert_eq!(nearest("", names), None);
    }

    #[test]
    fn rendered_error_names_file_line_and_column_and_underlines() {
        let mut sources = Sources::default();
        let text = "first = 1\r\n\tsecond = \"x\"\r\n";
        let id = sources.add("deck.toml", text);
        let start = text.find("\"x\"").unwrap();
        let mut diagnostics = Diagnostics::default();
        diagnostics.push(Diagnostic::error("not a number").at(Span::new(id, start..start + 3), "text").help("write 2"));
        let rendered = diagnostics.render(&sources, false).to_string();
        assert!(rendered.contains("deck.toml:2:"), "{rendered}");
        assert!(rendered.contains("^^^ text"), "{rendered}");
        assert!(rendered.contains("help: write 2"), "{rendered}");
    }

    #[test]
    fn spans_off_the_text_do_no_harm() {
        let mut sources = Sources::default();
        let id = sources.add("deck.toml", "µ");
        let mut diagnostics = Diagnostics::default();
        for range in [0..0, 1..1, 1..2, 0..9, 7..9] {
            diagnostics.push(Diagnostic::error("fault").at(Span::new(id, range), "here"));
        }
        assert!(diagnostics.render(&sources, false).to_string().contains("5 errors"));
    }

    #[test]
    fn nothing_steers_the_terminal_but_colours() {
        let mut sources = Sources::default();
        let hidden = "\u{1b}]0;x\u{7}\u{9b}2J\u{202e}\u{200f}\u{61c}";
        let text = format!("a = \"{hidden}\"\n");
        let id = sources.add(format!("deck{hidden}.toml"), &text);
        let mut diagnostics = Diagnostics::default();
        let diagnostic = Diagnostic::error(hidden).at(Span::new(id, 4..text.len() - 1), hidden).help(hidden);
        diagnostics.push(diagnostic);
        let plain = diagnostics.render(&sources, false).to_string();
        assert_eq!(visible(&plain), plain);
        let coloured = diagnostics.render(&sources, true).to_string();
        for (index, piece) in coloured.split('\u{1b}').enumerate() {
            let (colour, rest) = if index == 0 { ("", piece) } else { piece.split_once('m').unwrap() };
            assert!(colour.bytes().all(|byte| byte.is_ascii_digit() || b"[;".contains(&byte)), "{colour:?}");
            assert_eq!(visible(rest), rest);
        }
    }

    #[test]
    fn texts_of_any_length_are_told_in_a_few_lines() {
        let mut sources = Sources::default();
        let long = "n".repeat(200_000);
        let text = format!("a = \"{long}\" b\n");
        let id = sources.add("deck.toml", &text);
        let mut diagnostics = Diagnostics::default();
        for range in [4..text.len() - 3, text.len() - 2..text.len() - 1] {
            diagnostics.push(Diagnostic::error(&long).at(Span::new(id, range), &long).help(&long));
        }
        for coloured in [false, true] {
            assert!(diagnostics.render(&sources, coloured).to_string().len() < 60_000);
        }
        assert_eq!(nearest(&long, ["density"]), None);
    }
}
