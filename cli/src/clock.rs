//! Processor time of assets, and its limit.
//!
//! Threads work now for one asset, now for another, so the time of the process is shared out evenly
//! among the assets that are at work. Work checks its clock where a stage begins and where it
//! reports progress, and leaves by unwinding, as after a panic: only this asset fails. The only
//! asset of a run is ended with the process if it does neither for too long.

use crate::exit::{Failure, Status};
use crate::{console, interrupt};
use std::any::Any;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use std::{io, panic, process, thread};

/// How long a measured time of the process is used again: measuring it takes a microsecond. Chosen
/// by hand, far below the limits that people set.
const REUSE_TIME_FOR: Duration = Duration::from_millis(1);
/// How often a thread checks whether the only asset of a run is late. Chosen by hand: a late one
/// goes on for that long at most.
const CHECK_INTERVAL: Duration = Duration::from_millis(50);
/// Time beyond the limit in which work may leave by itself, which also writes a report. Chosen by
/// hand.
const GRACE: Duration = Duration::from_secs(1);

/// The time of the process as it is shared out.
struct Shares {
    /// Assets that are worked on now.
    assets_at_work: u32,
    /// Whether this run has several assets.
    has_several_assets: bool,
    /// Time of the process that has been shared out so far, and when it was measured.
    shared_out: Duration,
    measured_at: Option<Instant>,
    /// The share of an asset that has been worked on since the process began.
    asset_share: Duration,
}

// A global because so is the time of a process.
static SHARES: Mutex<Shares> = Mutex::new(Shares {
    assets_at_work: 0,
    has_several_assets: false,
    shared_out: Duration::ZERO,
    measured_at: None,
    asset_share: Duration::ZERO,
});

fn shares() -> MutexGuard<'static, Shares> {
    SHARES.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shares {
    /// Shares out the time since the last call. Returns `asset_share`.
    fn update(&mut self) -> Duration {
        if self.measured_at.is_none_or(|measured_at| measured_at.elapsed() >= REUSE_TIME_FOR) {
            let now = process_time();
            self.asset_share += now.saturating_sub(self.shared_out) / self.assets_at_work.max(1);
            (self.shared_out, self.measured_at) = (now, Some(Instant::now()));
        }
        self.asset_share
    }
}

/// Processor time of all threads of this process.
#[cfg(unix)]
fn process_time() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.try_into().unwrap_or_default()
}

/// Time since the first call: other systems are not asked for processor time.
#[cfg(not(unix))]
fn process_time() -> Duration {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    START.get_or_init(Instant::now).elapsed()
}

/// Tells whether a run has several assets: then a late one must not end the process.
pub(crate) fn expect_several(has_several_assets: bool) {
    shares().has_several_assets |= has_several_assets;
}

/// While this lives, one more asset is worked on.
pub(crate) struct AtWork(());

impl AtWork {
    pub(crate) fn new() -> Self {
        let mut shares = shares();
        shares.update();
        shares.assets_at_work += 1;
        Self(())
    }
}

impl Drop for AtWork {
    fn drop(&mut self) {
        let mut shares = shares();
        shares.update();
        shares.assets_at_work -= 1;
    }
}

/// The time that the work on one asset has taken. The default has no limit.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clock(Option<LimitedClock>);

#[derive(Clone, Debug)]
struct LimitedClock {
    /// The asset's path, for messages.
    name: String,
    limit: Duration,
    /// [`Shares::asset_share`] when the work began.
    start: Duration,
}

impl Clock {
    /// Starts a clock for the asset of this name.
    pub(crate) fn start(name: &Path, limit: Option<Duration>) -> Self {
        let Some(limit) = limit else { return Self(None) };
        let mut shares = shares();
        let clock =
            LimitedClock { name: name.display().to_string(), limit, start: shares.update() };
        if !shares.has_several_assets {
            let watching = clock.clone();
            thread::spawn(move || watching.end_late_work());
        }
        Self(Some(clock))
    }

    /// Leaves the work if its time is over: unwinds with a failure for [`time_limit_failure`].
    pub(crate) fn check(&self) {
        if let Some(clock) = self.0.as_ref().filter(|clock| clock.elapsed_share() >= clock.limit) {
            panic::resume_unwind(Box::new(clock.failure()));
        }
    }
}

impl LimitedClock {
    fn elapsed_share(&self) -> Duration {
        shares().update().saturating_sub(self.start)
    }

    fn failure(&self) -> Failure {
        let Self { name, limit, .. } = self;
        let what = format!(
            "{name}: took more than {} s of processor time (--limit time=SECONDS)",
            limit.as_secs_f64()
        );
        Failure::new(Status::Limit, what)
    }

    /// Ends the process once the work is late, unless results are already being written.
    fn end_late_work(&self) {
        while self.elapsed_share() < self.limit.saturating_add(GRACE) {
            thread::sleep(CHECK_INTERVAL);
        }
        let placed = interrupt::committing();
        let _whole = io::stdout().lock();
        if !*placed && !console::has_printed() {
            console::error(&self.failure());
            process::exit(Status::Limit.code().into());
        }
    }
}

/// The failure of a clock that left the work; none for the payload of a panic.
pub(crate) fn time_limit_failure(payload: &(dyn Any + Send)) -> Option<Failure> {
    payload.downcast_ref::<Failure>().cloned()
}
