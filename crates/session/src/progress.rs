//! How far a run is and how fast, and `run.jsonl`, which tells it to programs.

use crate::error::SessionError;
use crate::files::RECORDS;
use estar_io::{append_whole, open_or_create};
use estar_solver::Simulation;
use serde::Serialize;
use std::fs::{File, OpenOptions};
use std::io::{Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How often an observer is told.
const TOLD_INTERVAL: Duration = Duration::from_millis(200);
const RECORD_INTERVAL: Duration = Duration::from_secs(1);

/// How far a run is: a line of `run.jsonl`. Rates are those of the last one to two seconds.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Progress {
    /// Simulated time, s.
    pub time: f64,
    /// The end, s.
    pub end_time: f64,
    /// Steps.
    pub step: u64,
    /// Time step, s.
    pub time_step: f64,
    /// Kinetic energy, J.
    pub kinetic_energy: f64,
    /// Internal energy, J.
    pub internal_energy: f64,
    /// Work of loads and constraints, J.
    pub external_work: f64,
    /// Energy error, as a fraction.
    pub energy_error: f64,
    /// Elements times steps over wall time, 1/s.
    pub element_steps_per_second: f64,
    /// Wall time to the end at this rate, s.
    pub seconds_left: f64,
    /// Wall time since the beginning, that of earlier legs included, s.
    pub wall_seconds: f64,
}

/// The wall clock of a run.
#[derive(Debug)]
pub struct Pace {
    start: Instant,
    due: Instant,
    window: [Mark; 2],
    /// Wall time of earlier legs of the run, s.
    seconds_before: f64,
}

/// Where the run was at a moment.
#[derive(Clone, Copy, Debug)]
struct Mark {
    moment: Instant,
    time: f64,
    step: u64,
}

impl Pace {
    /// That of a run which goes on now, after so much wall time (s).
    pub fn start(simulation: &Simulation, seconds_before: f64) -> Self {
        let start = Instant::now();
        let mark = Mark { moment: start, time: simulation.time(), step: simulation.step() };
        Self { start, due: start, window: [mark; 2], seconds_before }
    }

    /// Wall time since the beginning, that of earlier legs included, s.
    pub fn wall_seconds(&self) -> f64 {
        self.seconds_before + self.start.elapsed().as_secs_f64()
    }

    /// How far the run is, if it is time to tell.
    pub fn due(&mut self, simulation: &Simulation) -> Option<Progress> {
        let now = Instant::now();
        if now < self.due {
            return None;
        }
        self.due = now + TOLD_INTERVAL;
        Some(self.progress(simulation, now))
    }

    /// How far the run is now.
    pub fn now(&mut self, simulation: &Simulation) -> Progress {
        self.progress(simulation, Instant::now())
    }

    fn progress(&mut self, simulation: &Simulation, now: Instant) -> Progress {
        let (time, step) = (simulation.time(), simulation.step());
        if now - self.window[1].moment > RECORD_INTERVAL {
            self.window = [self.window[1], Mark { moment: now, time, step }];
        }
        let since = self.window[0];
        let seconds = (now - since.moment).as_secs_f64();
        let energies = simulation.energies();
        Progress {
            time,
            end_time: simulation.end_time(),
            step,
            time_step: simulation.time_step(),
            kinetic_energy: energies.kinetic,
            internal_energy: energies.internal,
            external_work: energies.external_work(),
            energy_error: energies.error(),
            element_steps_per_second: (step - since.step) as f64 * simulation.element_count() as f64 / seconds,
            seconds_left: (simulation.end_time() - time) * seconds / (time - since.time),
            wall_seconds: self.wall_seconds(),
        }
    }
}

/// The growing file `run.jsonl`.
#[derive(Debug)]
pub struct Records {
    file: File,
    path: PathBuf,
    due: Instant,
}

impl Records {
    /// Begins the file in a directory, or goes on after so many bytes of it.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn start(directory: &Path, bytes: u64) -> Result<Self, SessionError> {
        let path = directory.join(RECORDS);
        let open = || -> std::io::Result<File> {
            let mut file = open_or_create(&path, OpenOptions::new().write(true))?;
            // what a machine that lost its power has not kept is not made up for
            file.set_len(bytes.min(file.metadata()?.len()))?;
            file.seek(SeekFrom::End(0))?;
            Ok(file)
        };
        let file = open().map_err(SessionError::writing(&path))?;
        Ok(Self { file, path, due: Instant::now() })
    }

    /// Bytes of the file.
    ///
    /// # Errors
    /// The system does not tell.
    pub fn bytes(&mut self) -> Result<u64, SessionError> {
        self.file.stream_position().map_err(SessionError::writing(&self.path))
    }

    /// Adds a line, if it is time to.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn tell(&mut self, progress: &Progress) -> Result<(), SessionError> {
        let now = Instant::now();
        if now < self.due {
            return Ok(());
        }
        self.due = now + RECORD_INTERVAL;
        self.write(progress)
    }

    /// Adds a line.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&mut self, progress: &Progress) -> Result<(), SessionError> {
        let mut write = || -> std::io::Result<()> {
            let mut line = serde_json::to_string(progress)?;
            line.push('\n');
            append_whole(&mut self.file, line.as_bytes())
        };
        write().map_err(SessionError::writing(&self.path))
    }
}
