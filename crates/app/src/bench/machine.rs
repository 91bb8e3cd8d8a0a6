//! What the machine can do at most: bytes per second between memory and processor, and floating-point operations.

use estar_solver::LaneLevel;
use estar_tensor::{Kernel, Real, WithLanes, array, dispatch};
use serde::Serialize;
use std::hint::black_box;
use std::sync::Barrier;
use std::time::{Duration, Instant};

/// Repetitions of every measurement; the best counts, since a limit is what an undisturbed machine does.
const REPETITIONS: usize = 7;
/// A repetition lasts so long at least.
const LEAST_DURATION: Duration = Duration::from_millis(10);

/// The machine, in words and bytes.
#[derive(Clone, Debug, Serialize)]
pub struct Description {
    /// Name of the processor, where the system tells (Linux).
    pub processor: String,
    /// Architecture.
    pub architecture: &'static str,
    /// Operating system.
    pub system: &'static str,
    /// Threads that can run at once.
    pub cores: usize,
    /// Bytes of the second-level cache of a core.
    pub second_level_cache: usize,
    /// Bytes of the largest cache.
    pub largest_cache: usize,
}

impl Description {
    /// What the system tells.
    pub fn of_this_machine() -> Self {
        let second_level_cache = cache_bytes(2).unwrap_or(1 << 20);
        Self {
            processor: processor_name().unwrap_or_else(|| "unknown processor".to_owned()),
            architecture: std::env::consts::ARCH,
            system: std::env::consts::OS,
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            second_level_cache,
            largest_cache: cache_bytes(3).unwrap_or(32 << 20).max(second_level_cache),
        }
    }
}

fn processor_name() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// Bytes of the cache of a level that the first core has or shares.
fn cache_bytes(level: u32) -> Option<usize> {
    let directory = "/sys/devices/system/cpu/cpu0/cache";
    let read = |index: u32, name: &str| std::fs::read_to_string(format!("{directory}/index{index}/{name}")).ok();
    let is_of_level = |index: &u32| read(*index, "level").is_some_and(|text| text.trim() == level.to_string());
    let size = read((0..8).rfind(is_of_level)?, "size")?;
    size.trim().strip_suffix('K')?.parse::<usize>().ok().map(|kilobytes| kilobytes << 10)
}

/// Bytes per second of the triad a ← b + s c over three arrays of `bytes` in all on each of `threads` threads; reads and
/// writes counted, as McCalpin's STREAM does.
pub fn triad_rate(bytes: usize, threads: usize, level: LaneLevel) -> f64 {
    let length = (bytes / (3 * size_of::<f64>())).max(1);
    let make = || Triad { target: vec![0.0; length], first: vec![1.0; length], second: vec![2.0; length] };
    let run = |arrays: &mut Triad| dispatch(level, TriadRun(arrays));
    (threads * length * 3 * size_of::<f64>()) as f64 / best_time(threads, make, run)
}

/// Floating-point operations per second of `threads` threads that do nothing but arithmetic on the lanes of `level`:
/// fused multiply-adds or, where it has no instruction for them, multiplications and additions.
pub fn arithmetic_rate(threads: usize, level: LaneLevel) -> f64 {
    let rate = |is_fused| {
        let flops = dispatch(level, Chains { is_fused });
        (threads * flops) as f64 / best_time(threads, || (), |()| _ = dispatch(level, Chains { is_fused }))
    };
    rate(true).max(rate(false))
}

/// Seconds of the best repetition of `work` when every thread does it on what it has made itself.
fn best_time<T>(threads: usize, make: impl Fn() -> T + Sync, work: impl Fn(&mut T) + Sync) -> f64 {
    let barrier = Barrier::new(threads);
    // threads share a number of calls, found by the first
    let calls = std::sync::OnceLock::new();
    let on_thread = || {
        let mut made = make();
        // the first call wakes memory and processor, the second tells how many make a repetition
        work(&mut made);
        let begun = Instant::now();
        work(&mut made);
        let once = begun.elapsed().max(Duration::from_nanos(100));
        let calls = *calls.get_or_init(|| LEAST_DURATION.div_duration_f64(once).ceil() as usize);
        let repetition = |_| {
            barrier.wait();
            let begun = Instant::now();
            for _ in 0..calls {
                work(&mut made);
            }
            begun.elapsed().as_secs_f64() / calls as f64
        };
        (0..REPETITIONS).map(repetition).collect::<Vec<f64>>()
    };
    let times: Vec<Vec<f64>> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..threads).map(|_| scope.spawn(on_thread)).collect();
        threads.into_iter().map(|thread| thread.join().expect("a measurement does not panic")).collect()
    });
    // a repetition lasts as long as its slowest thread
    let slowest = |repetition| times.iter().map(|times: &Vec<f64>| times[repetition]).fold(0.0, f64::max);
    (0..REPETITIONS).map(slowest).fold(f64::INFINITY, f64::min)
}

struct Triad {
    target: Vec<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
}

struct TriadRun<'a>(&'a mut Triad);

impl WithLanes for TriadRun<'_> {
    type Output = ();

    fn with_lanes<R: Real>(self) {
        R::vectorize(self);
    }
}

impl Kernel for TriadRun<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Triad { target, first, second } = self.0;
        let factor = black_box(3.0);
        for ((a, b), c) in target.iter_mut().zip(&*first).zip(&*second) {
            *a = b + factor * c;
        }
        black_box(target);
    }
}

/// Chains of operations, each waiting for its own last: more than a processor has in flight, and few enough to stay in
/// its registers.
const CHAINS: usize = 12;
/// Operations of a chain in one call.
const LINKS: usize = 4096;

#[derive(Clone, Copy)]
struct Chains {
    is_fused: bool,
}

impl WithLanes for Chains {
    type Output = usize;

    fn with_lanes<R: Real>(self) -> usize {
        // values that stay near 1, unknown to the compiler
        let factor = R::splat(black_box(0.75));
        let addend = R::splat(black_box(0.25));
        let end = R::vectorize(ChainsRun { factor, addend, is_fused: self.is_fused });
        black_box(end.lane(0));
        2 * CHAINS * LINKS * R::LANES
    }
}

struct ChainsRun<R> {
    factor: R,
    addend: R,
    is_fused: bool,
}

impl<R: Real> Kernel for ChainsRun<R> {
    type Output = R;

    #[inline(always)]
    fn run(self) -> R {
        let Self { factor, addend, is_fused } = self;
        let mut chains: [R; CHAINS] = array(|chain| addend + chain as f64);
        for _ in 0..LINKS {
            for chain in &mut chains {
                *chain = if is_fused { chain.mul_add(factor, addend) } else { *chain * factor + addend };
            }
        }
        chains.into_iter().fold(R::splat(0.0), |sum, chain| sum + chain)
    }
}
