//! `[time] quasi_static`: what makes an explicit run of a slow process short enough, and keeps inertia out of it.
//!
//! A process is slow when the body vibrates many times while it lasts, also in its slowest natural vibration, so that it is near
//! equilibrium all the time. As long as the material knows no rate, only that number counts and not the time itself: mass is scaled
//! until the process lasts the chosen number of half periods. Whether inertia stayed out of it shows in kinetic over internal
//! energy, and whether damping did in its share of the external work.

use estar_deck::Deck;
use estar_deck::diagnostics::{Diagnostic, Diagnostics};
use estar_deck::settings::QuasiStaticTable;
use estar_mesh::Mesh;
use estar_solver::model::{Model, Part};
use estar_solver::{LaneLevel, NaturalFrequency, Simulation};

/// Kinetic over internal energy, from a tenth of the time on, above which practice doubts that a process is quasi-static.
pub const MOST_KINETIC: f64 = 0.05;
/// Share of the external work above which damping is no longer a small correction.
pub const MOST_DAMPING: f64 = 0.02;

/// What was chosen for a quasi-static process.
#[derive(Clone, Copy, Debug)]
pub struct QuasiStatic {
    /// Factor on the mass of every element.
    pub mass_factor: f64,
    /// α of the damping −α m v, 1/s.
    pub mass_damping: f64,
    /// Half periods of the slowest vibration while the process lasts.
    pub transits: f64,
    /// The lowest natural frequency of the body with its own mass, 1/s, and the steps that it took to find it; none where waves along the
    /// body set the pace.
    pub natural_frequency: Option<(f64, usize)>,
}

/// Reports what does not go together with a quasi-static process.
pub fn check(deck: &Deck, diagnostics: &mut Diagnostics) {
    if deck.time.quasi_static.is_none() {
        return;
    }
    if let Some(scaling) = &deck.time.mass_scaling
        && scaling.factor.value.value != 1.0
    {
        let diagnostic = Diagnostic::error("`time.quasi_static` chooses the factor of the mass scaling itself");
        diagnostics.push(diagnostic.at(scaling.factor.span, "a second factor").help("leave one of the two out"));
    }
    if deck.time.mass_damping.value > 0.0 {
        let diagnostic = Diagnostic::error("`time.quasi_static` chooses the damping itself");
        let help = "leave out `mass_damping`, and give `quasi_static.damping` if need be";
        diagnostics.push(diagnostic.at(deck.time.span, "`mass_damping` is in this table").help(help));
    }
    if let Some(first) = deck.initial_velocity.first() {
        let message = "a process of `time.quasi_static` begins at rest";
        let help = "its mass is scaled, and with it the energy of a velocity: leave one of the two out";
        diagnostics.push(Diagnostic::error(message).at(first.span, "a velocity at time 0").help(help));
    }
}

impl QuasiStatic {
    /// The choice for a model whose mass is not scaled yet; nothing after a fault has been reported.
    pub fn of(wanted: &QuasiStaticTable, mesh: &Mesh, model: &Model, diagnostics: &mut Diagnostics) -> Option<Self> {
        let (transits, end) = (wanted.transits.value, model.settings.end);
        let natural = natural_frequency(mesh, model);
        // a wave passes through a free bar in half a period of its slowest vibration
        let waves = 0.5 * slowest_wave(&model.parts) / longest_side(mesh);
        let (frequency, natural_frequency) = match natural {
            Some(NaturalFrequency::Found { frequency, steps }) => (frequency, Some((frequency, steps))),
            Some(NaturalFrequency::NotConverged { at_most, steps }) => {
                let reason = format!("the lowest natural frequency was not found in {steps} steps");
                warn_of_waves(wanted, &reason, diagnostics);
                (waves.min(at_most), None)
            }
            Some(NaturalFrequency::Mechanism) => {
                warn_of_waves(
                    wanted,
                    "the body can move in itself without any stiffness, as about a hinge",
                    diagnostics,
                );
                (waves, None)
            }
            // nothing can vibrate, or there is a fault that is told when the problem is run
            Some(NaturalFrequency::NothingFree) | None => (waves, None),
        };
        let own_transits = 2.0 * frequency * end;
        if own_transits < transits {
            let what = match natural_frequency {
                Some(_) => format!(
                    "it lasts {own_transits:.3} half periods of the slowest vibration ({frequency:.4e} Hz), not {transits}"
                ),
                None => format!("a wave passes through the body {own_transits:.3} times, not {transits}"),
            };
            let message = format!("the process is too fast for `time.quasi_static`: {what}");
            let slower = end * transits / own_transits;
            let help = format!(
                "a later `time.end`, of {slower:.3e} s or more with its curves, costs no step more: mass is scaled; or fewer `transits`"
            );
            diagnostics.push(Diagnostic::error(message).at(wanted.span, "this asks for a slow process").help(help));
            return None;
        }
        // with f times the mass everything is √f times slower
        let mass_factor = (own_transits / transits).powi(2);
        if !mass_factor.is_finite() {
            let message = "no mass is great enough for so slow a process";
            diagnostics.push(Diagnostic::error(message).at(wanted.span, "more `transits` or an earlier `time.end`"));
            return None;
        }
        // α = 2 ζ ω
        let slowed = std::f64::consts::TAU * frequency / mass_factor.sqrt();
        Some(Self { mass_factor, mass_damping: 2.0 * wanted.damping.value * slowed, transits, natural_frequency })
    }

    /// In words, for the head of a run.
    pub fn told(&self) -> String {
        let Self { mass_factor, mass_damping, transits, natural_frequency } = self;
        let pace = match natural_frequency {
            Some((frequency, steps)) => format!(
                "{transits} half periods of the lowest natural frequency, {frequency:.4e} Hz ({steps} steps to find it)"
            ),
            None => format!("{transits} passes of a wave"),
        };
        format!("quasi-static: {pace},\n             {mass_factor:.4e} times the mass, damping {mass_damping:.4e} 1/s")
    }
}

/// That of the body as it is held; none where the solver refuses the model.
fn natural_frequency(mesh: &Mesh, model: &Model) -> Option<NaturalFrequency> {
    let mut unscaled = model.clone();
    unscaled.settings.mass_scaling = None;
    Simulation::new(mesh, unscaled, LaneLevel::best()).ok().map(Simulation::natural_frequency)
}

fn warn_of_waves(wanted: &QuasiStaticTable, reason: &str, diagnostics: &mut Diagnostics) {
    let message = format!("{reason}: waves along the body set the pace of `time.quasi_static`");
    let help = "bodies that bend are slower than that: look at `kinetic_over_internal`, and give more `transits` if it is large";
    diagnostics.push(Diagnostic::warning(message).at(wanted.span, "this process").help(help));
}

/// c = √(E/ρ) of the slowest material, m/s.
fn slowest_wave(parts: &[Part]) -> f64 {
    let speed = |part: &Part| {
        let elasticity = part.material.elasticity();
        (elasticity.young_modulus() / elasticity.density()).sqrt()
    };
    parts.iter().map(speed).fold(f64::INFINITY, f64::min)
}

fn longest_side(mesh: &Mesh) -> f64 {
    let [low, high] = mesh.extent();
    (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max)
}
