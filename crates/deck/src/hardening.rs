//! `hardening` and `kinematic` of a material.

use crate::decoder::{Decoder, FromDeck};
use crate::diagnostics::Diagnostic;
use crate::macros::deck_variants;
use crate::schema::{Interval, QuantitySchema, Schema};
use crate::source::{TextError, read_text};
use crate::tree::Node;
use crate::units::Dimension;
use crate::values::{Fraction, NotNegative, Number, Positive, Quantity, Rate, Stress, Temperature, decode_pairs};
use estar_material::{IsotropicHardening, JohnsonCook, JohnsonCookParameters, KinematicHardening};

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
