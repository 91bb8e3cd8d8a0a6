//! The deck as a tree of values that know where they were written.

use crate::diagnostics::{Diagnostic, Diagnostics, SourceId, Sources, Span};
use crate::units;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A value and where it was written.
#[derive(Clone, Debug)]
pub struct Node {
    /// Where.
    pub span: Span,
    /// What.
    pub value: Value,
}

/// A value as written.
#[derive(Clone, Debug)]
pub enum Value {
    /// A string.
    Text(String),
    /// A whole number, in digits.
    Integer(String),
    /// A number with a point or an exponent, or `inf` or `nan`, as written.
    Float(String),
    /// `true` or `false`.
    Boolean(bool),
    /// A date or a time of day.
    DateTime,
    /// A list.
    List(Vec<Node>),
    /// A table.
    Table(Table),
}

impl Value {
    /// What the value is, in words.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Text(_) => "a string",
            Self::Integer(_) => "a whole number",
            Self::Float(_) => "a number",
            Self::Boolean(_) => "true or false",
            Self::DateTime => "a date",
            Self::List(_) => "a list",
            Self::Table(_) => "a table",
        }
    }

    /// The entry of a key, if this is a table that has it.
    pub fn entry(&self, key: &str) -> Option<&Entry> {
        match self {
            Self::Table(table) => table.get(key),
            _ => None,
        }
    }
}

/// Keys and values.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// The entries in the order of the text.
    pub entries: Vec<Entry>,
}

/// A key with its value.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The key.
    pub key: String,
    /// Where the key stands.
    pub key_span: Span,
    /// Its value.
    pub node: Node,
}

impl Table {
    /// The entry of a key.
    pub fn get(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.key == key)
    }

    fn position(&self, key: &str) -> Option<usize> {
        self.entries.iter().position(|entry| entry.key == key)
    }
}

/// Parses a text; every fault of its grammar becomes a diagnostic.
pub fn parse(source: SourceId, text: &str, diagnostics: &mut Diagnostics) -> Node {
    let (table, errors) = DeTable::parse_recoverable(text);
    for error in errors {
        let range = error.span().unwrap_or(0..0);
        let help = [range.start, range.end].into_iter().find_map(|place| right_form(text, place));
        let diagnostic = Diagnostic::error(error.message().trim_end()).at(Span::new(source, range), "here");
        diagnostics.push(diagnostic.help_if(help));
    }
    let span = Span::new(source, 0..text.len());
    Node { span, value: Value::Table(table_of(source, table.get_ref())) }
}

/// How the value at a place of a text that is no TOML would be written, if that is clear: a quantity or a name without its quotes.
fn right_form(text: &str, place: usize) -> Option<String> {
    let (before, after) = (text.get(..place)?, text.get(place..)?);
    let start = before.rfind(['=', ',', '[', '{', '\n']).map_or(0, |mark| mark + 1);
    let end = after.find([',', ']', '}', '#', '\n']).map_or(text.len(), |length| place + length);
    let value = text.get(start..end)?.trim();
    let is_quantity = units::parse(value).is_ok_and(|measured| measured.dimension.is_some());
    if is_quantity {
        return Some(format!("a number with a unit is a string: \"{value}\""));
    }
    let is_after_key = text.get(..start)?.ends_with(['=', ',', '[']);
    let is_name = value.starts_with(|c: char| c.is_alphabetic())
        && value.chars().all(|c| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | '/'));
    (is_after_key && is_name).then(|| format!("strings stand in quotes: \"{value}\""))
}

/// The parser bounds the depth, and with it this recursion.
fn table_of(source: SourceId, table: &DeTable<'_>) -> Table {
    let mut entries: Vec<Entry> = table
        .iter()
        .map(|(key, value)| Entry {
            key: key.get_ref().to_string(),
            key_span: Span::new(source, key.span()),
            node: node_of(source, value),
        })
        .collect();
    entries.sort_by_key(|entry| entry.key_span);
    Table { entries }
}

fn node_of(source: SourceId, value: &Spanned<DeValue<'_>>) -> Node {
    let span = Span::new(source, value.span());
    let value = match value.get_ref() {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Integer(integer) if integer.radix() == 10 => Value::Integer(integer.as_str().to_owned()),
        DeValue::Integer(integer) => match i128::from_str_radix(integer.as_str(), integer.radix()) {
            Ok(number) => Value::Integer(number.to_string()),
            Err(_) => Value::Float("inf".to_owned()),
        },
        DeValue::Float(float) => Value::Float(float.as_str().to_owned()),
        DeValue::Boolean(boolean) => Value::Boolean(*boolean),
        DeValue::Datetime(_) => Value::DateTime,
        DeValue::Array(array) => Value::List(array.iter().map(|node| node_of(source, node)).collect()),
        DeValue::Table(table) => Value::Table(table_of(source, table)),
    };
    Node { span, value }
}

const AN_OVERRIDE: &str = "an override is KEY=VALUE, such as --set 'time.end=\"1 us\"'";

