//! How far a run is, on a terminal as a bar, elsewhere as a line every few seconds.

use crate::console::Console;
use estar_deck::format::{duration, prefixed};
use estar_session::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

const LINE_INTERVAL: Duration = Duration::from_secs(5);
/// Ticks of the bar from beginning to end.
const BAR_LENGTH: u64 = 1000;

/// Shows how far a run is.
#[derive(Debug)]
pub struct Bar {
    bar: Option<ProgressBar>,
    line_due: Instant,
}

impl Bar {
    /// The bar of a run that begins now; lines in its place where there is no terminal, or nothing is to be printed.
    pub fn start(console: &Console) -> Self {
        let bar = (!console.is_quiet() && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::with_draw_target(Some(BAR_LENGTH), ProgressDrawTarget::stderr());
            let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {prefix} left\n{msg}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar
        });
        Self { bar, line_due: Instant::now() + LINE_INTERVAL }
    }

    /// Shows how far the run is.
    pub fn show(&mut self, progress: &Progress, console: &mut Console) {
        if let Some(bar) = &self.bar {
            bar.set_position((BAR_LENGTH as f64 * progress.time / progress.end_time) as u64);
            bar.set_prefix(duration(progress.seconds_left));
            bar.set_message(in_words(progress));
        }
        let now = Instant::now();
        if now >= self.line_due {
            self.line_due = now + LINE_INTERVAL;
            let percent = 100.0 * progress.time / progress.end_time;
            let left = duration(progress.seconds_left);
            let line = format!("{percent:5.1} %  {}  {left} left", in_words(progress));
            if self.bar.is_some() { console.note(&line) } else { console.say(&line) }
        }
    }

    /// Does something while the bar is not in the way.
    pub fn beside(&self, work: impl FnOnce()) {
        match &self.bar {
            Some(bar) => bar.suspend(work),
            None => work(),
        }
    }

    /// Takes the bar away.
    pub fn end(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

fn in_words(progress: &Progress) -> String {
    format!(
        "t {:.4e} s  step {}  dt {:.3e} s  {}element steps/s  energy error {:+.3} %",
        progress.time,
        progress.step,
        progress.time_step,
        prefixed(progress.element_steps_per_second),
        100.0 * progress.energy_error
    )
}
