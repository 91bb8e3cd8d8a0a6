//! The deck's reference for people, written from what the parser itself uses.

use crate::decoder::ReadKeys;
use crate::schema::{KeySchema, Presence, QuantitySchema, Schema, TableSchema, Variants};
use crate::units::Dimension;
use std::fmt::Write;

const HEAD: &str = "\
# The deck

A deck is a TOML file. This page is generated from the parser's own tables (`ESTAR_UPDATE_DOCS=1 cargo test --release
--test deck` rewrites it), so that it lists every key there is. An unknown key is an error.

**Quantities** are numbers in SI units or strings with a unit: `\"117 GPa\"`, `\"32.4 mm\"`, `\"80 us\"`, `\"8930 kg/m^3\"`,
`\"8.93 g/cm^3\"`, `\"0.3 %\"`, `\"105 rad/s\"`, `\"36 km/h\"`. Known are m, g, s, N, Pa, J, K, rad with the prefixes f p n u (µ) m c d
h k M G, and min, h, t, bar, in, ft, lb, lbf, psi, ksi, deg, rpm, degC, %; they are joined by `*`, blanks or `/` and take
powers: `kg/m^3`, `m/s²`, `J/(kg K)`. A unit of the wrong dimension is an error.

**Groups** are the physical groups (Gmsh), or the sets and surfaces (Abaqus), of the mesh; `all` is all of it. Where several have one
name, a key takes what it needs, or asks for a full name such as `assembly.foot`: [mesh files](mesh-files.md#groups).

**On the command line** `estar run DECK --set KEY=VALUE` replaces or adds any key, as in `--set time.end='\"1 us\"'` or
`--set part.0.element='\"hex8\"'` (entries of a list are counted from 0).

**In an editor** that knows JSON Schema, keys are completed, explained and checked while you type: `estar check --schema`
prints the schema of decks, `estar point --schema` that of decks of a material point. With Taplo and Even Better TOML, save it
beside the deck and let the deck begin with the line `#:schema ./estar.schema.json`.

Below, `[name]` is a table that stands once, `[[name]]` one that may stand any number of times.
";

const POINT_HEAD: &str = "
# The deck of a material point

`estar point DECK` leads materials along a path, without a mesh. Its deck has a title, materials as above, a path, and panels
for the plots. It writes `point.csv`, `point.png` and `point.svg`.
";

/// The reference as Markdown.
pub fn markdown() -> String {
    let mut text = HEAD.to_owned();
    let keys = super::Deck::keys().keys;
    write_deck(&mut text, &keys);
    text.push_str(POINT_HEAD);
    let point = super::point::PointDeck::keys().keys;
    // the materials stand above
    write_deck(&mut text, &point.into_iter().filter(|key| key.name != "material").collect::<Vec<_>>());
    text
}

fn write_deck(text: &mut String, keys: &[KeySchema]) {
    text.push_str("\n## Top level\n\n");
    write_keys(text, keys.iter().filter(|key| table_of(&key.value).is_none()));
    for key in keys {
        let heading = match &key.value {
            Schema::List(_) => format!("`[[{}]]`", key.name),
            Schema::Named(_) => format!("`[{}.NAME]`", key.name),
            _ => format!("`[{}]`", key.name),
        };
        if let Some(table) = table_of(&key.value) {
            let need = if key.presence == Presence::Required { " (required)" } else { "" };
            let _ = write!(text, "\n## {heading}{need}\n\n");
            write_table(text, table, key.name);
        }
    }
}

/// The table in a value, if it is one, or a list of tables, or tables under names.
fn table_of(schema: &Schema) -> Option<&TableSchema> {
    match schema {
        Schema::Table(table) => Some(table),
        Schema::List(inner) | Schema::Named(inner) => table_of(inner),
        _ => None,
    }
}

fn write_table(text: &mut String, table: &TableSchema, path: &str) {
    let doc = one_line(table.doc);
    if !doc.is_empty() {
        let _ = write!(text, "{doc}\n\n");
    }
    if !table.keys.is_empty() {
        write_keys(text, table.keys.iter());
    }
    for key in &table.keys {
        write_inner(text, key, path);
    }
    for variants in &table.variants {
        let default = variants.default.map_or("required".to_owned(), |default| format!("default `\"{default}\"`"));
        let _ = write!(text, "\n**`{}`** ({default}): {}\n", variants.tag, one_line(variants.doc));
        for (choice, keys) in &variants.cases {
            let _ = write!(text, "\n- `{} = \"{}\"`: {}\n", variants.tag, choice.name, one_line(choice.doc));
            if !keys.is_empty() {
                text.push('\n');
                let mut inner = String::new();
                write_keys(&mut inner, keys.iter());
                text.extend(inner.lines().map(|line| format!("  {line}\n")));
            }
        }
        write_inner_of_variants(text, variants, path);
    }
}

/// The inner tables of all choices: one that several choices have stands once, and tables that share a name say whose
/// they are.
fn write_inner_of_variants(text: &mut String, variants: &Variants, path: &str) {
    let mut inner: Vec<(String, String, Vec<String>)> = Vec::new();
    for (choice, keys) in &variants.cases {
        for key in keys {
            let Some(table) = table_of(&key.value) else { continue };
            let path = format!("{path}.{}", key.name);
            let mut body = String::new();
            write_table(&mut body, table, &path);
            let choice = format!("`{} = \"{}\"`", variants.tag, choice.name);
            match inner.iter_mut().find(|(other, same, _)| *other == path && *same == body) {
                Some((_, _, choices)) => choices.push(choice),
                None => inner.push((path, body, vec![choice])),
            }
        }
    }
    for (path, body, choices) in &inner {
        let is_alone = inner.iter().filter(|(other, _, _)| other == path).count() == 1;
        let owners = if is_alone { String::new() } else { format!(" of {}", choices.join(", ")) };
        let _ = write!(text, "\n### `{path}`{owners}\n\n{body}");
    }
}

fn write_inner(text: &mut String, key: &KeySchema, path: &str) {
    if let Some(table) = table_of(&key.value) {
        let path = format!("{path}.{}", key.name);
        let _ = write!(text, "\n### `{path}`\n\n");
        write_table(text, table, &path);
    }
}

fn write_keys<'a>(text: &mut String, keys: impl Iterator<Item = &'a KeySchema>) {
    text.push_str("| key | value | default | meaning |\n|---|---|---|---|\n");
    for key in keys {
        let default = match key.presence {
            Presence::Required => "required".to_owned(),
            Presence::Optional => "none".to_owned(),
            Presence::Default(default) => format!("`{}`", default.replace('\'', "\"")),
        };
        let _ = writeln!(text, "| `{}` | {} | {default} | {} |", key.name, value(&key.value), one_line(key.doc));
    }
}

