//! What a deck of `estar point` asks for: the materials that are compared, and the path on which they are.

use crate::decoder::{At, Decoder, FromDeck, ReadKeys};
use crate::diagnostics::{Diagnostic, Span, listed, nearest};
use crate::material::{HEATING_KEYS, MaterialTable};
use crate::point::{PlotTable, PointDeck};
use crate::point_column::Column;
use crate::point_path::Path;
use crate::schema::{Choice, Schema};
use crate::tree::{Entry, Node, Table, Value};
use estar_material::{FlowRule, MaterialModel, ObjectiveRate};

/// What `estar point` is to do.
#[derive(Clone, Debug)]
pub struct PointProblem {
    /// The deck's title.
    pub title: String,
    /// The materials: that of the path, and those that it is compared with.
    pub subjects: Vec<Subject>,
    /// The path.
    pub path: Path,
    /// Columns of each panel of the plots: along x, along y.
    pub plots: Vec<(Column, Vec<Column>)>,
}

impl PointProblem {
    /// What a deck asks for, or nothing after the faults have been reported. `root` is the tree of the deck.
    pub fn new(deck: PointDeck, root: &Node, decoder: &mut Decoder) -> Option<Self> {
        let subjects = subjects(&deck, root, decoder);
        let path = Path::new(&deck.path, decoder);
        let plots: Vec<_> = deck.plot.iter().map(|plot| columns(plot, decoder)).collect();
        let subjects = subjects?;
        let has_temperature = subjects.iter().any(|subject| subject.model.has_temperature());
        for plot in deck.plot.iter().filter(|_| !has_temperature) {
            let y = plot.y.iter().map(|column| (column.value, column.span));
            let shown = y.chain([(plot.x, plot.span)]).find(|(column, _)| *column == Column::Temperature);
            if let Some((_, span)) = shown {
                let diagnostic = Diagnostic::error("`plot` shows a temperature, but no material on the path has one");
                let help = "the law johnson-cook knows a temperature";
                decoder.report(diagnostic.at(span, "this plot").help(help));
                return None;
            }
        }
        Some(Self { title: deck.title, subjects, path: path?, plots: plots.into_iter().collect::<Option<_>>()? })
    }
}

/// The columns of a panel.
fn columns(plot: &PlotTable, decoder: &mut Decoder) -> Option<(Column, Vec<Column>)> {
    let Some(first) = plot.y.first() else {
        decoder.report(Diagnostic::error("`plot.y` names no column").at(plot.span, "one at least is needed"));
        return None;
    };
    for (index, column) in plot.y.iter().enumerate() {
        if column.value.dimension() != first.value.dimension() {
            let message = "`plot.y` names columns of different kinds";
            let diagnostic = Diagnostic::error(message).at(column.span, "this one").at(first.span, "and this one");
            decoder.report(diagnostic.help("one axis shows one kind: begin another [[plot]]"));
            return None;
        }
        if let Some(earlier) = plot.y[..index].iter().find(|earlier| earlier.value == column.value) {
            let diagnostic = Diagnostic::error("`plot.y` names a column twice").at(column.span, "the second time");
            decoder.report(diagnostic.at(earlier.span, "the first time").help("once is enough"));
            return None;
        }
    }
    Some((plot.x, plot.y.iter().map(|column| column.value).collect()))
}

/// A material on the path.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Its name in legends.
    pub label: String,
    /// What stands before the names of its columns in point.csv; nothing for the material of the path itself.
    pub prefix: String,
    /// The material.
    pub model: MaterialModel,
}

