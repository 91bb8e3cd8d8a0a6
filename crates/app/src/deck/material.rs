//! `[material.NAME]`.

use super::decoder::{Decoder, FromDeck};
use super::macros::{deck_choice, deck_table, deck_variants};
use super::schema::{QuantitySchema, Schema};
use super::tree::{Node, Value};
use super::units::Dimension;
use super::values::{
    Density, Fraction, NotNegative, Number, PoissonRatio as PoissonRatioBound, Positive, Quantity, Stress, decode_pairs,
};
use crate::diagnostics::{Diagnostic, listed};
use estar_material::{
    ElasticConstant, ElasticEnergy, FlowRule, HenckySurface, IsotropicElasticity, IsotropicHardening,
    KinematicHardening, MaterialModel, ObjectiveRate,
};

deck_table! {
    /// A material, under a name of your own. Its elasticity is given by any two of `young_modulus`, `poisson_ratio`,
    /// `bulk_modulus`, `shear_modulus` and `lame_lambda`.
    pub struct MaterialTable {
        /// Mass per undeformed volume.
        density: Quantity<Positive<Density>> = required,
        /// Young's modulus E.
        young_modulus: Quantity<Positive<Stress>> = optional,
        /// Poisson's ratio ν.
        poisson_ratio: Quantity<PoissonRatioBound> = optional,
        /// Bulk modulus k.
        bulk_modulus: Quantity<Positive<Stress>> = optional,
        /// Shear modulus μ.
        shear_modulus: Quantity<Positive<Stress>> = optional,
        /// First Lamé constant λ.
        lame_lambda: Quantity<Stress> = optional,
        /// The theory, with its own keys.
        theory: Theory = flatten,
    }
}

deck_variants! {
    /// The constitutive theory.
    pub enum Theory by theory {
        /// Finite elastoplasticity with von Mises yielding in the rotated (box) frame.
        EStar = "e-star" {
            /// How the stress follows from the motion.
            update: Update = default("'box-rate'"),
            /// The yield surface.
            yield_surface: YieldSurface = default("{ kind = 'von-mises' }"),
            /// Isotropic hardening.
            hardening: IsotropicHardening = required,
            /// Kinematic hardening; off unless given. `update = "box-rate"` only.
            kinematic: KinematicHardening = optional,
        }
        /// The Lagrangian theory of Green and Naghdi, for comparison; the second Piola-Kirchhoff stress yields.
        GreenNaghdi = "green-naghdi" {
            /// The yield surface.
            yield_surface: YieldSurface = default("{ kind = 'von-mises' }"),
            /// Isotropic hardening.
            hardening: IsotropicHardening = required,
        }
        /// Hencky hyperelasticity (logarithmic strain) with return mapping in principal values; Kirchhoff stress yields.
        Hencky = "hencky" {
            /// The yield surface.
            yield_surface: PrincipalSurface = default("{ kind = 'von-mises' }"),
            /// Isotropic hardening.
            hardening: IsotropicHardening = required,
        }
        /// Hyperelasticity with a flow rule for the plastic metric C_p, to compare the rules of the literature.
        PlasticMetric = "plastic-metric" {
            /// The flow rule. A run needs one that keeps C_p symmetric with det C_p = 1; `estar point` takes all.
            flow_rule: FlowRule = required,
            /// The elastic energy.
            energy: ElasticEnergy = default("'hencky'"),
            /// The yield surface.
            yield_surface: YieldSurface = default("{ kind = 'von-mises' }"),
            /// Isotropic hardening.
            hardening: IsotropicHardening = required,
        }
        /// Isotropic elasticity in rate form, without yielding.
        Elastic = "elastic" {
            /// The objective rate of the Cauchy stress.
            rate: ObjectiveRate = default("'box'"),
        }
    }
}

/// How the stress of the E* theory follows from the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Update {
    /// By the box rate of the stress.
    BoxRate,
    /// By the total elastic strain.
    Total,
}

deck_choice! { Update {
    "box-rate" => Update::BoxRate, "hypoelastic, by the rate of the rotated stress";
    "total" => Update::Total, "from the total elastic strain E*; isotropic hardening only";
} }

