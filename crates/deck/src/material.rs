//! `[material.NAME]`.

use crate::decoder::{Decoder, FromDeck};
use crate::diagnostics::{Diagnostic, Span, listed};
use crate::macros::{deck_choice, deck_table, deck_variants};
use crate::material_plausibility;
use crate::schema::{Interval, QuantitySchema, Schema};
use crate::source::{TextError, read_text};
use crate::tree::Node;
use crate::units::Dimension;
use crate::values::{
    Angle, Density, Fraction, NotNegative, Number, PoissonRatio as PoissonRatioBound, Positive, Quantity, Rate, Share,
    SpecificHeat, Stress, Temperature, decode_pairs,
};
use estar_material::{
    AdiabaticHeating, ClosestPoint, EStar, EStarTotal, ElasticConstant, ElasticEnergy, FlowRule, FlowStart,
    GreenNaghdi, Hardening, Hencky, IsotropicElasticity, IsotropicHardening, JohnsonCook, JohnsonCookParameters,
    KinematicHardening, MaterialModel, ObjectiveRate, PlasticMetric,
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
        /// σ = (a + b ε^n) (1 + c ln(rate/reference_rate)) (1 − T^m), T = (temperature − reference_temperature)/(melting_temperature
        /// − reference_temperature); heated by its own flow, see `specific_heat`. Theories `e-star` and `hencky` (von-mises).
        JohnsonCook = "johnson-cook" {
            /// Stress at first yield.
            a: Quantity<Positive<Stress>> = required,
            /// Factor of the power of the strain.
            b: Quantity<NotNegative<Stress>> = required,
            /// Exponent of the strain.
            n: Quantity<Fraction> = required,
            /// Factor of the logarithm of the rate.
            c: Quantity<NotNegative<Number>> = required,
            /// Exponent of the temperature.
            m: Quantity<Positive<Number>> = required,
            /// Rate of plastic strain below which the rate has no effect.
            reference_rate: Quantity<Positive<Rate>> = required,
            /// Temperature below which the temperature has no effect.
            reference_temperature: Quantity<NotNegative<Temperature>> = required,
            /// Temperature from which on a millionth of the strength is left.
            melting_temperature: Quantity<Positive<Temperature>> = required,
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
        let quantity =
            |dimension| QuantitySchema { dimension: Some(dimension), interval: Interval::ALL, is_angle: false };
        Schema::Points(quantity(Dimension::NUMBER), quantity(Dimension::STRESS))
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        decode_pairs::<Number, Stress>(node, decoder, "[strain, stress]").map(Self)
    }
}

/// A hardening law of a deck.
#[derive(Clone, Debug)]
pub enum HardeningLaw {
    /// One that knows the plastic strain alone.
    Isotropic(IsotropicHardening),
    /// That of Johnson and Cook, not yet heated.
    JohnsonCook(JohnsonCook),
}

impl FromDeck for HardeningLaw {
    fn schema() -> Schema {
        HardeningTable::schema()
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        use IsotropicHardening as Law;
        let law = match HardeningTable::decode(node, decoder)? {
            HardeningTable::Perfect { yield_stress } => Law::perfect(yield_stress.value),
            HardeningTable::Linear { yield_stress, modulus } => Law::linear(yield_stress.value, modulus.value),
            HardeningTable::Voce { yield_stress, saturation_stress, saturation_exponent } => {
                Law::voce(yield_stress.value, saturation_stress.value, saturation_exponent.value)
            }
            HardeningTable::Saturation { yield_stress, saturation_stress, saturation_exponent, modulus } => {
                Law::saturation(yield_stress.value, saturation_stress.value, saturation_exponent.value, modulus.value)
            }
            HardeningTable::Ludwik { yield_stress, coefficient, exponent } => {
                Law::ludwik(yield_stress.value, coefficient.value, exponent.value)
            }
            HardeningTable::Swift { coefficient, initial_strain, exponent } => {
                Law::swift(coefficient.value, initial_strain.value, exponent.value)
            }
            HardeningTable::Tabulated { points, file } => {
                let points = table(points, file, node, decoder)?;
                Law::tabulated(&points)
            }
            HardeningTable::JohnsonCook {
                a,
                b,
                n,
                c,
                m,
                reference_rate,
                reference_temperature,
                melting_temperature,
            } => {
                let law = JohnsonCook::new(JohnsonCookParameters {
                    a: a.value,
                    b: b.value,
                    n: n.value,
                    c: c.value,
                    m: m.value,
                    reference_rate: reference_rate.value,
                    reference_temperature: reference_temperature.value,
                    melting_temperature: melting_temperature.value,
                });
                return decoder.parameter(node, law).map(Self::JohnsonCook);
            }
        };
        decoder.parameter(node, law).map(Self::Isotropic)
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
            let span = node.value.entry("file").map_or(node.span, |entry| entry.node.span);
            read_table(&decoder.file(&file), decoder)
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

fn read_table(path: &std::path::Path, decoder: &mut Decoder) -> Result<Vec<[f64; 2]>, String> {
    let text = read_text(path).map_err(|error| {
        decoder.unreadable_count += usize::from(matches!(error, TextError::Unreadable { .. }));
        error.to_string()
    })?;
    let mut points = Vec::new();
    let mut is_first = true;
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let cells: Vec<Option<f64>> = line.split([',', ';']).map(|cell| cell.trim().parse().ok()).collect();
        match cells[..] {
            [Some(strain), Some(stress)] => points.push([strain, stress]),
            // one head line
            _ if is_first && cells.iter().all(Option::is_none) => {}
            _ => return Err(format!("line {} of {} is not two numbers", index + 1, path.display())),
        }
        is_first = false;
    }
    decoder.texts.push(text);
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
