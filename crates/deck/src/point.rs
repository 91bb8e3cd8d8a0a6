//! The deck of `estar point`: materials along a path, without a mesh.

use crate::decoder::{At, Decoder, FromDeck};
use crate::diagnostics::{Diagnostic, nearest};
use crate::macros::{deck_choice, deck_table, deck_variants};
use crate::names::{MaterialName, Materials};
use crate::point_column::Column;
use crate::schema::Schema;
use crate::tree::{Node, Value};
use crate::values::{Count, NEGLIGIBLE, Number, Quantity, Time, TimePoints, begins_with};
use estar_material::point::StretchMeasure;
use estar_material::{MaterialModel, ObjectiveRate};
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
