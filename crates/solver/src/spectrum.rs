//! The operator of the assembled mesh of a simulation, and the stable time step that follows from it.

use crate::global_time_step::{UNDERESTIMATE, estimating_steps};
use crate::lanczos::{Lanczos, Operator};
use crate::patch_rows::NodalMotion;
use crate::simulation::Simulation;
use estar_element::element::ElementStep;

/// Accuracy to which the weight of damping is made to fit the first step, and the times that this is tried.
const FIT: f64 = 1e-3;
const MOST_FITS: usize = 50;

impl Simulation {
    /// M and K + 2C/Δt at t_n, with the damping of the step. The rows of the patches serve as rows of the operator, and hold no forces
    /// afterwards.
    pub(crate) fn linear_operator(&mut self, step: &ElementStep) -> Operator<'_> {
        let nodes = &self.nodes;
        let reference = self.mesh.coordinates();
        let motion = NodalMotion { reference, displacement: &nodes.displacement, velocity: &nodes.velocity };
        for block in &mut self.blocks {
            block.elements.find_tangents(motion, step);
        }
        let (blocks, rows, row_lists) = (&self.blocks, &mut self.patch_forces, &self.row_lists);
        Operator { mass: &nodes.mass, motion, blocks, rows, row_lists }
    }
}

impl Simulation {
    /// The stable time step at t_n that steps are taken from, s: that of the elements or, if larger, of the assembled mesh.
    pub(crate) fn stable_time_step(&self) -> f64 {
        let of_elements = self.elements.stable_time_step.value;
        self.global_time_step.as_ref().map_or(of_elements, |global| of_elements.max(global.stable_time_step()))
    }

    /// Estimates of the stable time step of the assembled mesh so far.
    pub fn estimate_count(&self) -> u64 {
        self.global_time_step.as_ref().map_or(0, |global| global.count)
    }

    /// The first estimate, which leaves no forces in the rows of the patches.
    pub(crate) fn begin_global_time_step(&mut self) {
        let Some(mut global) = self.global_time_step.take() else { return };
        let time_step = self.first_estimate(&mut global.lanczos);
        global.eigenvalue = 4.0 / (time_step * time_step);
        global.count = 1;
        self.global_time_step = Some(global);
        self.watch_elements();
    }

    /// A new estimate on the state of t_n, if it is time.
    pub(crate) fn renew_global_time_step(&mut self) {
        if !self.global_time_step.as_ref().is_some_and(|global| global.is_due(self.step)) {
            return;
        }
        let time_step = self.stable_time_step();
        let Some(mut global) = self.global_time_step.take() else { return };
        let estimate = self.estimated_time_step(&mut global.lanczos, time_step);
        global.eigenvalue = 4.0 / (estimate * estimate);
        (global.step, global.growth, global.decline) = (self.step, 0.0, 0.0);
        global.count += 1;
        self.global_time_step = Some(global);
        self.watch_elements();
    }

    /// The stable time step of the assembled mesh at t_n as `time_step = "power"` has it, s; none where that is not known for some of
    /// the elements.
    pub fn global_time_step(&mut self) -> Option<f64> {
        if !self.blocks.iter().all(|block| block.elements.has_linear_forces()) {
            return None;
        }
        let node_count = self.nodes.mass.len();
        let mut lanczos = Lanczos::new(node_count, estimating_steps(3 * node_count));
        Some(self.first_estimate(&mut lanczos))
    }

    /// The estimate where no earlier one tells with which step damping counts: the same over and over, from the bound of the elements
    /// on.
    fn first_estimate(&mut self, lanczos: &mut Lanczos) -> f64 {
        let mut time_step = self.elements.stable_time_step.value;
        for _ in 0..MOST_FITS {
            let estimate = self.estimated_time_step(lanczos, time_step);
            let has_grown = self.is_damped() && estimate > time_step * (1.0 + FIT);
            time_step = time_step.max(estimate);
            if !has_grown {
                break;
            }
        }
        time_step
    }

    /// The same without the allowance for what k steps of Lanczos' method miss, s: exact for a `k` that is large enough.
    pub fn exact_global_time_step(&mut self, k: usize) -> f64 {
        let mut lanczos = Lanczos::new(self.nodes.mass.len(), k);
        let mut time_step = self.elements.stable_time_step.value;
        for _ in 0..MOST_FITS {
            let fitted = 2.0 / self.largest_ritz_value(&mut lanczos, time_step).sqrt();
            let change = fitted / time_step - 1.0;
            time_step = fitted;
            if change.abs() < 1e-10 {
                break;
            }
        }
        time_step
    }

    /// The stable time step at t_n from an upper estimate of Λ with the damping of the step `time_step`.
    fn estimated_time_step(&mut self, lanczos: &mut Lanczos, time_step: f64) -> f64 {
        let step = 2.0 / (self.largest_ritz_value(lanczos, time_step) / (1.0 - UNDERESTIMATE)).sqrt();
        // less by rounding alone is no less
        if step >= time_step || !self.is_damped() { step } else { step * step / time_step }
    }

    fn is_damped(&self) -> bool {
        self.settings.bulk_viscosity.is_some() || self.blocks.iter().any(|block| block.elements.is_damped())
    }

    fn watch_elements(&mut self) {
        for block in &mut self.blocks {
            block.elements.watch();
        }
    }

    /// θ, 1/s², with the damping of the step `time_step`. The rows of the patches serve as rows of the operator.
    fn largest_ritz_value(&mut self, lanczos: &mut Lanczos, time_step: f64) -> f64 {
        let step = ElementStep { bulk_viscosity: self.settings.bulk_viscosity, time_step };
        let seed = self.step;
        let mut operator = self.linear_operator(&step);
        lanczos.start(seed, operator.mass, |_, z| z);
        lanczos.extend_to(lanczos.planned(), &mut operator, |_, z| z);
        lanczos.largest_ritz_value()
    }
}
