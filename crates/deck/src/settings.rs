//! `[time]` and `[output]`.

use crate::decoder::{At, Decoder, FromDeck};
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::fields::Field;
use crate::macros::{deck_choice, deck_table};
use crate::schema::{Choice, Schema};
use crate::tree::{Node, Value};
use crate::values::{
    AtLeastOne, AtLeastTen, Count, Fraction, NotNegative, Number, Positive, Quantity, Rate, Share, Time,
};
use estar_solver::model::{OnInversion, TimeStep};

deck_table! {
    /// Time integration.
    pub struct TimeTable {
        /// Time at which the simulation ends.
        end: Quantity<Positive<Time>> = required,
        /// Fraction of the stable time step that is used.
        safety_factor: Quantity<Fraction> = default("0.9"),
        /// What the stable time step is taken from.
        time_step: TimeStepSource = default("'element'"),
        /// Steps from one estimate of `time_step = "power"` to the next; 500 unless given.
        time_step_interval: At<Count> = optional,
        /// Bulk viscosity; off unless given.
        bulk_viscosity: BulkViscosityTable = optional,
        /// Largest |energy error| before the run stops, as a fraction of the energy put in.
        energy_error_limit: Quantity<Positive<Number>> = default("'10 %'"),
        /// What becomes of an element that turns inside out, or is squeezed flat.
        on_inversion: OnInversion = default("'stop'"),
        /// Steps after which a run stops that has not reached its end.
        max_steps: Count = optional,
        /// Smallest time step that is worth going on with; below it the run stops, or with `on_inversion = "delete"` the elements
        /// that ask for less are deleted; there it is a hundredth of the first step unless given.
        min_time_step: Quantity<Positive<Time>> = optional,
        /// Mass added so that the run takes longer steps; none unless given.
        mass_scaling: MassScalingTable = optional,
        /// Damping in proportion to mass, the α of the force −α m v on every node.
        mass_damping: Quantity<NotNegative<Rate>> = default("0.0"),
        /// A slow process of which only the shapes and forces matter, not the time: mass scaling and damping are chosen for it, and
        /// curves that do not say how they run are at rest at their ends. Off unless given.
        quasi_static: QuasiStaticTable = optional,
    }
}

deck_table! {
    /// Mass added at time 0. It has inertia but no weight.
    pub struct MassScalingTable {
        /// The step that the run begins with at least: elements whose own, times the safety factor, is shorter are made heavier.
        target_time_step: Quantity<Positive<Time>> = optional,
        /// Factor on the mass of every element, before that.
        factor: At<Quantity<AtLeastOne>> = default("1.0"),
        /// Largest mass that the target may add to a part, as a share of its mass.
        limit: Quantity<NotNegative<Number>> = default("'5 %'"),
        /// Largest kinetic energy of added mass, as a share of the largest energy in play so far. From a tenth of the time on the
        /// run stops when it is passed. 10 % unless given; none with `quasi_static`, which reports it.
        kinetic_limit: Quantity<Positive<Number>> = optional,
    }
}

deck_table! {
    /// The process lasts for so many half periods of the slowest natural vibration of the body as it is held: the factor on the mass
    /// of every element follows from that. Vibration is damped.
    pub struct QuasiStaticTable {
        /// Half periods of the slowest natural vibration: in a free bar, passes of a wave through it. The more, the slower the process, and
        /// the longer the run.
        transits: Quantity<AtLeastTen> = default("100.0"),
        /// Damping ratio of the slowest natural vibration.
        damping: Quantity<Share> = default("0.005"),
    }
}

/// What the stable time step is taken from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeStepSource {
    /// `element`.
    Element,
    /// `power`.
    Power,
}

/// Steps from one estimate to the next where the deck does not say: what estimates cost then stands in `docs/time-step.md`.
const INTERVAL: u64 = 500;