/// Lays an override of the command line, `path.of.keys=value`, over the deck.
pub fn apply_override(deck: &mut Node, argument: &str, sources: &mut Sources, diagnostics: &mut Diagnostics) {
    let source = sources.add(format!("--set {argument}"), argument);
    let mut faults = Diagnostics::default();
    let set = parse(source, argument, &mut faults);
    if faults.has_errors() {
        let help = match argument.split_once('=') {
            Some((key, value)) => {
                format!("the value is written as in the deck, with strings in quotes: --set '{key}=\"{value}\"'")
            }
            None => AN_OVERRIDE.to_owned(),
        };
        let fault =
            faults.sorted().first().map_or_else(|| "not a value".to_owned(), |fault| fault.message().to_owned());
        let span = faults.sorted().first().and_then(|fault| fault.span());
        let span = span.unwrap_or(Span::new(source, 0..argument.len()));
        diagnostics
            .push(Diagnostic::error(format!("the override cannot be read: {fault}")).at(span, "here").help(help));
        return;
    }
    if matches!(&set.value, Value::Table(table) if table.entries.is_empty()) {
        let diagnostic =
            Diagnostic::error("the override sets nothing").at(Span::new(source, 0..argument.len()), "here");
        diagnostics.push(diagnostic.help(AN_OVERRIDE));
        return;
    }
    overlay(deck, set, argument, diagnostics);
}

/// The keys of an override lead through tables by name and through lists by position to what it sets, which is replaced, a table
/// with all its keys.
fn overlay(old: &mut Node, new: Node, argument: &str, diagnostics: &mut Diagnostics) {
    let leads_on = !new.span.text(argument).starts_with('{');
    match (&mut old.value, new.value) {
        (Value::Table(old_table), Value::Table(new_table)) if leads_on => {
            for entry in new_table.entries {
                match old_table.position(&entry.key) {
                    Some(position) => {
                        overlay(&mut old_table.entries[position].node, entry.node, argument, diagnostics);
                    }
                    None => old_table.entries.push(entry),
                }
            }
        }
        (Value::List(list), Value::Table(new_table)) if leads_on => {
            let count = list.len();
            for entry in new_table.entries {
                match entry.key.parse::<usize>() {
                    Ok(position) if position < count => {
                        overlay(&mut list[position], entry.node, argument, diagnostics);
                    }
                    Ok(position) if position == count => list.push(entry.node),
                    _ => diagnostics.push(
                        Diagnostic::error(format!("the list has no position `{}`", entry.key))
                            .at(entry.key_span, format!("0 to {count} would be right")),
                    ),
                }
            }
        }
        (_, value) => *old = Node { span: new.span, value },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn overridden(deck: &str, arguments: &[&str]) -> (Node, String) {
        let mut sources = Sources::default();
        let mut diagnostics = Diagnostics::default();
        let source = sources.add("deck.toml", deck);
        let mut tree = parse(source, deck, &mut diagnostics);
        for argument in arguments {
            apply_override(&mut tree, argument, &mut sources, &mut diagnostics);
        }
        (tree, diagnostics.render(&sources, false).to_string())
    }

    fn text_at<'a>(node: &'a Node, path: &[&str]) -> Option<&'a str> {
        match (&node.value, path) {
            (Value::Text(text) | Value::Integer(text) | Value::Float(text), []) => Some(text),
            (Value::Table(table), [key, rest @ ..]) => text_at(&table.get(key)?.node, rest),
            (Value::List(list), [index, rest @ ..]) => text_at(list.get(index.parse::<usize>().ok()?)?, rest),
            _ => None,
        }
    }

    #[test]
    fn overrides_replace_create_and_reach_into_lists() {
        let deck = "[time]\nend = 1\n[[part]]\ngroup = \"a\"\n";
        let arguments = ["time.end=\"1 us\"", "part.0.group = 'b'", "part.1.group='c'", "mesh.file = 'm'"];
        let (tree, errors) = overridden(deck, &arguments);
        assert_eq!(errors, "");
        assert_eq!(text_at(&tree, &["time", "end"]), Some("1 us"));
        assert_eq!(text_at(&tree, &["part", "0", "group"]), Some("b"));
        assert_eq!(text_at(&tree, &["part", "1", "group"]), Some("c"));
        assert_eq!(text_at(&tree, &["mesh", "file"]), Some("m"));
    }

    #[test]
    fn unquoted_override_is_told_how_to_quote() {
        let (_, errors) = overridden("", &["time.end=1 us"]);
        assert!(errors.contains("--set time.end=1 us:1:"), "{errors}");
        assert!(errors.contains("--set 'time.end=\"1 us\"'"), "{errors}");
        let (_, errors) = overridden("", &["nonsense"]);
        assert!(errors.contains("KEY=VALUE"), "{errors}");
        let (_, errors) = overridden("part = []", &["part.3.group='a'"]);
        assert!(errors.contains("no position `3`"), "{errors}");
    }

    #[test]
    fn every_fault_of_the_grammar_is_found() {
        let (_, errors) = overridden("a = \nb = 1\nb = 2\nc = [1, 2\n", &[]);
        assert!(errors.contains("deck.toml:1:") && errors.contains("deck.toml:3:"), "{errors}");
    }

    #[test]
    fn deep_nesting_is_an_error_and_not_a_crash() {
        let deep = format!("a = {}{}", "[".repeat(100_000), "]".repeat(100_000));
        assert!(overridden(&deep, &[]).1.contains("error"));
        let deep = format!("{}b = 1", "a.".repeat(100_000));
        assert!(overridden(&deep, &[]).1.contains("error"));
        let deep = format!("[{}b]", "a.".repeat(100_000));
        assert!(overridden(&deep, &[]).1.contains("error"));
    }
}
