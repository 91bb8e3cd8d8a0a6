//! What is done with every element whose volume change is shared.

/// What is done with every element.
#[derive(Clone, Copy)]
pub(crate) enum Task {
    /// Adds V, v, v at mid-step and its change to the rows.
    AddVolumes { time_step: f64 },
    /// Takes J̄ and Δt θ̄ from the averages of the nodes.
    TakeVolumes,
    /// Adds v σ and v to the rows.
    AddStresses,
    /// Takes σ̄ from the averages of the nodes and its forces from the rows.
    TakeStresses,
}