impl TimeTable {
    /// What the solver takes the stable time step from; a key that does not suit it is reported.
    pub fn time_step(&self, diagnostics: &mut Diagnostics) -> TimeStep {
        let interval = self.time_step_interval.as_ref();
        match (self.time_step, interval) {
            (TimeStepSource::Power, _) => {
                TimeStep::Power { interval: interval.map_or(INTERVAL, |interval| interval.value.0) }
            }
            (TimeStepSource::Element, None) => TimeStep::Element,
            (TimeStepSource::Element, Some(interval)) => {
                let diagnostic = Diagnostic::error("the bound of the elements is renewed every step");
                let help = "an interval belongs to time_step = \"power\"";
                diagnostics.push(diagnostic.at(interval.span, "this key").help(help));
                TimeStep::Element
            }
        }
    }
}

deck_choice! { TimeStepSource {
    "element" => TimeStepSource::Element, "a proved bound of the highest frequency of every element, renewed every step";
    "power" => TimeStepSource::Power, "an estimate of the highest frequency of the assembled mesh, renewed every so many steps: larger \
        steps where few elements are small or distorted, and never smaller ones";
} }

deck_choice! { OnInversion {
    "stop" => OnInversion::Stop, "the run ends with status 3, and shows the element and its neighbours through their last steps";
    "delete" => OnInversion::Delete, "the element has no force and no time step any more, its mass stays at its nodes, and its energy is \
        a row of the ledger; loads on its faces go on";
} }

deck_table! {
    /// A pressure against fast volume change, which smooths shocks and damps ringing.
    pub struct BulkViscosityTable {
        /// Factor of the linear part.
        linear: Quantity<NotNegative<Number>> = default("0.06"),
        /// Factor of the quadratic part, which acts in compression only.
        quadratic: Quantity<NotNegative<Number>> = default("1.2"),
    }
}

deck_table! {
    /// What is written, and when. Rows and frames are taken at the first step at or after their time: output never
    /// changes the steps.
    pub struct OutputTable {
        /// Number of equal intervals between frames: time 0 and the end are frames, too. 20 unless `every` is given.
        frames: At<Count> = optional,
        /// Time between frames; instead of `frames`.
        every: At<Quantity<Positive<Time>>> = optional,
        /// Time between rows of history.csv; a thousandth of the end unless `history_steps` is given.
        history: At<Quantity<Positive<Time>>> = optional,
        /// Steps between rows of history.csv; instead of `history`.
        history_steps: At<Count> = optional,
        /// Wall time between checkpoints, from which `--resume` goes on; or "never", which leaves those of Ctrl-C, of SIGTERM
        /// and of `--stop-at-step`.
        checkpoint: CheckpointEvery = default("'10 min'"),
        /// Fields of the frames.
        fields: Vec<At<Field>> = default(
            "['displacement', 'velocity', 'cauchy_stress', 'equivalent_plastic_strain', 'von_mises_stress', 'pressure', 'volume_ratio']"),
    }
}

/// When checkpoints are written by themselves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CheckpointEvery {
    /// After so many seconds of wall time.
    Seconds(f64),
    /// Never.
    Never,
}

impl FromDeck for CheckpointEvery {
    fn schema() -> Schema {
        let never = Choice { name: "never", doc: "only when the run is stopped" };
        Schema::Either(vec![Quantity::<Positive<Time>>::schema(), Schema::Choice(vec![never])])
    }

    fn decode(node: &Node, decoder: &mut Decoder) -> Option<Self> {
        match &node.value {
            Value::Text(text) if text == "never" => Some(Self::Never),
            _ => Quantity::<Positive<Time>>::decode(node, decoder).map(|time| Self::Seconds(time.value)),
        }
    }
}

deck_choice! { Field {
    "displacement" => Field::Displacement, "of nodes, m";
    "velocity" => Field::Velocity, "of nodes, m/s";
    "cauchy_stress" => Field::CauchyStress, "mean over the element: XX YY ZZ XY YZ XZ, Pa";
    "equivalent_plastic_strain" => Field::EquivalentPlasticStrain, "mean over the element";
    "temperature" => Field::Temperature, "mean over the element, K; not a number where the material has none";
    "von_mises_stress" => Field::VonMisesStress, "mean over the element, Pa";
    "pressure" => Field::Pressure, "minus a third of the stress's trace, mean over the element, of a `tet4` over its neighbourhood, Pa";
    "volume_ratio" => Field::VolumeRatio, "current over first volume: at the centre of a hex, of the whole of a `tet10`, of the neighbourhood of a `tet4`";
} }