/// The material of the path and those that it is compared with.
fn subjects(deck: &PointDeck, root: &Node, decoder: &mut Decoder) -> Option<Vec<Subject>> {
    let materials = &deck.material.0;
    let (name, model) = match &deck.path.material {
        Some(wanted) => materials.iter().find(|(name, _)| *name == wanted.0.value)?,
        None => match materials.first() {
            Some(first) => first,
            None => {
                let diagnostic = Diagnostic::error("the deck has no material").at(deck.path.span, "the path of which?");
                decoder.report(diagnostic.help("a table such as [material.steel]"));
                return None;
            }
        },
    };
    let table = table(root, &["material", name])?;
    let theory = text_of(table, "theory")?;
    let siblings = siblings(&theory);
    let mut own = siblings.as_ref().and_then(|siblings| text_of(table, siblings.key).or(siblings.default.clone()));
    let mut model = model.clone();
    if let Some(rate) = &deck.path.rate {
        if theory != "elastic" {
            let message = format!("`path.rate` is for elastic materials, but `{name}` has the theory \"{theory}\"");
            decoder.report(Diagnostic::error(message).at(rate.span, "a rate").help("leave it out"));
            return None;
        }
        own = Some(rate_name(rate.value).to_owned());
        model = MaterialModel::hypoelastic(model.elasticity(), rate.value);
    }

    let theories = theory_names();
    let mut subjects = vec![Subject { label: name.clone(), prefix: String::new(), model: model.clone() }];
    let mut is_good = true;
    for (index, other) in deck.path.compare.iter().enumerate() {
        let wanted = other.value.as_str();
        let twice = deck.path.compare[..index].iter().any(|earlier| earlier.value == wanted);
        if twice || wanted == name || own.as_deref() == Some(wanted) {
            let label = if twice { "the second time" } else { "the material of the path itself" };
            let diagnostic = Diagnostic::error(format!("`path.compare` has \"{wanted}\" once too often"));
            decoder.report(diagnostic.at(other.span, label).help("once is enough"));
            is_good = false;
            continue;
        }
        let compared = if let Some((_, model)) = materials.iter().find(|(name, _)| name == wanted) {
            Some(model.clone())
        } else if theories.contains(&wanted) {
            subjects[0].label = display_name(&theory);
            with_theory(table, wanted, other.span, decoder)
        } else if let Some(siblings) = siblings.as_ref().filter(|siblings| siblings.names.contains(&wanted)) {
            subjects[0].label = display_name(own.as_deref().unwrap_or_default());
            with_key(table, siblings.key, wanted, other.span, decoder)
        } else {
            let names = materials.iter().map(|(name, _)| name.as_str()).chain(theories.iter().copied());
            unknown(other, names.chain(siblings.iter().flat_map(|siblings| siblings.names.iter().copied())), decoder);
            None
        };
        match compared {
            Some(model) => subjects.push(Subject {
                label: display_name(wanted),
                prefix: format!("{}.", wanted.replace('-', "_")),
                model,
            }),
            None => is_good = false,
        }
    }
    is_good.then_some(subjects)
}

/// A key of a theory whose other values can be compared by their names.
struct Siblings {
    key: &'static str,
    default: Option<String>,
    names: Vec<&'static str>,
}

fn siblings(theory: &str) -> Option<Siblings> {
    match theory {
        "elastic" => {
            Some(Siblings { key: "rate", default: Some("box".to_owned()), names: names_of::<ObjectiveRate>() })
        }
        "plastic-metric" => Some(Siblings { key: "flow_rule", default: None, names: names_of::<FlowRule>() }),
        _ => None,
    }
}

fn unknown<'a>(other: &At<String>, names: impl Iterator<Item = &'a str>, decoder: &mut Decoder) {
    let names: Vec<&str> = names.collect();
    let label = match nearest(&other.value, names.iter().copied()) {
        Some(similar) => format!("did you mean \"{similar}\"?"),
        None => "unknown".to_owned(),
    };
    let diagnostic = Diagnostic::error(format!("`path.compare` cannot have \"{}\"", other.value)).at(other.span, label);
    decoder.report(diagnostic.help(format!("the choices are {}", listed(names))));
}

