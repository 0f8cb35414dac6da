//! Progress bars: the only file that knows `indicatif`. Shown on a terminal, unless `-q`; lines fit
//! 60 columns.

use crate::console::{self, Loudness, wants};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::time::Duration;

// No colours, so NO_COLOR changes nothing.
// The input's name has 14 columns, see `Progress::new`.
const COUNTED: &str = "{prefix:14!} {msg:<9} {bar:12} {percent:>3} % {elapsed:>4} (left: {eta:>3})";
const UNCOUNTED: &str = "{prefix:14!} {msg:<9} {spinner} {elapsed:>4}";

/// Progress of one input; silent unless standard error is a terminal.
#[derive(Debug)]
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// A bar that names the input, by its end if it is long.
    pub(crate) fn new(input: &str) -> Self {
        if !stderr().is_terminal() || !wants(Loudness::Normal) {
            return Self(ProgressBar::hidden());
        }
        let bar = ProgressBar::with_draw_target(Some(1), ProgressDrawTarget::stderr_with_hz(10));
        let start = input.char_indices().rev().nth(13).map_or(0, |(at, _)| at);
        bar.set_prefix(input[start..].to_owned());
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
    }
    /// A bar that is never shown.
    pub(crate) fn hidden() -> Self {
        Self(ProgressBar::hidden())
    }
    /// Takes the bar off the terminal.
    pub(crate) fn clear(&self) {
        self.0.finish_and_clear();
    }
    /// Begins a stage whose units are not counted.
    pub(crate) fn stage(&self, name: &'static str) {
        self.begin(name, UNCOUNTED, 1);
    }
    /// Begins a stage of `units` units.
    pub(crate) fn stage_with_units(&self, name: &'static str, units: u64) {
        self.begin(name, COUNTED, units.max(1));
    }
    /// Adds units of the stage that are done.
    pub(crate) fn add(&self, units: u64) {
        self.0.inc(units);
    }

    fn begin(&self, name: &'static str, template: &str, units: u64) {
        let style = ProgressStyle::with_template(template);
        self.0.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        self.0.set_message(name);
        self.0.set_length(units);
        self.0.set_position(0);
        self.0.reset_eta();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// Progress of a run: `[i/n]` and the asset that was done last. The only asset of a run has a bar
/// of its own instead.
#[derive(Debug)]
pub(crate) struct BatchProgress {
    bar: ProgressBar,
    is_single: bool,
}

impl BatchProgress {
    /// A bar for `assets` assets.
    pub(crate) fn new(assets: usize) -> Self {
        let is_single = assets < 2;
        if is_single || !stderr().is_terminal() || !wants(Loudness::Normal) {
            return Self { bar: ProgressBar::hidden(), is_single };
        }
        let target = ProgressDrawTarget::stderr_with_hz(10);
        let bar = ProgressBar::with_draw_target(Some(assets as u64), target);
        let style = ProgressStyle::with_template("[{pos}/{len}] {msg:20!} {bar:12} {elapsed}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        let bar_in_hook = bar.clone();
        console::set_print_hook(Some(Box::new(move |print| bar_in_hook.suspend(print))));
        Self { bar, is_single }
    }
    /// Progress of one asset of the run.
    pub(crate) fn of_asset(&self, name: &str) -> Progress {
        if self.is_single { Progress::new(name) } else { Progress::hidden() }
    }
    /// Counts one more asset as done.
    pub(crate) fn done(&self, name: &str) {
        self.bar.set_message(name.to_owned());
        self.bar.inc(1);
    }
}

impl Drop for BatchProgress {
    fn drop(&mut self) {
        console::set_print_hook(None);
        self.bar.finish_and_clear();
    }
}
