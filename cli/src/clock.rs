//! Processor time of assets, and its limit.
//!
//! Threads work now for one asset, now for another, so the time of the process is shared out evenly
//! among the assets that are at work. Work looks at its clock where a stage begins and where it
//! reports progress, and leaves by unwinding, as after a panic: this asset alone has failed. A
//! single asset in the midst of a stage that does neither is ended with the process.

use crate::exit::{Failure, Status};
use crate::{console, interrupt};
use std::any::Any;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use std::{io, panic, process, thread};

/// How long a time of the process is good for: asking the system takes a microsecond.
const FRESH: Duration = Duration::from_millis(1);
/// How often it is looked whether a single asset has to be ended.
const LOOK: Duration = Duration::from_millis(50);
/// Time beyond the limit in which work may leave by itself, which also gives a report.
const GRACE: Duration = Duration::from_secs(1);

/// The time of the process as it is shared out.
struct Shares {
    /// Assets at work.
    at_work: u32,
    /// Assets of this run.
    several: bool,
    /// Time of the process that has been shared out, and when that was.
    counted: Duration,
    asked: Option<Instant>,
    /// The share of an asset that has been at work all the time.
    each: Duration,
}

// A global because so is the time of a process.
static SHARES: Mutex<Shares> = Mutex::new(Shares {
    at_work: 0,
    several: false,
    counted: Duration::ZERO,
    asked: None,
    each: Duration::ZERO,
});

fn shares() -> MutexGuard<'static, Shares> {
    SHARES.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shares {
    /// Shares out what has been taken since the last time.
    fn share(&mut self) -> Duration {
        if self.asked.is_none_or(|asked| asked.elapsed() >= FRESH) {
            let now = process_time();
            self.each += now.saturating_sub(self.counted) / self.at_work.max(1);
            (self.counted, self.asked) = (now, Some(Instant::now()));
        }
        self.each
    }
}

/// Processor time of all threads of this process.
#[cfg(unix)]
fn process_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.try_into().unwrap_or_default()
}

/// Time since this was first asked: other systems are not asked for more.
#[cfg(not(unix))]
fn process_time() -> Duration {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    START.get_or_init(Instant::now).elapsed()
}

/// Says whether a run has several assets: then the process must not end with one.
pub(crate) fn expect_several(several: bool) {
    shares().several |= several;
}

/// An asset is at work for as long as this lives.
pub(crate) struct Turn(());

impl Turn {
    pub(crate) fn new() -> Self {
        let mut shares = shares();
        shares.share();
        shares.at_work += 1;
        Self(())
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        let mut shares = shares();
        shares.share();
        shares.at_work -= 1;
    }
}

/// The time that the work on one asset has taken. The default has no limit.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clock(Option<Limited>);

#[derive(Clone, Debug)]
struct Limited {
    /// The asset's name.
    name: String,
    limit: Duration,
    /// The share of an asset when this one began.
    start: Duration,
}

impl Clock {
    /// Starts a clock for the asset of this name.
    pub(crate) fn start(name: &Path, limit: Option<Duration>) -> Self {
        let Some(limit) = limit else { return Self(None) };
        let mut shares = shares();
        let clock = Limited { name: name.display().to_string(), limit, start: shares.share() };
        if !shares.several {
            let watched = clock.clone();
            thread::spawn(move || watched.end_late_work());
        }
        Self(Some(clock))
    }

    /// Leaves the work if it has taken all of its time: unwinds with a failure, for [`left`].
    pub(crate) fn check(&self) {
        if let Some(clock) = self.0.as_ref().filter(|clock| clock.taken() >= clock.limit) {
            panic::resume_unwind(Box::new(clock.failure()));
        }
    }
}

impl Limited {
    fn taken(&self) -> Duration {
        shares().share().saturating_sub(self.start)
    }

    fn failure(&self) -> Failure {
        let Self { name, limit, .. } = self;
        let what = format!(
            "{name}: took more than {} s of processor time (--limit time=SECONDS)",
            limit.as_secs_f64()
        );
        Failure::new(Status::Limit, what)
    }

    /// Ends the process when the work is late, unless results are on their way.
    fn end_late_work(&self) {
        while self.taken() < self.limit.saturating_add(GRACE) {
            thread::sleep(LOOK);
        }
        let placed = interrupt::committing();
        let _whole = io::stdout().lock();
        if !*placed && !console::has_printed() {
            console::error(&self.failure());
            process::exit(Status::Limit.code().into());
        }
    }
}

/// The failure with which a clock has left work; none if something else unwound.
pub(crate) fn left(payload: &(dyn Any + Send)) -> Option<Failure> {
    payload.downcast_ref::<Failure>().cloned()
}
