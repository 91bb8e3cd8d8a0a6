//! `[time] quasi_static`: what makes an explicit run of a slow process short enough, and keeps inertia out of it.
//!
//! A process is slow when waves run through the body many times while it lasts, so that the body is near equilibrium all the
//! time. As long as the material knows no rate, only that number counts and not the time itself: mass is scaled until the
//! process lasts the chosen number of passes. Whether inertia stayed out of it shows in kinetic over internal energy.

use crate::deck::Deck;
use crate::diagnostics::{Diagnostic, Diagnostics};
use estar_mesh::Mesh;
use estar_solver::model::Part;

/// Kinetic over internal energy, from a tenth of the time on, above which practice doubts that a process is quasi-static.
pub const MOST_KINETIC: f64 = 0.05;

/// What was chosen for a quasi-static process.
#[derive(Clone, Copy, Debug)]
pub struct QuasiStatic {
    /// Factor on the mass of every element.
    pub mass_factor: f64,
    /// α of the damping −α m v, 1/s.
    pub mass_damping: f64,
    /// Passes of a wave through the longest side of the body while the process lasts.
    pub transits: f64,
}

impl QuasiStatic {
    /// The choice for a deck that asks for one.
    pub fn of(deck: &Deck, mesh: &Mesh, parts: &[Part], diagnostics: &mut Diagnostics) -> Option<Self> {
        let wanted = deck.time.quasi_static.as_ref()?;
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
        let [low, high] = mesh.extent();
        let length = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        // c = √(E/ρ), of the slowest material
        let speed = |part: &Part| {
            let elasticity = part.material.elasticity();
            (elasticity.young_modulus() / elasticity.density()).sqrt()
        };
        let speed = parts.iter().map(speed).fold(f64::INFINITY, f64::min);
        let own_transits = deck.time.end.value * speed / length;
        if own_transits < wanted.transits.value {
            let message = format!(
                "the process is too fast for `time.quasi_static`: a wave passes through the body {own_transits:.3} times, not {}",
                wanted.transits.value
            );
            let slower = deck.time.end.value * wanted.transits.value / own_transits;
            let help = format!(
                "a later `time.end`, of {slower:.3e} s or more with its curves, costs no step more: mass is scaled; or fewer `transits`"
            );
            diagnostics.push(Diagnostic::error(message).at(wanted.span, "this asks for a slow process").help(help));
        }
        // with f times the mass waves are √f times slower
        let mass_factor = (own_transits / wanted.transits.value).powi(2);
        if !mass_factor.is_finite() {
            let message = "no mass is great enough for so slow a process";
            diagnostics.push(Diagnostic::error(message).at(wanted.span, "more `transits` or an earlier `time.end`"));
        }
        // α = 2 ζ ω with ω = π c/(2 L) of a bar that is held at one end
        let slowed = speed / mass_factor.sqrt();
        let mass_damping = 2.0 * wanted.damping.value * std::f64::consts::FRAC_PI_2 * slowed / length;
        Some(Self { mass_factor, mass_damping, transits: wanted.transits.value })
    }
}