deck_choice! { ObjectiveRate {
    "box" => ObjectiveRate::Box, "Green-McInnis, Green-Naghdi: that of the rotated stress";
    "jaumann" => ObjectiveRate::Jaumann, "by the spin W";
    "logarithmic" => ObjectiveRate::Logarithmic, "by the logarithmic spin: the stress is a function of ln V";
    "truesdell" => ObjectiveRate::Truesdell, "`estar point` only";
    "upper-convected" => ObjectiveRate::UpperConvected, "Oldroyd; `estar point` only";
    "lower-convected" => ObjectiveRate::LowerConvected, "Cotter-Rivlin; `estar point` only";
} }

deck_choice! { FlowRule {
    "simo-miehe" => FlowRule::SimoMiehe, "Simo & Miehe 1992";
    "miehe" => FlowRule::Miehe, "Miehe 1995";
    "lion" => FlowRule::Lion, "Lion 1997";
    "simo-hughes" => FlowRule::SimoHughes, "Simo & Hughes 1998; loses det C_p = 1";
    "helm" => FlowRule::Helm, "Helm 2001";
    "grandi-stefanelli" => FlowRule::GrandiStefanelli, "Grandi & Stefanelli 2015";
    "frobenius-normal" => FlowRule::FrobeniusNormal, "normal in the reference configuration; loses the symmetry of C_p";
} }

deck_choice! { ElasticEnergy {
    "hencky" => ElasticEnergy::Hencky, "quadratic in the logarithmic strain";
    "neo-hooke" => ElasticEnergy::NeoHooke, "linear in the trace of b_e";
} }

deck_variants! {
    /// Which stresses yield.
    pub enum YieldSurface by kind {
        /// The second invariant of the deviator.
        VonMises = "von-mises" {}
    }
}

deck_variants! {
    /// Which principal stresses yield.
    pub enum PrincipalSurface by kind {
        /// The second invariant of the deviator.
        VonMises = "von-mises" {}
        /// The largest principal stress: materials that break in tension.
        Rankine = "rankine" {}
    }
}

deck_variants! {
    /// The flow stress σ as a function of the equivalent plastic strain ε.
    pub enum HardeningTable by law {
        /// σ = yield_stress.
        Perfect = "perfect" {
            /// Stress at first yield.
            yield_stress: Quantity<Positive<Stress>> = required,
        }
        /// σ = yield_stress + modulus ε.
        Linear = "linear" {
            /// Stress at first yield.
            yield_stress: Quantity<Positive<Stress>> = required,
            /// Slope of the flow stress.
            modulus: Quantity<NotNegative<Stress>> = required,
        }
        /// σ = yield_stress + (saturation_stress − yield_stress)(1 − exp(−saturation_exponent ε)).
        Voce = "voce" {
            /// Stress at first yield.
            yield_stress: Quantity<Positive<Stress>> = required,
            /// Stress that is approached, not below `yield_stress`.
            saturation_stress: Quantity<Positive<Stress>> = required,
            /// How fast it is approached.
            saturation_exponent: Quantity<NotNegative<Number>> = required,
        }
        /// As `voce`, plus modulus ε.
        Saturation = "saturation" {
            /// Stress at first yield.
            yield_stress: Quantity<Positive<Stress>> = required,
            /// Stress that is approached, not below `yield_stress`.
            saturation_stress: Quantity<Positive<Stress>> = required,
            /// How fast it is approached.
            saturation_exponent: Quantity<NotNegative<Number>> = required,
            /// Slope that remains.
            modulus: Quantity<NotNegative<Stress>> = required,
        }
        /// σ = yield_stress + coefficient ε^exponent.
        Ludwik = "ludwik" {
            /// Stress at first yield.
            yield_stress: Quantity<Positive<Stress>> = required,
            /// Factor of the power.
            coefficient: Quantity<NotNegative<Stress>> = required,
            /// Exponent.
            exponent: Quantity<Fraction> = required,
        }
        /// σ = coefficient (initial_strain + ε)^exponent.
        Swift = "swift" {
            /// Factor of the power.
            coefficient: Quantity<Positive<Stress>> = required,
            /// Strain that precedes the first yield, 1e-12 or more.
            initial_strain: Quantity<Positive<Number>> = required,
            /// Exponent.
            exponent: Quantity<Fraction> = required,
        }
        /// Straight between points, constant beyond the last; either `points` or `file`.
        Tabulated = "tabulated" {
            /// The points [strain, stress]; strains increase from 0, stresses do not fall.
            points: TablePoints = optional,
            /// A CSV file of `strain,stress` rows in SI units, relative to the deck; a head line is skipped.
            file: String = optional,
        }
    }
}

