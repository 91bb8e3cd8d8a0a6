//! `estar bench`: time per element step of every element and material on this machine, against what the machine can do.
//!
//! Whole steps are timed: elements, node sums, wall, constraints, energies and time step. The operations of an element step
//! are counted by a number that counts ([`single_hex`]), its bytes from the sizes of the data
//! ([`Simulation::bytes_per_step`]); the roofline is the longer of the times that the machine needs for either.

pub mod machine;
mod report;
pub mod single_hex;
pub mod taylor_bar;

use crate::console::{print, print_json, tell};
use crate::failure::Failure;
use estar_deck::format::count;
use estar_deck::model::element_name;
use estar_material::MaterialModel;
use estar_session::machine as threads_and_lanes;
use estar_solver::fields::ElementMeans;
use estar_solver::model::Formulation;
use estar_solver::{LaneLevel, Simulation};
use machine::{Description, arithmetic_rate, triad_rate};
use rayon::ThreadPool;
use report::{Arithmetic, Bandwidth, Layout, Limits, Problem, Report, Row, Run};
use single_hex::{Pace, operations_of_step};
use std::time::Instant;
use taylor_bar::PEERS_HEX_COUNT;

/// What the command line asks for.
#[derive(Clone, Debug)]
pub struct BenchOptions {
    /// The larger number of threads; all cores unless given.
    pub threads: Option<usize>,
    /// Vector instructions to measure; at least one set.
    pub lanes: Vec<LaneLevel>,
    /// Hexes of the mesh, about.
    pub hexes: Option<usize>,
    /// One element and material over many sizes.
    pub sizes: bool,
    /// A look in place of a measurement.
    pub quick: bool,
    /// Print JSON.
    pub json: bool,
}

/// Sizes of the curve: from what stays in a cache to what fills gigabytes.
const CURVE: [usize; 8] = [1_536, 5_184, 12_288, PEERS_HEX_COUNT, 139_968, 331_776, 1_029_000, 2_044_416];
/// Hexes of a quick look, and the most of a quick curve.
const QUICK_HEX_COUNT: usize = 3_000;
/// The steps that are timed begin here, s: a wave has passed a quarter of the bar, and a quarter of its hexes yield.
const WARM_UP: f64 = 2e-6;
/// Element steps of a repetition, about, and its most steps.
const ELEMENT_STEPS: usize = 200_000;
const MOST_STEPS: usize = 50;
/// Repetitions, whose median counts.
const REPETITIONS: usize = 7;
const QUICK_REPETITIONS: usize = 3;
/// Elements of all bars that are in memory at once, unless one alone has more.
const ELEMENTS_AT_ONCE: usize = 1_000_000;
/// Bounds of the arrays of the memory's triad, which are as large as the largest cache: three of them are far beyond it.
const LEAST_ARRAY: usize = 64 << 20;
const LARGEST_ARRAY: usize = 512 << 20;

/// Measures and prints.
///
/// # Errors
/// The machine lacks what is asked for, or standard output cannot be written.
pub fn bench(options: &BenchOptions) -> Result<(), Failure> {
    for &level in &options.lanes {
        threads_and_lanes(Some(1), Some(level))?;
    }
    let (all_threads, _) = threads_and_lanes(options.threads, None)?;
    let mut pools = vec![threads_and_lanes(Some(1), None)?.0];
    pools.extend((all_threads.current_num_threads() > 1).then_some(all_threads));
    let report = Bench { options, pools, begun: Instant::now() }.report()?;
    if options.json {
        return print_json(&report);
    }
    print(&report.in_words())
}

/// An element and a material.
type Pair = (Formulation, &'static str, MaterialModel);

/// A measurement under way.
struct Bench<'a> {
    options: &'a BenchOptions,
    /// One thread and, where there are more, all.
    pools: Vec<ThreadPool>,
    begun: Instant,
}

