//! What was measured, as a table of at most 100 columns and as JSON.

use super::machine::Description;
use estar_deck::format;
use estar_tensor::Operations;
use serde::Serialize;
use std::fmt::Write;

/// Everything that was measured.
#[derive(Debug, Serialize)]
pub struct Report {
    /// Version of the program.
    pub version: &'static str,
    /// The machine.
    pub machine: Description,
    /// What it can do.
    #[serde(flatten)]
    pub limits: Limits,
    /// Repetitions of each measurement.
    pub repetitions: usize,
    /// How to show the problems.
    #[serde(skip)]
    pub layout: Layout,
    /// Meshes and lanes.
    pub problems: Vec<Problem>,
}

/// What the rows of a table differ in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Element and material, a table for each problem.
    Pairs,
    /// The size of the mesh.
    Curve,
}

/// Limits of the machine, for each number of threads.
#[derive(Debug, Serialize)]
pub struct Limits {
    /// The numbers of threads that everything is measured with.
    pub threads: Vec<usize>,
    /// Triad of arrays far beyond the caches.
    pub memory: Bandwidth,
    /// Triad of arrays in the second-level cache.
    pub cache: Bandwidth,
    /// Arithmetic on the lanes of each level.
    pub arithmetic: Vec<Arithmetic>,
}

/// Rates at which a number of bytes moves.
#[derive(Debug, Serialize)]
pub struct Bandwidth {
    /// Bytes that move, of all threads together.
    pub bytes: usize,
    /// Rate for each number of threads.
    pub bytes_per_second: Vec<f64>,
}

/// Arithmetic on the lanes of a level.
#[derive(Debug, Serialize)]
pub struct Arithmetic {
    /// Name of the level.
    pub lanes: &'static str,
    /// Rate for each number of threads.
    pub flops_per_second: Vec<f64>,
}

/// A mesh at a lane level.
#[derive(Debug, Serialize)]
pub struct Problem {
    /// Name of the level.
    pub lanes: &'static str,
    /// Hexes of the mesh.
    pub hexes: usize,
    /// Triad of as many bytes as a step of the first row moves.
    pub triad: Bandwidth,
    /// Elements and materials.
    pub rows: Vec<Row>,
}

/// An element with a material.
#[derive(Debug, Serialize)]
pub struct Row {
    /// Element, as in a deck.
    pub element: &'static str,
    /// Material.
    pub material: &'static str,
    /// Elements of its mesh.
    pub elements: usize,
    /// Operations of an element step in which no point yields.
    pub elastic: Counts,
    /// Operations of one in which every point yields.
    pub yielding: Counts,
    /// Share of the hexes that yield in the step before those that were timed.
    pub yielding_share: f64,
    /// Flops of an element step, the mean of both kinds of hexes.
    pub flops: f64,
    /// Bytes of an element step.
    pub bytes: f64,
    /// Times for each number of threads.
    pub runs: Vec<Run>,
}

/// Operations of an element step.
#[derive(Debug, Serialize)]
pub struct Counts {
    flops: usize,
    instructions: usize,
    divisions: usize,
    square_roots: usize,
}

impl From<Operations> for Counts {
    fn from(operations: Operations) -> Self {
        let Operations { divisions, square_roots, .. } = operations;
        Self { flops: operations.flops(), instructions: operations.instructions(), divisions, square_roots }
    }
}

/// Times on a number of threads.
#[derive(Debug, Serialize)]
pub struct Run {
    /// Threads.
    pub threads: usize,
    /// Wall time per element step, median, ns.
    pub nanoseconds: f64,
    /// The same of the fastest repetition.
    pub fastest_nanoseconds: f64,
    /// Half of the range of the repetitions, as a fraction of the median.
    pub spread: f64,
    /// Element steps per second.
    pub element_steps_per_second: f64,
    /// The time that the machine needs at least, as a fraction of the median.
    pub roofline_fraction: f64,
    /// What bounds that time.
    pub bound: &'static str,
}