deck_variants! {
    /// The motion of the yield surface's centre.
    pub enum KinematicTable by law {
        /// Linear: rate of the back stress ⅔ modulus D_p.
        Prager = "prager" {
            /// Modulus.
            modulus: Quantity<NotNegative<Stress>> = required,
        }
        /// With dynamic recovery: saturates at the uniaxial back stress modulus/recovery.
        ArmstrongFrederick = "armstrong-frederick" {
            /// Modulus.
            modulus: Quantity<NotNegative<Stress>> = required,
            /// Recovery.
            recovery: Quantity<NotNegative<Number>> = required,
        }
    }
}

/// Points [strain, stress].
#[derive(Clone, Debug)]
pub struct TablePoints(Vec<[f64; 2]>);

impl FromDeck for TablePoints {
    fn schema() -> Schema {
        let quantity = |dimension| QuantitySchema { dimension: Some(dimension), bound: None };
        Schema::Points(quantity(Dimension::NUMBER), quantity(Dimension::STRESS))
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        decode_pairs::<Number, Stress>(node, decoder, "[strain, stress]").map(Self)
    }
}

impl FromDeck for IsotropicHardening {
    fn schema() -> Schema {
        HardeningTable::schema()
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let law = match HardeningTable::decode(node, decoder)? {
            HardeningTable::Perfect { yield_stress } => Self::perfect(yield_stress.value),
            HardeningTable::Linear { yield_stress, modulus } => Self::linear(yield_stress.value, modulus.value),
            HardeningTable::Voce { yield_stress, saturation_stress, saturation_exponent } => {
                Self::voce(yield_stress.value, saturation_stress.value, saturation_exponent.value)
            }
            HardeningTable::Saturation { yield_stress, saturation_stress, saturation_exponent, modulus } => {
                Self::saturation(yield_stress.value, saturation_stress.value, saturation_exponent.value, modulus.value)
            }
            HardeningTable::Ludwik { yield_stress, coefficient, exponent } => {
                Self::ludwik(yield_stress.value, coefficient.value, exponent.value)
            }
            HardeningTable::Swift { coefficient, initial_strain, exponent } => {
                Self::swift(coefficient.value, initial_strain.value, exponent.value)
            }
            HardeningTable::Tabulated { points, file } => {
                let points = table(points, file, node, decoder)?;
                Self::tabulated(&points)
            }
        };
        decoder.parameter(node, law)
    }
}

/// The points of a tabulated law, from the deck or from a file.
fn table(
    points: Option<TablePoints>,
    file: Option<String>,
    node: &Node,
    decoder: &mut Decoder,
) -> Option<Vec<[f64; 2]>> {
    match (points, file) {
        (Some(points), None) => Some(points.0),
        (None, Some(file)) => {
            let span = match &node.value {
                Value::Table(table) => table.get("file").map_or(node.span, |entry| entry.node.span),
                _ => node.span,
            };
            read_table(&decoder.file(&file))
                .map_err(|fault| {
                    let message = format!("`{}.file` cannot be used: {fault}", decoder.place());
                    decoder.report(Diagnostic::error(message).at(span, "this file").help("one `strain,stress` a line"));
                })
                .ok()
        }
        (given, _) => {
            let fault = if given.is_some() { "has both `points` and `file`" } else { "lacks `points` or `file`" };
            let message = format!("`{}` {fault}", decoder.place());
            decoder.report(Diagnostic::error(message).at(node.span, "one of the two is needed"));
            None
        }
    }
}