/// The material of a table under another theory, with the keys that the theory knows.
fn with_theory(table: &Table, theory: &str, span: Span, decoder: &mut Decoder) -> Option<MaterialModel> {
    let schema = MaterialTable::keys();
    let surface = table.get("yield_surface").and_then(|entry| entry.node.value.entry("kind"));
    let is_von_mises = surface.is_none_or(|kind| matches!(&kind.node.value, Value::Text(kind) if kind == "von-mises"));
    if !is_von_mises && theory != "elastic" {
        let message =
            format!("`path.compare` cannot have \"{theory}\": it does not know the yield surface of the material");
        let help = "the theory hencky alone has other surfaces than von-mises; what can be compared with it is elastic";
        decoder.report(Diagnostic::error(message).at(span, "this theory").help(help));
        return None;
    }
    let cases = schema.variants.iter().flat_map(|variants| &variants.cases);
    let own = cases.filter(|(choice, _)| choice.name == theory).flat_map(|(_, keys)| keys);
    let known: Vec<&str> = schema.keys.iter().chain(own).map(|key| key.name).collect();
    // the keys of heating go with the law that heats
    let is_known = |key: &str| known.contains(&key) && (known.contains(&"hardening") || !HEATING_KEYS.contains(&key));
    let entries = table.entries.iter().filter(|entry| is_known(&entry.key)).cloned().collect();
    with_key(&Table { entries }, "theory", theory, span, decoder)
}

/// The material of a table with another value of a key; none where the deck has faults that it would have as well.
fn with_key(table: &Table, key: &str, value: &str, span: Span, decoder: &mut Decoder) -> Option<MaterialModel> {
    if decoder.diagnostics.has_errors() {
        return None;
    }
    let mut changed = table.clone();
    changed.entries.retain(|entry| entry.key != key);
    let node = Node { span, value: Value::Text(value.to_owned()) };
    changed.entries.push(Entry { key: key.to_owned(), key_span: span, node });
    decoder.value("compare", &Node { span, value: Value::Table(changed) })
}

fn table<'a>(root: &'a Node, keys: &[&str]) -> Option<&'a Table> {
    let Value::Table(table) = &root.value else { return None };
    match keys {
        [] => Some(table),
        [key, rest @ ..] => self::table(&table.get(key)?.node, rest),
    }
}

fn text_of(table: &Table, key: &str) -> Option<String> {
    match &table.get(key)?.node.value {
        Value::Text(text) => Some(text.clone()),
        _ => None,
    }
}

fn theory_names() -> Vec<&'static str> {
    let variants = MaterialTable::keys().variants;
    variants.iter().flat_map(|variants| &variants.cases).map(|(choice, _)| choice.name).collect()
}

/// The names that a key may have.
fn names_of<T: FromDeck>() -> Vec<&'static str> {
    match T::schema() {
        Schema::Choice(choices) => choices.iter().map(|choice: &Choice| choice.name).collect(),
        _ => Vec::new(),
    }
}

/// The name of a rate in a deck.
fn rate_name(rate: ObjectiveRate) -> &'static str {
    match rate {
        ObjectiveRate::Box => "box",
        ObjectiveRate::Jaumann => "jaumann",
        ObjectiveRate::Logarithmic => "logarithmic",
        ObjectiveRate::Truesdell => "truesdell",
        ObjectiveRate::UpperConvected => "upper-convected",
        ObjectiveRate::LowerConvected => "lower-convected",
    }
}

/// A name of a theory or a rate as people write it; another name as it is.
fn display_name(name: &str) -> String {
    match name {
        "e-star" => "E* theory".to_owned(),
        "green-naghdi" => "Green-Naghdi".to_owned(),
        "hencky" => "Hencky".to_owned(),
        "jaumann" => "Jaumann".to_owned(),
        "truesdell" => "Truesdell".to_owned(),
        "upper-convected" => "upper convected".to_owned(),
        "lower-convected" => "lower convected".to_owned(),
        "simo-miehe" => "Simo & Miehe".to_owned(),
        "miehe" => "Miehe".to_owned(),
        "lion" => "Lion".to_owned(),
        "simo-hughes" => "Simo & Hughes".to_owned(),
        "helm" => "Helm".to_owned(),
        "grandi-stefanelli" => "Grandi & Stefanelli".to_owned(),
        "frobenius-normal" => "Frobenius-normal".to_owned(),
        other => other.to_owned(),
    }
}
