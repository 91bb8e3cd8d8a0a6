//! How far a run is: a bar on a terminal, a line every few seconds elsewhere, and `run.jsonl` for programs.

use crate::console::Console;
use crate::failure::Failure;
use estar_deck::format::{duration, prefixed};
use estar_io::{append_whole, open_or_create};
use estar_session::files::RECORDS;
use estar_solver::Simulation;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use std::fs::{File, OpenOptions};
use std::io::{IsTerminal, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

const BAR_INTERVAL: Duration = Duration::from_millis(200);
const LINE_INTERVAL: Duration = Duration::from_secs(5);
const RECORD_INTERVAL: Duration = Duration::from_secs(1);
/// Ticks of the bar from beginning to end.
const BAR_LENGTH: u64 = 1000;

/// Follows a run.
#[derive(Debug)]
pub struct Progress {
    start: Instant,
    bar: Option<ProgressBar>,
    bar_due: Instant,
    line_due: Instant,
    record_due: Instant,
    records: File,
    records_path: PathBuf,
    window: [Mark; 2],
    /// Wall time of earlier legs of the run, s.
    seconds_before: f64,
}

/// What an earlier leg of the run has left.
#[derive(Clone, Copy, Debug, Default)]
pub struct EarlierLegs {
    /// Bytes of `run.jsonl`.
    pub record_bytes: u64,
    /// Wall time, s.
    pub wall_seconds: f64,
}

/// Where the run was at a moment.
#[derive(Clone, Copy, Debug)]
struct Mark {
    moment: Instant,
    time: f64,
    step: u64,
}

/// A line of `run.jsonl`.
#[derive(Debug, Serialize)]
struct Record {
    time: f64,
    end_time: f64,
    step: u64,
    time_step: f64,
    kinetic_energy: f64,
    internal_energy: f64,
    external_work: f64,
    energy_error: f64,
    element_steps_per_second: f64,
    seconds_left: f64,
    wall_seconds: f64,
}

impl Progress {
    /// Begins to follow a run that writes into `directory`, or goes on there after its `earlier` legs.
    ///
    /// # Errors
    /// `run.jsonl` cannot be written.
    pub fn start(
        directory: &Path,
        console: &Console,
        simulation: &Simulation,
        earlier: EarlierLegs,
    ) -> Result<Self, Failure> {
        let records_path = directory.join(RECORDS);
        let open = || -> std::io::Result<File> {
            let mut records = open_or_create(&records_path, OpenOptions::new().write(true))?;
            // what a machine that lost its power has not kept is not made up for
            records.set_len(earlier.record_bytes.min(records.metadata()?.len()))?;
            records.seek(SeekFrom::End(0))?;
            Ok(records)
        };
        let records = open().map_err(Failure::writing(&records_path))?;
        let start = Instant::now();
        let bar = (!console.is_quiet() && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::with_draw_target(Some(BAR_LENGTH), ProgressDrawTarget::stderr());
            let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {prefix} left\n{msg}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar
        });
        let mark = Mark { moment: start, time: simulation.time(), step: simulation.step() };
        Ok(Self {
            start,
            bar,
            bar_due: start,
            line_due: start + LINE_INTERVAL,
            record_due: start,
            records,
            records_path,
            window: [mark; 2],
            seconds_before: earlier.wall_seconds,
        })
    }

    /// Wall time since the beginning, that of earlier legs included, s.
    pub fn wall_seconds(&self) -> f64 {
        self.seconds_before + self.start.elapsed().as_secs_f64()
    }

    /// Bytes of `run.jsonl`.
    ///
    /// # Errors
    /// The system does not tell.
    pub fn record_bytes(&mut self) -> Result<u64, Failure> {
        self.records.stream_position().map_err(Failure::writing(&self.records_path))
    }

    /// Tells how far the run is, if it is time to.
    ///
    /// # Errors
    /// `run.jsonl` cannot be written.
    pub fn tell(&mut self, simulation: &Simulation, console: &mut Console) -> Result<(), Failure> {
        let now = Instant::now();
        if now < self.bar_due.min(self.record_due) {
            return Ok(());
        }
        let record = self.record(simulation, now);
        if now >= self.bar_due {
            self.bar_due = now + BAR_INTERVAL;
            if let Some(bar) = &self.bar {
                bar.set_position((BAR_LENGTH as f64 * simulation.time() / simulation.end_time()) as u64);
                bar.set_prefix(duration(record.seconds_left));
                bar.set_message(in_words(&record));
            }
        }
        if now >= self.line_due {
            self.line_due = now + LINE_INTERVAL;
            let percent = 100.0 * simulation.time() / simulation.end_time();
            let left = duration(record.seconds_left);
            let line = format!("{percent:5.1} %  {}  {left} left", in_words(&record));
            if self.bar.is_some() { console.note(&line) } else { console.say(&line) }
        }
        if now >= self.record_due {
            self.record_due = now + RECORD_INTERVAL;
            self.write(&record)?;
        }
        Ok(())
    }

    /// Does something while the bar is not in the way.
    pub fn beside(&self, work: impl FnOnce()) {
        match &self.bar {
            Some(bar) => bar.suspend(work),
            None => work(),
        }
    }

    /// Ends the bar and writes the last line of `run.jsonl`.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(&mut self, simulation: &Simulation) -> Result<(), Failure> {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
        let record = self.record(simulation, Instant::now());
        self.write(&record)
    }

    fn write(&mut self, record: &Record) -> Result<(), Failure> {
        let mut write = || -> std::io::Result<()> {
            let mut line = serde_json::to_string(record)?;
            line.push('\n');
            append_whole(&mut self.records, line.as_bytes())
        };
        write().map_err(Failure::writing(&self.records_path))
    }

    /// Rates are those of the last one to two seconds.
    fn record(&mut self, simulation: &Simulation, now: Instant) -> Record {
        let (time, step) = (simulation.time(), simulation.step());
        if now - self.window[1].moment > RECORD_INTERVAL {
            self.window = [self.window[1], Mark { moment: now, time, step }];
        }
        let since = self.window[0];
        let seconds = (now - since.moment).as_secs_f64();
        let energies = simulation.energies();
        Record {
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

fn in_words(record: &Record) -> String {
    format!(
        "t {:.4e} s  step {}  dt {:.3e} s  {}element steps/s  energy error {:+.3} %",
        record.time,
        record.step,
        record.time_step,
        prefixed(record.element_steps_per_second),
        100.0 * record.energy_error
    )
}