fn read_table(path: &std::path::Path) -> Result<Vec<[f64; 2]>, String> {
    let text = super::source::read_text(path).map_err(|error| error.to_string())?;
    let mut points = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let cells: Vec<Option<f64>> = line.split([',', ';']).map(|cell| cell.trim().parse().ok()).collect();
        match cells[..] {
            [Some(strain), Some(stress)] => points.push([strain, stress]),
            _ if points.is_empty() && cells.iter().all(Option::is_none) => {}
            _ => return Err(format!("line {} is not two numbers", index + 1)),
        }
    }
    Ok(points)
}

impl FromDeck for KinematicHardening {
    fn schema() -> Schema {
        KinematicTable::schema()
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let law = match KinematicTable::decode(node, decoder)? {
            KinematicTable::Prager { modulus } => Self::prager(modulus.value),
            KinematicTable::ArmstrongFrederick { modulus, recovery } => {
                Self::armstrong_frederick(modulus.value, recovery.value)
            }
        };
        decoder.parameter(node, law)
    }
}

impl FromDeck for MaterialModel {
    fn schema() -> Schema {
        MaterialTable::schema()
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let table = MaterialTable::decode(node, decoder)?;
        let elasticity = elasticity(&table, node, decoder);
        match table.theory {
            Theory::Elastic { rate } => Some(Self::hypoelastic(elasticity?, rate)),
            Theory::Hencky { yield_surface, hardening } => {
                let surface = match yield_surface {
                    PrincipalSurface::VonMises {} => HenckySurface::VonMises,
                    PrincipalSurface::Rankine {} => HenckySurface::Rankine,
                };
                Some(Self::hencky(elasticity?, hardening, surface))
            }
            Theory::PlasticMetric { flow_rule, energy, hardening, .. } => {
                Some(Self::plastic_metric(elasticity?, hardening, energy, flow_rule))
            }
            Theory::GreenNaghdi { hardening, .. } => Some(Self::green_naghdi(elasticity?, hardening)),
            Theory::EStar { update: Update::BoxRate, hardening, kinematic, .. } => {
                Some(Self::e_star_box_rate(elasticity?, hardening, kinematic.unwrap_or(KinematicHardening::NONE)))
            }
            Theory::EStar { update: Update::Total, kinematic: Some(law), .. } if law.is_active() => {
                let span = match &node.value {
                    Value::Table(table) => table.get("kinematic").map_or(node.span, |entry| entry.key_span),
                    _ => node.span,
                };
                let message = format!("`{}`: the total update has no kinematic hardening", decoder.place());
                let diagnostic = Diagnostic::error(message).at(span, "kinematic hardening");
                decoder.report(diagnostic.help("use update = \"box-rate\", or leave `kinematic` out"));
                None
            }
            Theory::EStar { update: Update::Total, hardening, .. } => Some(Self::e_star_total(elasticity?, hardening)),
        }
    }
}

fn elasticity(table: &MaterialTable, node: &Node, decoder: &mut Decoder) -> Option<IsotropicElasticity> {
    use ElasticConstant::{BulkModulus, LameLambda, PoissonRatio, ShearModulus, YoungModulus};
    let constants: Vec<ElasticConstant> = [
        table.young_modulus.map(|constant| YoungModulus(constant.value)),
        table.poisson_ratio.map(|constant| PoissonRatio(constant.value)),
        table.bulk_modulus.map(|constant| BulkModulus(constant.value)),
        table.shear_modulus.map(|constant| ShearModulus(constant.value)),
        table.lame_lambda.map(|constant| LameLambda(constant.value)),
    ]
    .into_iter()
    .flatten()
    .collect();
    if let [first, second] = constants[..] {
        return decoder.parameter(node, IsotropicElasticity::new(table.density.value, first, second));
    }
    let given = match &constants[..] {
        [] => "none".to_owned(),
        constants => listed(constants.iter().map(|constant| constant.name())),
    };
    let message = format!("`{}` needs two elastic constants, but has {given}", decoder.place());
    let all = "any two of young_modulus, poisson_ratio, bulk_modulus, shear_modulus, lame_lambda";
    decoder.report(Diagnostic::error(message).at(node.span, "here").help(all));
    None
}
