//! What has been seen of a run so far: its rows, its expectations, how close its elements came to inversion.

use crate::bits::Bits;
use crate::checkpoint::Bookmark;
use crate::expectations::{Expectation, Moment, Outcome};
use crate::inversion::Approach;
use crate::output::Schedule;
use crate::passing::Passing;
use crate::problem::Problem;
use crate::progress::Pace;
use crate::snapshot::Snapshot;
use crate::trouble;
use estar_solver::Simulation;

/// What has been seen of a run so far.
#[derive(Debug)]
pub struct Course {
    /// When frames fall due.
    pub frame_schedule: Schedule,
    /// When rows fall due.
    pub history_schedule: Schedule,
    /// Position of each expectation whose moment is still to come.
    pending: Vec<usize>,
    outcomes: Vec<Option<Outcome>>,
    last_row: Option<u64>,
    /// Step and smallest Jacobian of the last rows.
    pub jacobians: Vec<(u64, f64)>,
    /// How close each part has come to inversion.
    pub approach: Approach,
    /// Whether something has passed through something.
    pub passing: Passing,
    /// The first time step, s.
    pub initial_time_step: f64,
    /// The wall clock.
    pub pace: Pace,
}

impl Course {
    /// That of a run that goes on from where a bookmark was left.
    pub fn of(bookmark: &Bookmark, problem: &Problem, simulation: &Simulation) -> Self {
        let [frames_passed, rows_passed] = bookmark.passed;
        let outcome = |(expectation, seen): (&Expectation, &Option<[Bits; 2]>)| {
            let [time, value] = (*seen)?.map(f64::from);
            Some(expectation.outcome(&problem.probes[expectation.probe].name, time, value))
        };
        Self {
            frame_schedule: Schedule::after(problem.output.frames, frames_passed),
            history_schedule: Schedule::after(problem.output.history, rows_passed),
            pending: bookmark.pending.clone(),
            outcomes: problem.expectations.iter().zip(&bookmark.outcomes).map(outcome).collect(),
            last_row: bookmark.last_row,
            jacobians: bookmark.jacobians.iter().map(|(step, jacobian)| (*step, f64::from(*jacobian))).collect(),
            approach: bookmark.approach.clone(),
            passing: Passing::new(problem),
            initial_time_step: f64::from(bookmark.initial_time_step),
            pace: Pace::start(simulation, bookmark.wall_seconds),
        }
    }

    /// Writes into a bookmark what another leg of the run must know.
    pub fn mark(&self, bookmark: &mut Bookmark) {
        let seen = |outcome: &Option<Outcome>| {
            outcome.as_ref().map(|outcome| [Bits::from(outcome.time), Bits::from(outcome.found)])
        };
        bookmark.passed = [self.frame_schedule.passed(), self.history_schedule.passed()];
        bookmark.last_row = self.last_row;
        bookmark.pending.clone_from(&self.pending);
        bookmark.outcomes = self.outcomes.iter().map(seen).collect();
        bookmark.jacobians = self.jacobians.iter().map(|(step, jacobian)| (*step, Bits::from(*jacobian))).collect();
        bookmark.approach.clone_from(&self.approach);
        bookmark.initial_time_step = Bits::from(self.initial_time_step);
        bookmark.wall_seconds = self.pace.wall_seconds();
    }

    /// Whether no row has been taken yet.
    pub fn is_empty(&self) -> bool {
        self.last_row.is_none()
    }

    /// Whether a step is later than the last row.
    pub fn is_new(&self, step: u64) -> bool {
        // a repetition that was left may be at an earlier step than the last row
        self.last_row < Some(step)
    }

    /// Takes a row: the values of the probes, and the smallest Jacobian.
    pub fn take_row(&mut self, problem: &Problem, simulation: &Simulation, values: &[f64], min_jacobian: f64) {
        let step = simulation.step();
        self.jacobians.push((step, min_jacobian));
        if self.jacobians.len() > trouble::JACOBIANS_SHOWN {
            self.jacobians.remove(0);
        }
        self.last_row = Some(step);
        for (expectation, outcome) in problem.expectations.iter().zip(&mut self.outcomes) {
            let value = values[expectation.probe];
            if expectation.moment == Moment::Max && outcome.as_ref().is_none_or(|largest| value > largest.found) {
                let name = &problem.probes[expectation.probe].name;
                *outcome = Some(expectation.outcome(name, simulation.time(), value));
            }
        }
    }

    /// Looks at the expectations whose moment has come.
    pub fn check_pending(&mut self, problem: &Problem, simulation: &Simulation) {
        if self.pending.is_empty() {
            return;
        }
        let time = simulation.time();
        let has_come =
            |index: &usize| matches!(problem.expectations[*index].moment, Moment::Time(moment) if time >= moment);
        let due: Vec<usize> = self.pending.iter().copied().filter(has_come).collect();
        if due.is_empty() {
            return;
        }
        self.pending.retain(|index| !due.contains(index));
        for index in due {
            self.outcomes[index] = Some(outcome(index, problem, simulation));
        }
    }

    /// Looks at the expectations that are of the end.
    pub fn check_end(&mut self, problem: &Problem, simulation: &Simulation) {
        for (index, seen) in self.outcomes.iter_mut().enumerate() {
            seen.get_or_insert_with(|| outcome(index, problem, simulation));
        }
    }

    /// The outcomes so far, and whether all expectations were met.
    pub fn outcomes(&self) -> (Vec<Outcome>, bool) {
        let outcomes: Vec<Outcome> = self.outcomes.iter().flatten().cloned().collect();
        let are_met = outcomes.len() == self.outcomes.len() && outcomes.iter().all(|outcome| outcome.met);
        (outcomes, are_met)
    }
}

fn outcome(index: usize, problem: &Problem, simulation: &Simulation) -> Outcome {
    let expectation = problem.expectations[index];
    let probe = &problem.probes[expectation.probe];
    let value = probe.value(&Snapshot::new(&problem.mesh, simulation));
    expectation.outcome(&probe.name, simulation.time(), value)
}
