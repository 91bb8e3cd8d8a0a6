//! The path of a material point: when, and how it is deformed.

use crate::decoder::{At, Decoder};
use crate::diagnostics::Diagnostic;
use crate::point::{GradientRow, PathKind, PathTable};
use crate::point_column::Driven;
use crate::values::{NEGLIGIBLE, Number, TimePoints, begins_with};
use estar_material::point::{Control, StretchMeasure};
use estar_solver::{Curve, Interpolation};

/// More steps than this are a slip of the pen.
const MOST_STEPS: u64 = 10_000_000;
/// More rows than this are no table for people.
const MOST_ROWS: u64 = 50_000;

/// A path of a material point.
#[derive(Clone, Debug)]
pub struct Path {
    motion: Motion,
    /// The ends of the steps, s, and the beginning of the first.
    pub times: Vec<f64>,
    /// Steps from row to row.
    pub every: usize,
}

#[derive(Clone, Debug)]
enum Motion {
    Stretched { curve: Curve, measure: StretchMeasure, control: fn(f64) -> Control },
    Sheared { curve: Curve },
    Given(Vec<GradientRow>),
}

impl Path {
    /// The path of a table, or nothing after its faults have been reported.
    pub fn new(table: &PathTable, decoder: &mut Decoder) -> Option<Self> {
        use PathKind::{DeformationGradient, PlaneStrainTension, SimpleShear, UniaxialStrain, UniaxialStress};
        let mut stretched = |curve: &At<TimePoints<Number>>, measure: StretchMeasure, control| {
            let strain = |value| measure.stretch(value).map(|stretch: f64| stretch - 1.0);
            let undeformed = if measure == StretchMeasure::Stretch { 1.0 } else { 0.0 };
            let curve = checked(curve, undeformed, strain, decoder)?;
            Some(Motion::Stretched { curve, measure, control })
        };
        let motion = match &table.kind {
            UniaxialStress { measure, curve } => stretched(curve, *measure, Control::uniaxial_stress),
            UniaxialStrain { measure, curve } => stretched(curve, *measure, Control::uniaxial_strain),
            PlaneStrainTension { measure, curve } => stretched(curve, *measure, Control::plane_strain_tension),
            SimpleShear { curve, .. } => checked(curve, 0.0, Some, decoder).map(|curve| Motion::Sheared { curve }),
            DeformationGradient { curve } => Some(Motion::Given(curve.0.clone())),
        };
        let (steps, every) = (table.steps.value.0, table.every.0);
        let rows = steps.div_ceil(every);
        if steps > MOST_STEPS || rows > MOST_ROWS {
            let message = format!("`path` would take {steps} steps and write {rows} rows");
            let help =
                format!("the most are {MOST_STEPS} steps and {MOST_ROWS} rows; `every` is the steps from row to row");
            decoder.report(Diagnostic::error(message).at(table.steps.span, "too many").help(help));
            return None;
        }
        let motion = motion?;
        let corners = match &motion {
            Motion::Stretched { curve, .. } | Motion::Sheared { curve } => curve.times(),
            Motion::Given(rows) => rows.iter().map(|row| row.time).collect(),
        };
        Some(Self { motion, times: step_times(&corners, steps), every: every as usize })
    }

    /// What the curve measures.
    pub fn driven(&self) -> Driven {
        match &self.motion {
            Motion::Stretched { measure, .. } => Driven::Stretch(*measure),
            Motion::Sheared { .. } => Driven::Shear,
            Motion::Given(_) => Driven::Time,
        }
    }

    /// The value of the curve at a time.
    pub fn value(&self, time: f64) -> f64 {
        match &self.motion {
            Motion::Stretched { curve, .. } | Motion::Sheared { curve } => curve.value(time),
            Motion::Given(_) => time,
        }
    }

    /// The deformation at a time, as far as the path gives it.
    pub fn control(&self, time: f64) -> Control {
        match &self.motion {
            Motion::Stretched { measure, control, .. } => {
                // checked at the points of the curve, and so between them
                control(measure.stretch(self.value(time)).unwrap_or(f64::NAN))
            }
            Motion::Sheared { .. } => Control::simple_shear(self.value(time)),
            Motion::Given(rows) => {
                let index = rows.partition_point(|row| row.time < time).clamp(1, rows.len() - 1);
                let (old, new) = (&rows[index - 1], &rows[index]);
                let fraction = (time - old.time) / (new.time - old.time);
                let gradient = old.gradient + (new.gradient - old.gradient) * fraction;
                Control::deformation_gradient(if fraction == 1.0 { new.gradient } else { gradient })
            }
        }
    }
}

/// The curve through the points of a path, if all have a `strain` and the first is the value `undeformed`, or nearly so.
fn checked(
    points: &At<TimePoints<Number>>,
    undeformed: f64,
    strain: impl Fn(f64) -> Option<f64>,
    decoder: &mut Decoder,
) -> Option<Curve> {
    let curve = points.value.curve(Interpolation::Linear).ok()?;
    let times = curve.times();
    let value = |index: usize| curve.value(times[index]);
    let strains: Vec<Option<f64>> = (0..times.len()).map(|index| strain(value(index))).collect();
    let largest = strains.iter().flatten().fold(0.0_f64, |largest, strain| largest.max(strain.abs()));
    let fault = if times.len() < 2 {
        Some("`path.curve` needs two points at least".to_owned())
    } else if let Some(index) = strains.iter().position(Option::is_none) {
        Some(format!("point {} of `path.curve` has {:?}, which no stretch above 0 has", index + 1, value(index)))
    } else if strains[0].is_some_and(|first| first.abs() > NEGLIGIBLE * largest) {
        Some(format!("`path.curve` begins with {:?}, which is not the undeformed state", value(0)))
    } else {
        None
    };
    if let Some(fault) = fault {
        let help = "0 is undeformed in measure = \"green-lagrange\" (above -0.5), \"logarithmic\" and \"shear\", 1 in \"stretch\" \
                    (above 0)";
        decoder.report(Diagnostic::error(fault).at(points.span, "this curve").help(help));
        return None;
    }
    if value(0) == undeformed {
        return Some(curve);
    }
    let warning =
        begins_with("path.curve", &format!("{:?}", value(0)), &format!("{undeformed:?}, the undeformed state"));
    decoder.report(warning.at(points.span, "this curve"));
    points.value.beginning_with(undeformed).curve(Interpolation::Linear).ok()
}

/// The ends of `steps` steps, about: each piece between two corners has its share by its duration, one step at least.
fn step_times(corners: &[f64], steps: u64) -> Vec<f64> {
    let (first, last) = (corners[0], corners[corners.len() - 1]);
    let mut times = vec![first];
    for pair in corners.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        let share = (steps as f64 * ((to - from) / (last - first))).round().max(1.0) as u64;
        times.extend((1..share).map(|step| from + (to - from) * (step as f64 / share as f64)));
        times.push(to);
    }
    times
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_corner_is_the_end_of_a_step() {
        assert_eq!(step_times(&[0.0, 1.0, 3.0], 6), [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]);
        assert_eq!(step_times(&[0.0, 1e-9, 1.0], 2), [0.0, 1e-9, 0.5 * (1.0 + 1e-9), 1.0]);
        assert_eq!(step_times(&[-1.0, 1.0], 1), [-1.0, 1.0]);
    }
}