/// What a value must be, in words.
pub(crate) fn value(schema: &Schema) -> String {
    match schema {
        Schema::Text(what) => (*what).to_owned(),
        Schema::Group(kinds) => format!("name of a {kinds} group"),
        Schema::Count => "whole number from 1".to_owned(),
        Schema::Quantity(quantity) => words(quantity),
        Schema::Vector(quantity, count) => format!("list of {count}: {}", words(quantity)),
        Schema::Direction => "list of 3: number, not all 0".to_owned(),
        Schema::Points(x, y) => format!("list of pairs: {}; {}", words(x), words(y)),
        Schema::Rows(row, _) => format!("list of rows {row}"),
        Schema::Choice(choices) => {
            let names = choices.iter().map(|choice| format!("`\"{}\"` ({})", choice.name, choice.doc));
            names.collect::<Vec<_>>().join(", ")
        }
        Schema::Table(_) => "table, below".to_owned(),
        Schema::List(inner) => format!("list of: {}", value(inner)),
        Schema::Named(_) => "tables, below".to_owned(),
        Schema::Either(schemas) => schemas.iter().map(value).collect::<Vec<_>>().join(" or "),
    }
}

fn words(quantity: &QuantitySchema) -> String {
    let dimension = match quantity.dimension {
        _ if quantity.is_angle => "angle with its unit (deg or rad)".to_owned(),
        None => "quantity".to_owned(),
        Some(Dimension::NUMBER) => "number".to_owned(),
        Some(dimension) => format!("{dimension} ({})", dimension.si_unit()),
    };
    let name = dimension.trim_start_matches("an ").trim_start_matches("a ");
    match quantity.interval.words() {
        Some(bound) => format!("{name}, {bound}"),
        None => name.to_owned(),
    }
}

fn one_line(doc: &str) -> String {
    joined(doc).replace('|', "\\|")
}

/// A text on one line.
pub(crate) fn joined(doc: &str) -> String {
    doc.split_whitespace().collect::<Vec<_>>().join(" ")
}