impl Run {
    /// From the times of the repetitions (ns), and what bounds the time of an element step with that time (s).
    pub fn new(threads: usize, times: &[f64], seconds_at_least: [(&'static str, f64); 2]) -> Self {
        let mut times = times.to_vec();
        times.sort_by(f64::total_cmp);
        let median = times[times.len() / 2];
        let [first, second] = seconds_at_least;
        let (bound, at_least) = if first.1 < second.1 { second } else { first };
        Self {
            threads,
            nanoseconds: median,
            fastest_nanoseconds: times[0],
            spread: 0.5 * (times[times.len() - 1] - times[0]) / median,
            element_steps_per_second: 1e9 / median,
            roofline_fraction: 1e9 * at_least / median,
            bound,
        }
    }
}

impl Report {
    /// The report for people.
    pub fn in_words(&self) -> String {
        let cores = if self.machine.cores == 1 { "core" } else { "cores" };
        let mut text = format!("Estar {}, bench\n", self.version);
        let Description { processor, cores: count, architecture, system, .. } = &self.machine;
        let _ = writeln!(text, "  machine  {processor}, {count} {cores}, {architecture} {system}");
        let yielding = 100.0 * self.problems[0].rows[0].yielding_share;
        let _ = writeln!(
            text,
            "  problem  quarter Taylor bar, copper, 227 m/s, from 2 µs on, where {yielding:.0} % of the hexes yield"
        );
        let _ = writeln!(text, "  figures  medians of {} repetitions of whole steps\n", self.repetitions);
        self.write_limits(&mut text);
        match self.layout {
            Layout::Pairs => {
                for problem in &self.problems {
                    let hexes = format::count(problem.hexes as f64);
                    let title = format!("{}, {hexes} hexes or about as many tets", problem.lanes);
                    self.write_head(&mut text, &title, ["element", "material"]);
                    for row in &problem.rows {
                        write_row(&mut text, [row.element, row.material], row);
                    }
                }
            }
            Layout::Curve => {
                self.write_head(&mut text, "hex8-f-bar, e-star box-rate linear", ["hexes", "lanes, triad in GB/s"]);
                for problem in &self.problems {
                    let triad: Vec<String> =
                        problem.triad.bytes_per_second.iter().map(|rate| format!("{:.1}", 1e-9 * rate)).collect();
                    let labels =
                        [&format::count(problem.hexes as f64), &format!("{:8} {}", problem.lanes, triad.join(" "))];
                    problem.rows.iter().for_each(|row| write_row(&mut text, labels.map(String::as_str), row));
                }
            }
        }
        text.push_str(LEGEND);
        text
    }

    fn write_limits(&self, text: &mut String) {
        let _ = write!(text, "{:52}", "limits of the machine");
        for &threads in &self.limits.threads {
            let _ = write!(text, "{:>13}", in_threads(threads));
        }
        let mut write = |name: &str, unit, rates: &[f64]| {
            let _ = write!(text, "\n  {name:41}{unit:9}");
            for rate in rates {
                let _ = write!(text, "{:13.1}", 1e-9 * rate);
            }
        };
        let limits = &self.limits;
        let size = |bandwidth: &Bandwidth| format::bytes(bandwidth.bytes as f64);
        write(&format!("triad of {}", size(&limits.memory)), "GB/s", &limits.memory.bytes_per_second);
        if self.layout == Layout::Pairs {
            let triad = &self.problems[0].triad;
            write(&format!("triad of {}, as a step moves", size(triad)), "GB/s", &triad.bytes_per_second);
        }
        write(&format!("triad of {}, in cache", size(&limits.cache)), "GB/s", &limits.cache.bytes_per_second);
        for arithmetic in &limits.arithmetic {
            write(&format!("arithmetic, {}", arithmetic.lanes), "Gflop/s", &arithmetic.flops_per_second);
        }
        text.push('\n');
    }

    fn write_head(&self, text: &mut String, title: &str, labels: [&str; 2]) {
        let _ = write!(text, "\n{title:50}");
        for &threads in &self.limits.threads {
            let _ = write!(text, "{:>25}", in_threads(threads));
        }
        let _ = write!(text, "\n{:15}{:23}{:>6}{:>6}", labels[0], labels[1], "flops", "bytes");
        for _ in &self.limits.threads {
            let _ = write!(text, "{:>7}{:>5}{:>7}{:>6}", "ns", "±%", "M/s", "roof");
        }
        text.push('\n');
    }
}

fn write_row(text: &mut String, labels: [&str; 2], row: &Row) {
    let _ = write!(text, "{:15}{:23}{:6.0}{:6.0}", labels[0], labels[1], row.flops, row.bytes);
    for run in &row.runs {
        let (spread, rate, share) =
            (100.0 * run.spread, 1e-6 * run.element_steps_per_second, 100.0 * run.roofline_fraction);
        let bound = &run.bound[..1];
        let _ = write!(text, "{:7.1}{spread:5.0}{rate:7.2}{share:5.0}{bound}", run.nanoseconds);
    }
    text.push('\n');
}

fn in_threads(threads: usize) -> String {
    if threads == 1 { "1 thread".to_owned() } else { format!("{threads} threads") }
}

const LEGEND: &str = "
flops  counted, per element step, in the mix of hexes that yield and hexes that do not; bytes too;
       of tet4 without the means over nodes
ns     wall time per element step of whole steps; ±% half the range of the repetitions
M/s    million element steps per second
roof   % of the roofline: the time that arithmetic (a) or memory (m) needs at least, over ns";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_has_the_median_and_the_nearer_of_two_limits() {
        let run = Run::new(2, &[120.0, 100.0, 80.0], [("arithmetic", 20e-9), ("memory", 50e-9)]);
        assert_eq!((run.nanoseconds, run.bound), (100.0, "memory"));
        assert!((run.spread - 0.2).abs() < 1e-12 && (run.roofline_fraction - 0.5).abs() < 1e-12);
        assert!((run.element_steps_per_second - 1e7).abs() < 1e-3);
    }
}
