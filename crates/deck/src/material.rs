//! `[material.NAME]`.

use crate::decoder::{Decoder, FromDeck};
use crate::diagnostics::{Diagnostic, Span, listed};
use crate::hardening::HardeningLaw;
use crate::macros::{deck_choice, deck_table, deck_variants};
use crate::material_plausibility;
use crate::schema::Schema;
use crate::tree::Node;
use crate::values::{
    Angle, Density, NotNegative, PoissonRatio as PoissonRatioBound, Positive, Quantity, Share, SpecificHeat, Stress,
    Temperature,
};
use estar_material::{
    AdiabaticHeating, ClosestPoint, EStar, EStarTotal, ElasticConstant, ElasticEnergy, FlowRule, FlowStart,
    GreenNaghdi, Hardening, Hencky, IsotropicElasticity, IsotropicHardening, JohnsonCook, KinematicHardening,
    MaterialModel, ObjectiveRate, PlasticMetric,
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
        /// Specific heat c; needed by the law `johnson-cook`, whose flow heats.
        specific_heat: Quantity<Positive<SpecificHeat>> = optional,
        /// Share of the plastic dissipation that heats, of Taylor and Quinney; 0.9 unless given. For `johnson-cook`. In `e-star` the
        /// Cauchy stress yields, which heats J times as much as the Kirchhoff stress of `hencky` and of codes that yield in it.
        taylor_quinney: Quantity<Share> = optional,
        /// Temperature at time 0; the law's `reference_temperature` unless given. For `johnson-cook`.
        initial_temperature: Quantity<NotNegative<Temperature>> = optional,
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
            hardening: HardeningLaw = required,
            /// Kinematic hardening; off unless given. `update = "box-rate"` only.
            kinematic: KinematicHardening = optional,
        }
        /// The Lagrangian theory of Green and Naghdi, for comparison; the second Piola-Kirchhoff stress yields.
        GreenNaghdi = "green-naghdi" {
            /// The yield surface.
            yield_surface: YieldSurface = default("{ kind = 'von-mises' }"),
            /// Isotropic hardening; any law but `johnson-cook`.
            hardening: HardeningLaw = required,
        }
        /// Hencky hyperelasticity (logarithmic strain) with return mapping in principal values; Kirchhoff stress yields.
        Hencky = "hencky" {
            /// The yield surface.
            yield_surface: PrincipalSurface = default("{ kind = 'von-mises' }"),
            /// Isotropic hardening; of the surfaces `von-mises` and `rankine`, the others are perfectly plastic.
            hardening: HardeningLaw = optional,
        }
        /// Hyperelasticity with a flow rule for the plastic metric C_p, to compare the rules of the literature.
        PlasticMetric = "plastic-metric" {
            /// The flow rule. A run needs one that keeps C_p symmetric with det C_p = 1; `estar point` takes all.
            flow_rule: FlowRule = required,
            /// The elastic energy.
            energy: ElasticEnergy = default("'hencky'"),
            /// The yield surface.
            yield_surface: YieldSurface = default("{ kind = 'von-mises' }"),
            /// Isotropic hardening; any law but `johnson-cook`.
            hardening: HardeningLaw = required,
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
        /// A cone through the outer edges of that of Mohr and Coulomb: soils, rock, concrete.
        DruckerPrager = "drucker-prager" {
            /// Friction angle, between 0 and 90 deg.
            friction_angle: Quantity<Positive<Angle>> = required,
            /// Cohesion.
            cohesion: Quantity<Positive<Stress>> = required,
            /// Dilatancy angle, from 0 to `friction_angle`; that one, associated flow, unless given.
            dilatancy_angle: Quantity<NotNegative<Angle>> = optional,
        }
        /// Shear strength that grows with the pressure: soils, rock. Associated flow.
        MohrCoulomb = "mohr-coulomb" {
            /// Friction angle, between 0 and 90 deg.
            friction_angle: Quantity<Positive<Angle>> = required,
            /// Cohesion.
            cohesion: Quantity<Positive<Stress>> = required,
        }
    }
}

