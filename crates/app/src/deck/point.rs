//! The deck of `estar point`: materials along a path, without a mesh.

use super::decoder::{At, Decoder, FromDeck, ReadKeys};
use super::macros::{deck_choice, deck_table, deck_variants};
use super::material::{HEATING_KEYS, MaterialTable};
use super::schema::{Choice, Schema};
use super::tree::{Entry, Node, Table, Value};
use super::values::{Count, MaterialName, Materials, NEGLIGIBLE, Number, Quantity, Time, TimePoints, begins_with};
use crate::diagnostics::{Diagnostic, Span, listed, nearest};
use crate::point::column::Column;
use crate::point::path::Path;
use estar_material::point::StretchMeasure;
use estar_material::{FlowRule, MaterialModel, ObjectiveRate};
use estar_tensor::Tensor;

deck_table! {
    /// A path of a material point, for `estar point`.
    pub struct PointDeck {
        /// A title for people; it stands above the plots.
        title: String = default("''"),
        /// The materials.
        material: Materials<MaterialModel> = required,
        /// The path.
        path: PathTable = required,
        /// Panels of the plots, in place of those that suit the path.
        plot: Vec<PlotTable> = default("[]"),
    }
}

deck_table! {
    /// How the material is deformed, from its undeformed state at the first time of the curve.
    pub struct PathTable {
        /// The material; the first of the deck unless given.
        material: MaterialName = optional,
        /// What is compared with it on the same path: other materials of the deck by their names, theories with the parameters
        /// of the material that they know, for `theory = "elastic"` objective rates, for `theory = "plastic-metric"` flow rules.
        compare: Vec<At<String>> = default("[]"),
        /// Objective rate of the elastic material, in place of its own.
        rate: At<ObjectiveRate> = optional,
        /// Number of steps. Each piece of the curve has its share by its duration, and ends with a step.
        steps: At<Count> = default("1000"),
        /// Steps from one row of point.csv to the next; the last step has a row in any case.
        every: Count = default("1"),
        /// What is driven, with its curve.
        kind: PathKind = flatten,
    }
}

deck_variants! {
    /// What is driven.
    pub enum PathKind by kind {
        /// The stretch along x; the stretches along y and z follow so that no stress acts there.
        UniaxialStress = "uniaxial-stress" {
            /// What the curve measures the stretch by.
            measure: StretchMeasure = default("'green-lagrange'"),
            /// Points [time, value], times increasing.
            curve: At<TimePoints<Number>> = required,
        }
        /// The stretch along x; the stretches along y and z stay 1.
        UniaxialStrain = "uniaxial-strain" {
            /// What the curve measures the stretch by.
            measure: StretchMeasure = default("'green-lagrange'"),
            /// Points [time, value], times increasing.
            curve: At<TimePoints<Number>> = required,
        }
        /// The stretch along x; that along z stays 1, and that along y follows so that no stress acts there.
        PlaneStrainTension = "plane-strain-tension" {
            /// What the curve measures the stretch by.
            measure: StretchMeasure = default("'green-lagrange'"),
            /// Points [time, value], times increasing.
            curve: At<TimePoints<Number>> = required,
        }
        /// The shear γ: planes y = constant slide along x.
        SimpleShear = "simple-shear" {
            /// What the curve measures.
            measure: ShearMeasure = default("'shear'"),
            /// Points [time, value], times increasing.
            curve: At<TimePoints<Number>> = required,
        }
        /// All of F, in straight lines from row to row.
        DeformationGradient = "deformation-gradient" {
            /// Rows of F with time.
            curve: GradientRows = required,
        }
    }
}

deck_choice! { StretchMeasure {
    "green-lagrange" => StretchMeasure::GreenLagrange, "½ (λ² − 1), above -0.5";
    "stretch" => StretchMeasure::Stretch, "λ, above 0";
    "logarithmic" => StretchMeasure::Logarithmic, "ln λ";
} }

/// The measure of simple shear.
#[derive(Clone, Copy, Debug)]
pub struct ShearMeasure;

deck_choice! { ShearMeasure {
    "shear" => ShearMeasure, "γ";
} }

deck_table! {
    /// A panel of point.png and point.svg.
    pub struct PlotTable {
        /// Column of point.csv along the horizontal axis.
        x: Column = default("'driven'"),
        /// Columns along the vertical axis, all of one kind: stresses, energies, pure numbers, times or temperatures.
        y: Vec<At<Column>> = required,
    }
}

