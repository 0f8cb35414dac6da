//! The context that all regions share while they are being simplified.

use crate::number::input::Input;
use crate::options::Options;
use crate::price::attributes::Attributes;
use std::sync::atomic::{AtomicU64, Ordering};

/// The data that all regions read.
pub(crate) struct Context<'a> {
    pub(crate) input: &'a Input<'a>,
    pub(crate) options: Options,
    pub(crate) attributes: Attributes,
}

impl Context<'_> {
    /// Returns whether wedges are groups, and nothing about them is compared.
    pub(crate) fn is_bare(&self) -> bool {
        self.input.one_wedge_each() && self.attributes.is_empty()
    }
}

/// Reports of progress from all threads.
pub(crate) struct Progress<'a> {
    report: &'a (dyn Fn(u64, u64) + Sync),
    /// Collapses of the rounds that are over.
    done: AtomicU64,
    groups: u64,
}

impl<'a> Progress<'a> {
    pub(crate) fn new(report: &'a (dyn Fn(u64, u64) + Sync), groups: u64) -> Self {
        Self { report, done: AtomicU64::new(0), groups }
    }

    /// Reports collapses since the end of the last round.
    pub(crate) fn report(&self, steps: u64) {
        (self.report)((self.done.load(Ordering::Relaxed) + steps).min(self.groups), self.groups);
    }

    /// Ends a round with so many collapses.
    pub(crate) fn end_round(&self, steps: u64) {
        self.done.fetch_add(steps, Ordering::Relaxed);
        self.report(0);
    }
}