impl Bench<'_> {
    fn tell(&self, what: &str) {
        tell(&format!("{:4.0} s  {what}\n", self.begun.elapsed().as_secs_f64()));
    }

    fn report(&self) -> Result<Report, Failure> {
        let options = self.options;
        let machine = Description::of_this_machine();
        self.tell("memory and arithmetic of the machine");
        let limits = self.limits(&machine);
        let pairs = taylor_bar::ELEMENTS.into_iter().flat_map(|element| {
            taylor_bar::materials().into_iter().map(move |(name, material)| (element, name, material))
        });
        let mut pairs: Vec<Pair> = pairs.collect();
        let sizes = if options.sizes {
            pairs.truncate(1);
            CURVE.into_iter().filter(|&size| !options.quick || size <= QUICK_HEX_COUNT).collect()
        } else {
            let usual = if options.quick { QUICK_HEX_COUNT } else { PEERS_HEX_COUNT };
            vec![options.hexes.unwrap_or(usual)]
        };
        let mut problems = Vec::new();
        for &level in &options.lanes {
            for &size in &sizes {
                problems.push(self.problem(size, level, &pairs, &limits)?);
            }
        }
        Ok(Report {
            version: env!("CARGO_PKG_VERSION"),
            machine,
            limits,
            repetitions: self.repetitions(),
            layout: if options.sizes { Layout::Curve } else { Layout::Pairs },
            problems,
        })
    }

    fn repetitions(&self) -> usize {
        if self.options.quick { QUICK_REPETITIONS } else { REPETITIONS }
    }

    fn limits(&self, machine: &Description) -> Limits {
        let threads: Vec<usize> = self.pools.iter().map(ThreadPool::current_num_threads).collect();
        let array = if self.options.quick {
            // made in no time, though a cache may hold it
            LEAST_ARRAY / 4
        } else {
            machine.largest_cache.clamp(LEAST_ARRAY, LARGEST_ARRAY)
        };
        let arithmetic = |&level: &LaneLevel| Arithmetic {
            lanes: level.name(),
            flops_per_second: threads.iter().map(|&threads| arithmetic_rate(threads, level)).collect(),
        };
        Limits {
            memory: self.bandwidth(3 * array),
            cache: self.bandwidth(machine.second_level_cache / 2),
            arithmetic: self.options.lanes.iter().map(arithmetic).collect(),
            threads,
        }
    }

    /// Rates at which `bytes` move, by the triad.
    fn bandwidth(&self, bytes: usize) -> Bandwidth {
        let rate = |pool: &ThreadPool| {
            let threads = pool.current_num_threads();
            triad_rate(bytes / threads, threads, LaneLevel::best())
        };
        Bandwidth { bytes, bytes_per_second: self.pools.iter().map(rate).collect() }
    }

    /// Each of the pairs as the bar of about so many elements.
    fn problem(&self, size: usize, level: LaneLevel, pairs: &[Pair], limits: &Limits) -> Result<Problem, Failure> {
        let arithmetic = limits.arithmetic.iter().find(|arithmetic| arithmetic.lanes == level.name());
        let arithmetic = arithmetic.expect("every level that is measured");
        let mut first = None;
        let mut rows = Vec::new();
        for pairs in pairs.chunks((ELEMENTS_AT_ONCE / size.max(1)).max(1)) {
            self.tell(&format!("{}, {} elements: up to the steps that are timed", level.name(), count(size as f64)));
            let bars: Result<Vec<_>, _> = pairs.iter().map(|pair| Bar::new(size, pair, level, &self.pools)).collect();
            let mut bars = bars?;
            self.tell(&format!("{}, {} elements: timed steps", level.name(), count(size as f64)));
            // neighbours on the machine come and go: the bars take turns, so that all meet the same
            for _ in 0..self.repetitions() {
                for bar in &mut bars {
                    bar.repeat(&self.pools)?;
                }
            }
            let (triad, _) = first.get_or_insert_with(|| {
                let simulation = &bars[0].simulation;
                (self.bandwidth(simulation.bytes_per_step()), simulation.element_count())
            });
            rows.extend(bars.iter().map(|bar| bar.row(&self.pools, triad, arithmetic)));
        }
        let (triad, hexes) = first.expect("at least one pair, the first of hexes");
        Ok(Problem { lanes: level.name(), hexes, triad, rows })
    }
}