impl FromDeck for Column {
    fn schema() -> Schema {
        Schema::Text("a column of point.csv, such as `driven`, `F11`, `T12`, `E11` or `equivalent_plastic_strain`")
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let name = String::decode(node, decoder)?;
        let found = Self::all().into_iter().find(|column| column.name() == name);
        if found.is_none() {
            let names: Vec<String> = Self::all().iter().map(|column| column.name()).collect();
            let label = match nearest(&name, names.iter().map(String::as_str)) {
                Some(similar) => format!("did you mean \"{similar}\"?"),
                None => "unknown".to_owned(),
            };
            let message = format!("`{}`: point.csv has no column \"{name}\"", decoder.place());
            let help = "the columns are time, driven, F11 to F33, the stresses T, R, S and the strains E, Ep, Es, Ed (each \
                        with 11 22 33 12 13 23), equivalent_plastic_strain, hardening_index, loading_index, dissipation, internal_energy, \
                        det_Cp, temperature";
            decoder.report(Diagnostic::error(message).at(node.span, label).help(help));
        }
        found
    }
}

/// A deformation gradient at a time.
#[derive(Clone, Debug)]
pub struct GradientRow {
    /// The time, s.
    pub time: f64,
    /// F.
    pub gradient: Tensor<f64>,
}

/// Deformation gradients at increasing times, the first of them I.
#[derive(Clone, Debug)]
pub struct GradientRows(pub Vec<GradientRow>);

impl FromDeck for GradientRows {
    fn schema() -> Schema {
        let row = "[time (s), F11, F12, F13, F21, F22, F23, F31, F32, F33], times increasing, the first row that of the \
                   undeformed state";
        Schema::Rows(row, 10)
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        const ROW: &str = "[time, F11, F12, F13, F21, F22, F23, F31, F32, F33]";
        let Value::List(list) = &node.value else {
            decoder.wrong_type(node, &format!("a list of rows {ROW}"));
            return None;
        };
        let mut rows: Vec<GradientRow> = Vec::new();
        let mut is_good = true;
        for entry in list {
            match gradient_row(entry, rows.last(), ROW, decoder) {
                Some(row) => rows.push(row),
                None => is_good = false,
            }
        }
        if is_good && rows.len() < 2 {
            let message = format!("`{}` needs two rows at least", decoder.place());
            decoder.report(Diagnostic::error(message).at(node.span, format!("rows {ROW}")));
            return None;
        }
        let identity = Tensor::<f64>::identity();
        let distance = |row: &GradientRow| (row.gradient - identity).norm_squared().sqrt();
        let largest = rows.iter().map(distance).fold(0.0, f64::max);
        if let (true, Some(first)) = (is_good, rows.first_mut())
            && first.gradient != identity
        {
            if distance(first) > NEGLIGIBLE * largest {
                let message =
                    format!("a row of `{}` must be the undeformed state, for it is the first", decoder.place());
                let label = "1, 0, 0, 0, 1, 0, 0, 0, 1 is needed";
                decoder.report(Diagnostic::error(message).at(list[0].span, label));
                return None;
            }
            let given = format!("F11 = {:?} to F33 = {:?}", first.gradient.at(0, 0), first.gradient.at(2, 2));
            let warning = begins_with(&decoder.place(), &given, "the undeformed state");
            decoder.report(warning.at(list[0].span, "the first row"));
            first.gradient = identity;
        }
        is_good.then_some(Self(rows))
    }
}

fn gradient_row(node: &Node, last: Option<&GradientRow>, wanted: &str, decoder: &mut Decoder) -> Option<GradientRow> {
    let fault = |message: &str, label: String, decoder: &mut Decoder| {
        let message = format!("a row of `{}` {message}", decoder.place());
        decoder.report(Diagnostic::error(message).at(node.span, label));
        None
    };
    let Value::List(cells) = &node.value else {
        return fault("is no list", format!("{wanted} is needed"), decoder);
    };
    let Some((time, components)) = cells.split_first().filter(|(_, components)| components.len() == 9) else {
        return fault(&format!("has {} numbers, not 10", cells.len()), format!("{wanted} is needed"), decoder);
    };
    let time = Quantity::<Time>::decode(time, decoder);
    let components: Vec<Option<f64>> =
        components.iter().map(|cell| Quantity::<Number>::decode(cell, decoder).map(|number| number.value)).collect();
    let components: Vec<f64> = components.into_iter().collect::<Option<_>>()?;
    let (time, gradient) =
        (time?.value, Tensor::from_rows(std::array::from_fn(|i| std::array::from_fn(|j| components[3 * i + j]))));
    match last {
        Some(last) if time <= last.time => {
            fault("is not later than the one before", format!("{time:?} s is not after {:?} s", last.time), decoder)
        }
        _ if !(gradient.determinant() > 0.0 && gradient.determinant().is_finite()) => {
            fault("deforms no body", format!("det F = {:.4e} is not a number above 0", gradient.determinant()), decoder)
        }
        _ => Some(GradientRow { time, gradient }),
    }
}

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