impl FromDeck for MaterialModel {
    fn schema() -> Schema {
        MaterialTable::schema()
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        let table = MaterialTable::decode(node, decoder)?;
        let elasticity = elasticity(&table, node, decoder);
        let mut reader = MaterialReader { node, decoder };
        reader.check_heating(&table);
        let elasticity = elasticity?;
        material_plausibility::check(node, &elasticity, table.theory.first_yield_stress(), reader.decoder);
        Some(match &table.theory {
            Theory::Elastic { rate } => Self::hypoelastic(elasticity, *rate),
            Theory::Hencky { yield_surface, hardening } => {
                return reader.hencky(&table, elasticity, yield_surface, hardening.as_ref());
            }
            Theory::PlasticMetric { flow_rule, energy, hardening, .. } => {
                PlasticMetric::new(elasticity, reader.isotropic(hardening)?, *energy, *flow_rule).into()
            }
            Theory::GreenNaghdi { hardening, .. } => GreenNaghdi::new(elasticity, reader.isotropic(hardening)?).into(),
            Theory::EStar { update: Update::BoxRate, hardening, kinematic, .. } => match hardening {
                HardeningLaw::Isotropic(law) => {
                    Self::e_star_box_rate(elasticity, law.clone(), kinematic.unwrap_or(KinematicHardening::NONE))
                }
                HardeningLaw::JohnsonCook(law) => {
                    reader.without_kinematic(kinematic.as_ref(), "the law \"johnson-cook\"", "another law")?;
                    EStar::new(elasticity, reader.heated(law, &table, &elasticity)?, ()).into()
                }
            },
            Theory::EStar { update: Update::Total, hardening, kinematic, .. } => {
                reader.without_kinematic(kinematic.as_ref(), "the total update", "update = \"box-rate\"")?;
                match hardening {
                    HardeningLaw::Isotropic(law) => EStarTotal::new(elasticity, law.clone()).into(),
                    HardeningLaw::JohnsonCook(law) => {
                        EStarTotal::new(elasticity, reader.heated(law, &table, &elasticity)?).into()
                    }
                }
            }
        })
    }
}

impl Theory {
    fn hardening(&self) -> Option<&HardeningLaw> {
        match self {
            Self::EStar { hardening, .. }
            | Self::GreenNaghdi { hardening, .. }
            | Self::PlasticMetric { hardening, .. } => Some(hardening),
            Self::Hencky { hardening, .. } => hardening.as_ref(),
            Self::Elastic { .. } => None,
        }
    }

    /// Flow stress before any flow, Pa, of a theory whose surface has one.
    fn first_yield_stress(&self) -> Option<f64> {
        self.hardening().map(|law| match law {
            HardeningLaw::Isotropic(law) => law.at(0.0_f64).stress,
            HardeningLaw::JohnsonCook(law) => {
                law.flow_stress(&FlowStart::new(0.0_f64, law.initial_memory(), 0.0), 0.0).stress
            }
        })
    }
}

/// Reads what the keys of a material give together.
struct MaterialReader<'a> {
    node: &'a Node,
    decoder: &'a mut Decoder,
}

