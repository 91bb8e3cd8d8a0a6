//! Properties that no real solid has: usually one in another unit than it was meant to be. Each is a warning with the likely unit,
//! never an error.

use crate::decoder::Decoder;
use crate::diagnostics::{Diagnostic, Span};
use crate::format::short;
use crate::tree::{Node, Value};
use estar_material::IsotropicElasticity;

/// Densities of solids, kg/m³, from aerogel to osmium.
const DENSITIES: [f64; 2] = [1.0, 30_000.0];
/// Densities that are common, by which a unit is guessed.
const COMMON_DENSITIES: [f64; 2] = [100.0, 25_000.0];
/// Flow stress over Young's modulus: below that of pure single crystals, above that of polymers.
const YIELD_STRAINS: [f64; 2] = [1e-5, 0.3];
/// Such ratios are common, by which a unit is guessed.
const COMMON_YIELD_STRAINS: [f64; 2] = [1e-4, 0.1];
/// A solid of more than this density (kg/m³) in which sound is slower than this (m/s) would be a heavy jelly.
const HEAVY: f64 = 2500.0;
const SLOW_SOUND: f64 = 20.0;
/// No sound in a solid is faster, m/s.
const FAST_SOUND: f64 = 30_000.0;

/// Density, elasticity and first flow stress (Pa) of the material that stands in `node`.
pub fn check(node: &Node, elasticity: &IsotropicElasticity, yield_stress: Option<f64>, decoder: &mut Decoder) {
    let is_outside = |value: f64, [low, high]: [f64; 2]| value < low || value > high;
    let (density, young_modulus) = (elasticity.density(), elasticity.young_modulus());
    let mut warn = |key: &str, message: String, label: &str, help: Option<String>| {
        let message = format!("`{}`: {message}", decoder.place());
        decoder.report(Diagnostic::warning(message).at(span_of(node, key), label).help_if(help));
    };
    if is_outside(density, DENSITIES) {
        let units =
            [(1e-3, "g/cm^3 instead of g/mm^3"), (1e3, "g/cm^3"), (1e6, "g/mm^3"), (1e9, "kg/mm^3"), (1e12, "t/mm^3")];
        let guess = units.into_iter().find(|(factor, _)| !is_outside(density * factor, COMMON_DENSITIES));
        let help = guess.map(|(factor, unit)| format!("{unit} would make it {} kg/m^3", short(density * factor)));
        warn("density", format!("no solid has a density of {} kg/m^3", short(density)), "what unit is meant?", help);
    } else {
        let sound = (young_modulus / density).sqrt();
        let is_jelly = density > HEAVY && sound < SLOW_SOUND;
        if is_jelly || sound > FAST_SOUND {
            let message = format!(
                "sound would go at {} m/s through a density of {} kg/m^3 with Young's modulus {} Pa",
                short(sound),
                short(density),
                short(young_modulus)
            );
            let help = is_jelly.then(|| format!("if MPa are meant: \"{} MPa\"", short(young_modulus)));
            warn(elastic_key(node), message, "what unit is meant?", help);
            return;
        }
    }
    let Some(yield_stress) = yield_stress else { return };
    let ratio = yield_stress / young_modulus;
    if is_outside(ratio, YIELD_STRAINS) {
        let units = [(1e6, "MPa"), (1e9, "GPa")];
        let is_common = |factor: f64| !is_outside(ratio * factor, COMMON_YIELD_STRAINS);
        let stress = units.into_iter().find(|(factor, _)| is_common(*factor));
        let modulus = units.into_iter().find(|(factor, _)| is_common(factor.recip()));
        let help = match (stress, modulus) {
            (Some((_, unit)), _) => {
                Some(format!("if stresses in {unit} are meant, give them that unit, also in tables"))
            }
            (_, Some((_, unit))) => {
                Some(format!("if the modulus is meant in {unit}: \"{} {unit}\"", short(young_modulus)))
            }
            _ => None,
        };
        let message = format!(
            "it yields first at {} Pa, which is {} of Young's modulus, {} Pa",
            short(yield_stress),
            short(ratio),
            short(young_modulus)
        );
        let key = if node.value.entry("hardening").is_some() { "hardening" } else { "yield_surface" };
        warn(key, message, "what unit is meant?", help);
    }
}

/// Where a key of a material stands, or the material.
fn span_of(node: &Node, key: &str) -> Span {
    match node.value.entry(key).map(|entry| &entry.node) {
        Some(Node { value: Value::Table(_), .. }) | None => {
            node.value.entry(key).map_or(node.span.beginning(), |entry| entry.key_span)
        }
        Some(value) => value.span,
    }
}

/// The first elastic modulus that a material gives.
fn elastic_key(node: &Node) -> &'static str {
    let keys = ["young_modulus", "shear_modulus", "bulk_modulus", "lame_lambda"];
    keys.into_iter().find(|key| node.value.entry(key).is_some()).unwrap_or("young_modulus")
}
