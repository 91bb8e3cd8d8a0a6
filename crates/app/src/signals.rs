//! Signals: a run that is told to stop writes a checkpoint first, and a write that is refused is an error and no death.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Signals that follow the first within this time are its echo: some send one to the program and one to its group.
const ECHO: Duration = Duration::from_secs(1);

/// A flag that Ctrl-C and the like raise; a second one ends the program at once.
pub fn interruption() -> Arc<AtomicBool> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    let mut first: Option<Instant> = None;
    on_interruption(move || {
        raised.store(true, Ordering::Relaxed);
        if first.get_or_insert_with(Instant::now).elapsed() > ECHO {
            std::process::exit(130);
        }
    });
    flag
}

/// A file that may grow no longer then gives an error on the next write, where the signal would end the program.
pub fn survive_file_size_limit() {
    #[cfg(unix)]
    {
        // a program that cannot catch the signal is ended by it, and its files are whole all the same
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false)));
    }
}

/// Calls back at SIGINT, SIGTERM and SIGHUP, but for those that were ignored when the program began, as `nohup` and shells in the
/// background have it. A program that cannot catch a signal is ended by it, and its files are whole all the same.
#[cfg(unix)]
fn on_interruption(mut call_back: impl FnMut() + Send + 'static) {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let ignored = ignored_signals();
    let wanted = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0);
    if let Ok(mut signals) = signal_hook::iterator::Signals::new(wanted) {
        let _ = std::thread::Builder::new()
            .name("signals".to_owned())
            .spawn(move || signals.forever().for_each(|_| call_back()));
    }
}

#[cfg(not(unix))]
fn on_interruption(call_back: impl FnMut() + Send + 'static) {
    let _ = ctrlc::set_handler(call_back);
}

/// Signals that this process ignores, a bit each, where the system tells (Linux).
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    line.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}