impl MaterialReader<'_> {
    /// Where a key of the material stands, or the material.
    fn place_of(&self, key: &str) -> Span {
        let entry = self.node.value.entry(key);
        entry.map_or(self.node.span.beginning(), |entry| entry.key_span)
    }

    fn fault(&mut self, message: &str, key: &str, label: &str, help: &str) {
        let message = format!("`{}`: {message}", self.decoder.place());
        let diagnostic = Diagnostic::error(message).at(self.place_of(key), label.to_owned());
        self.decoder.report(diagnostic.help(help.to_owned()));
    }

    /// The keys of heating are for a law that heats.
    fn check_heating(&mut self, table: &MaterialTable) {
        if let Some(HardeningLaw::JohnsonCook(_)) = table.theory.hardening() {
            return;
        }
        for key in HEATING_KEYS {
            if self.node.value.entry(key).is_some() {
                let help = "leave it out, or take hardening = { law = \"johnson-cook\", ... }";
                self.fault(
                    &format!("`{key}` is of no use: the flow stress knows no temperature"),
                    key,
                    "this key",
                    help,
                );
            }
        }
    }

    /// A law that knows the plastic strain alone.
    fn isotropic(&mut self, law: &HardeningLaw) -> Option<IsotropicHardening> {
        match law {
            HardeningLaw::Isotropic(law) => Some(law.clone()),
            HardeningLaw::JohnsonCook(_) => {
                let message = "this theory has no law that knows rate and temperature";
                let help =
                    "the theories e-star and hencky (with the surface von-mises) have it; any other law would do";
                self.fault(message, "hardening", "johnson-cook", help);
                None
            }
        }
    }

    /// Nothing, if the centre of the yield surface does not move.
    fn without_kinematic(&mut self, kinematic: Option<&KinematicHardening>, what: &str, instead: &str) -> Option<()> {
        if !kinematic.is_some_and(KinematicHardening::is_active) {
            return Some(());
        }
        let help = format!("use {instead}, or leave `kinematic` out");
        self.fault(&format!("{what} has no kinematic hardening"), "kinematic", "kinematic hardening", &help);
        None
    }

    /// The law with the heating that the material gives.
    fn heated(
        &mut self,
        law: &JohnsonCook,
        table: &MaterialTable,
        elasticity: &IsotropicElasticity,
    ) -> Option<JohnsonCook> {
        let Some(specific_heat) = table.specific_heat else {
            let help = "such as specific_heat = \"460 J/(kg K)\"; taylor_quinney = 0.0 keeps the temperature as it is";
            self.fault("the law \"johnson-cook\" heats and needs `specific_heat`", "hardening", "this law", help);
            return None;
        };
        let temperatures = [
            ("initial_temperature", "initial_temperature", table.initial_temperature.map(|value| value.value)),
            ("hardening", "hardening.reference_temperature", Some(law.reference_temperature())),
        ];
        for (key, place, temperature) in temperatures {
            if let Some(temperature) = temperature.filter(|temperature| *temperature < COLDEST_USUAL) {
                let message = format!("`{}.{place}` is {temperature:?} K", self.decoder.place());
                let diagnostic = Diagnostic::warning(message).at(self.place_of(key), "very cold");
                self.decoder.report(diagnostic.help(format!("if degrees Celsius are meant: \"{temperature:?} degC\"")));
            }
        }
        let heating = AdiabaticHeating {
            specific_heat: specific_heat.value,
            taylor_quinney: table.taylor_quinney.map_or(TAYLOR_QUINNEY, |share| share.value),
            initial_temperature: table.initial_temperature.map_or(law.reference_temperature(), |value| value.value),
        };
        self.decoder.parameter(self.node, law.clone().with_heating(heating, elasticity))
    }

    fn hencky(
        &mut self,
        table: &MaterialTable,
        elasticity: IsotropicElasticity,
        surface: &PrincipalSurface,
        hardening: Option<&HardeningLaw>,
    ) -> Option<MaterialModel> {
        let surface = match surface {
            PrincipalSurface::VonMises {} | PrincipalSurface::Rankine {} => {
                let Some(hardening) = hardening else {
                    let help = "such as hardening = { law = \"perfect\", yield_stress = \"260 MPa\" }";
                    self.fault("`hardening` is missing", "theory", "this theory needs it", help);
                    return None;
                };
                return Some(match (surface, hardening) {
                    (PrincipalSurface::VonMises {}, HardeningLaw::JohnsonCook(law)) => {
                        Hencky::von_mises(elasticity, self.heated(law, table, &elasticity)?).into()
                    }
                    (PrincipalSurface::VonMises {}, HardeningLaw::Isotropic(law)) => {
                        Hencky::von_mises(elasticity, law.clone()).into()
                    }
                    (_, law) => Hencky::rankine(elasticity, self.isotropic(law)?).into(),
                });
            }
            PrincipalSurface::DruckerPrager { friction_angle, cohesion, dilatancy_angle } => {
                let dilatancy_angle = dilatancy_angle.unwrap_or_else(|| Quantity::new(friction_angle.value));
                ClosestPoint::drucker_prager(elasticity, friction_angle.value, cohesion.value, dilatancy_angle.value)
            }
            PrincipalSurface::MohrCoulomb { friction_angle, cohesion } => {
                ClosestPoint::mohr_coulomb(elasticity, friction_angle.value, cohesion.value)
            }
        };
        if hardening.is_some() {
            let help = "leave it out: `cohesion` and `friction_angle` say when it yields";
            self.fault("this yield surface is perfectly plastic", "hardening", "hardening", help);
            return None;
        }
        let node = self.node.value.entry("yield_surface").map_or(self.node, |entry| &entry.node);
        let surface = self.decoder.inside("yield_surface", |decoder| decoder.parameter(node, surface));
        surface.map(|surface| Hencky::closest_point(surface).into())
    }
}

/// The keys of a material that a law without temperature has no use for.
pub const HEATING_KEYS: [&str; 3] = ["specific_heat", "taylor_quinney", "initial_temperature"];

/// A temperature below this one, K, looks like one in degrees Celsius without its unit.
const COLDEST_USUAL: f64 = 150.0;

/// The share of the plastic dissipation that heats a metal, unless a deck says otherwise.
const TAYLOR_QUINNEY: f64 = 0.9;

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