/// A bar under way.
struct Bar<'a> {
    pair: &'a Pair,
    simulation: Simulation,
    /// Share of the hexes that yield in a step.
    yielding: f64,
    /// Steps of a repetition.
    steps: usize,
    /// ns per element step of each repetition, for each pool.
    times: Vec<Vec<f64>>,
}

impl<'a> Bar<'a> {
    /// The bar of about so many elements at the steps that are timed.
    fn new(size: usize, pair: &'a Pair, level: LaneLevel, pools: &[ThreadPool]) -> Result<Self, Failure> {
        let (element, _, material) = pair;
        let mesh = taylor_bar::mesh(size, taylor_bar::shape(*element));
        let model = taylor_bar::model(&mesh, material.clone(), *element);
        let simulation =
            Simulation::new(&mesh, model, level).map_err(|error| Failure::Simulation(format!("error: {error}")))?;
        let steps = (ELEMENT_STEPS / mesh.element_count()).clamp(1, MOST_STEPS);
        let mut bar = Self { pair, simulation, yielding: 0.0, steps, times: vec![Vec::new(); pools.len()] };
        let all_threads = &pools[pools.len() - 1];
        while bar.simulation.time() < WARM_UP {
            bar.advance(all_threads, 1)?;
        }
        let strain = |simulation: &Simulation| {
            let mut strain = vec![0.0; simulation.element_count()];
            let means = ElementMeans { equivalent_plastic_strain: Some(&mut strain), ..ElementMeans::default() };
            all_threads.install(|| simulation.write_means(means));
            strain
        };
        let before = strain(&bar.simulation);
        bar.advance(all_threads, 1)?;
        let after = strain(&bar.simulation);
        let yielding = before.iter().zip(&after).filter(|(before, after)| after > before).count();
        Ok(Self { yielding: yielding as f64 / before.len() as f64, ..bar })
    }

    fn advance(&mut self, pool: &ThreadPool, steps: usize) -> Result<(), Failure> {
        let simulation = &mut self.simulation;
        let advanced = pool.install(|| (0..steps).try_for_each(|_| simulation.advance()));
        advanced.map_err(|error| {
            Failure::Simulation(format!("error: {} {}: {error}", element_name(self.pair.0), self.pair.1))
        })
    }

    /// One repetition on each of the pools.
    fn repeat(&mut self, pools: &[ThreadPool]) -> Result<(), Failure> {
        for (position, pool) in pools.iter().enumerate() {
            // the caches are another bar's
            self.advance(pool, 1)?;
            let begun = Instant::now();
            self.advance(pool, self.steps)?;
            let element_steps = (self.steps * self.simulation.element_count()) as f64;
            self.times[position].push(1e9 * begun.elapsed().as_secs_f64() / element_steps);
        }
        Ok(())
    }

    fn row(&self, pools: &[ThreadPool], triad: &Bandwidth, arithmetic: &Arithmetic) -> Row {
        let (element, name, material) = self.pair;
        let [elastic, yielding] =
            [Pace::Elastic, Pace::Yielding].map(|pace| operations_of_step(material, *element, pace));
        let flops = elastic.flops() as f64 * (1.0 - self.yielding) + yielding.flops() as f64 * self.yielding;
        let bytes = self.simulation.bytes_per_step() as f64 / self.simulation.element_count() as f64;
        let runs = pools.iter().zip(&self.times).enumerate();
        let runs = runs.map(|(position, (pool, times))| {
            let seconds_at_least = [
                ("arithmetic", flops / arithmetic.flops_per_second[position]),
                ("memory", bytes / triad.bytes_per_second[position]),
            ];
            Run::new(pool.current_num_threads(), times, seconds_at_least)
        });
        Row {
            element: element_name(*element),
            material: name,
            elements: self.simulation.element_count(),
            elastic: elastic.into(),
            yielding: yielding.into(),
            yielding_share: self.yielding,
            flops,
            bytes,
            runs: runs.collect(),
        }
    }
}
