//! Progress bars: the only file that knows `indicatif`. Shown on a terminal, unless `-q`.

use crate::console::{Loudness, wants};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, stderr};
use std::time::Duration;

/// Progress of one input; silent where nobody is watching.
#[derive(Debug)]
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// A bar that names the input.
    pub(crate) fn new(input: &str) -> Self {
        if !stderr().is_terminal() || !wants(Loudness::Normal) {
            return Self(ProgressBar::hidden());
        }
        let bar = ProgressBar::with_draw_target(Some(1), ProgressDrawTarget::stderr_with_hz(10));
        // No colours at all, so NO_COLOR has nothing to switch off.
        let style = ProgressStyle::with_template(
            "{prefix} {msg:<9} {bar:30} {percent:>3} % {elapsed} (left: {eta})",
        );
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.set_prefix(input.to_owned());
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
    }
    /// A new stage begins.
    pub(crate) fn stage(&self, name: &'static str) {
        self.0.set_message(name);
        self.0.set_position(0);
    }
    /// `done` of `all` units of the stage are done.
    pub(crate) fn at(&self, done: u64, all: u64) {
        self.0.set_length(all.max(1));
        self.0.set_position(done);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
