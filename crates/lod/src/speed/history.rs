//! The history of strips, each by itself: what every record changes in it, until it draws nothing
//! any more.
//!
//! A place `p` of a strip holds `strip[p]`, then what that becomes, and so on, and changes at
//! exactly the records of these vertices. So strips need not know of each other, and all work on
//! one touches little memory.

use super::filter::{Filter, Leaving};
use super::working::WorkingStrip;
use crate::BuildError;
use crate::strips::STRIPS;
use lodc_mesh::{PositionIds, Simplified};
use lodc_strip::StripSet;
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;

/// How many changes a strip may have per index. Real strips have about five.
const MOST_CHANGES: usize = 300;

/// How elements that went come back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A vertex repetition: each element is the one before it.
    Vertex,
    /// An edge repetition: each element is the one two before it.
    Edge,
    /// What stood before the first triangle that is drawn. It was left where it was.
    Front,
    /// What stood behind the last triangle that is drawn. It was left where it was.
    Back,
}

impl Kind {
    /// All kinds, by the number that stands for them in files.
    pub(crate) const ALL: [Self; 4] = [Self::Vertex, Self::Edge, Self::Front, Self::Back];

    /// How far before it an element of a repetition finds its equal; 0 for ends.
    #[must_use]
    pub const fn period(self) -> u32 {
        match self {
            Self::Vertex => 1,
            Self::Edge => 2,
            Self::Front | Self::Back => 0,
        }
    }
}

/// Consecutive elements that a record takes out of a strip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Removal {
    /// Where the first of them stands before the record, counted from where the strip starts at LOD
    /// 0: what has gone at the front keeps its room.
    pub at: u32,
    /// How many they are.
    pub count: u32,
    /// How they come back.
    pub kind: Kind,
}

/// One record's changes of one strip; how many, the changes themselves stand one behind the other
/// in [`History`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Event {
    pub(crate) strip: u32,
    pub(crate) record: u32,
    pub(crate) changes: u32,
    pub(crate) removals: u32,
}

/// What happens to some consecutive strips, strip by strip, each in order of records. The event
/// without changes is the one with which a strip dies.
#[derive(Debug, Default)]
pub(crate) struct History {
    pub(crate) events: Vec<Event>,
    /// Places of a strip, as before the record, that change.
    pub(crate) changes: Vec<u32>,
    pub(crate) removals: Vec<Removal>,
    /// For each index of the strips the first LOD without it, `u32::MAX` if it is never removed.
    pub(crate) removed_at: Vec<u32>,
    /// For each index whether it is removed at the front of its strip.
    pub(crate) at_front: Vec<bool>,
    /// For each index that is removed at the front or back of its strip its place then, where it is
    /// left; for others `u32::MAX`.
    pub(crate) left_at: Vec<u32>,
    /// For each strip the first LOD at which it draws nothing.
    pub(crate) removal_lods: Vec<u32>,
}

/// Where removals come from: the filter, or a file.
pub(crate) trait Removals {
    /// Whether [`Self::begin`] is wanted.
    fn looks_ahead(&self) -> bool {
        false
    }
    /// A strip begins that dies with record `end`.
    fn begin(&mut self, _end: u32) {}
    /// Chooses the repetitions that one record takes out of a strip, and unlinks them.
    fn next(&mut self, strip: &mut WorkingStrip, changed: &[u32])
    -> Result<&[Leaving], BuildError>;
}

impl Removals for Filter<'_> {
    fn looks_ahead(&self) -> bool {
        true
    }
    fn begin(&mut self, end: u32) {
        self.end = end;
    }
    fn next(
        &mut self,
        strip: &mut WorkingStrip,
        changed: &[u32],
    ) -> Result<&[Leaving], BuildError> {
        self.apply(strip, changed);
        Ok(&self.gone)
    }
}

/// The history of all strips, with what the filter takes out: repetitions, and dead ends if `ends`.
///
/// # Errors
/// As [`Workshop::follow`].
pub(crate) fn of(
    simplified: &Simplified,
    strips: &StripSet,
    positions: &PositionIds,
    ends: bool,
) -> Result<Vec<History>, BuildError> {
    let targets = simplified.collapses().targets();
    in_parallel(strips, |workshop, range| {
        workshop.follow(strips, range, simplified, positions, &mut Filter::new(targets, ends))
    })
}

/// Works on runs of strips in parallel. The runs depend on the strips alone.
pub(crate) fn in_parallel<T: Send>(
    strips: &StripSet,
    work: impl Fn(&mut Workshop, Range<usize>) -> Result<T, BuildError> + Sync,
) -> Result<Vec<T>, BuildError> {
    const INDICES: usize = 1 << 14;
    let (mut runs, mut first, mut indices) = (Vec::new(), 0, 0);
    for (i, strip) in strips.iter().enumerate() {
        indices += strip.len();
        if indices >= INDICES || i + 1 == strips.len() {
            runs.push(first..i + 1);
            (first, indices) = (i + 1, 0);
        }
    }
    runs.into_par_iter().map_init(Workshop::default, |workshop, run| work(workshop, run)).collect()
}

/// What following strips needs, used for many of them.
#[derive(Debug, Default)]
pub(crate) struct Workshop {
    strip: WorkingStrip,
    /// Vertices with the elements that hold them, the next to disappear first.
    queue: BinaryHeap<Reverse<(u32, u32)>>,
    changed: Vec<u32>,
}

impl Workshop {
    /// Follows some strips.
    ///
    /// # Errors
    /// If `removals` fails, or strips change more often than those of any real mesh.
    pub(crate) fn follow(
        &mut self,
        strips: &StripSet,
        range: Range<usize>,
        simplified: &Simplified,
        positions: &PositionIds,
        removals: &mut impl Removals,
    ) -> Result<History, BuildError> {
        let mut history = History::default();
        for strip in range {
            self.follow_one(
                strip as u32,
                strips.strip(strip),
                simplified,
                positions,
                removals,
                &mut history,
            )?;
        }
        Ok(history)
    }

    fn follow_one(
        &mut self,
        id: u32,
        strip: &[u32],
        simplified: &Simplified,
        positions: &PositionIds,
        removals: &mut impl Removals,
        history: &mut History,
    ) -> Result<(), BuildError> {
        let targets = simplified.collapses().targets();
        let removed_from = history.removed_at.len();
        let first_change = history.changes.len();
        history.removed_at.resize(removed_from + strip.len(), u32::MAX);
        history.at_front.resize(removed_from + strip.len(), false);
        history.left_at.resize(removed_from + strip.len(), u32::MAX);
        if removals.looks_ahead() {
            let end = self.end(strip, targets, positions);
            removals.begin(end);
        }
        self.start(strip, positions);
        let mut removal_lod = 0;
        while self.strip.is_live() {
            let record = self.take_next();
            let Some(&target) = targets.get(record as usize) else {
                removal_lod = u32::MAX;
                break;
            };
            for &element in &self.changed {
                self.strip.change(element, target);
            }
            for &element in &self.changed {
                self.strip.settle(element, positions);
                self.queue.push(Reverse((target, element)));
            }
            removal_lod = record + 1;
            if !self.strip.is_live() {
                history.events.push(Event { strip: id, record, changes: 0, removals: 0 });
                break;
            }
            let gone = removals.next(&mut self.strip, &self.changed)?;
            let event = Event {
                strip: id,
                record,
                changes: self.changed.len() as u32,
                removals: gone.len() as u32,
            };
            history.events.push(event);
            history.changes.extend(self.changed.iter().map(|&e| self.strip.place(e)));
            if history.changes.len() - first_change > MOST_CHANGES * (strip.len() + 100) {
                let what = "would need far more changes than it has indices".to_owned();
                return Err(BuildError::Malformed { array: STRIPS, what });
            }
            for r in gone {
                history.removals.push(Removal {
                    at: self.strip.place(r.first),
                    count: r.count,
                    kind: r.kind,
                });
            }
            let removals = &history.removals[history.removals.len() - gone.len()..];
            for (r, at) in gone.iter().zip(removals.iter().map(|removal| removal.at)) {
                let mut element = r.first;
                for k in 0..r.count {
                    self.strip.forget(element);
                    let index = removed_from + WorkingStrip::number(element);
                    history.removed_at[index] = removal_lod;
                    history.at_front[index] = r.kind == Kind::Front;
                    history.left_at[index] = if r.kind.period() == 0 { at + k } else { u32::MAX };
                    element = self.strip.next(element);
                }
                if r.kind == Kind::Front {
                    self.strip.leave_room(r.count);
                }
            }
        }
        history.removal_lods.push(removal_lod);
        Ok(())
    }

    fn start(&mut self, strip: &[u32], positions: &PositionIds) {
        self.strip.start(strip, positions);
        self.queue.clear();
        self.queue.extend((0..).zip(strip).map(|(i, &v)| Reverse((v, WorkingStrip::element(i)))));
    }

    /// The record with which a strip dies: the last one that matters to it.
    fn end(&mut self, strip: &[u32], targets: &[u32], positions: &PositionIds) -> u32 {
        self.start(strip, positions);
        let (mut end, mut changes) = (0, 0);
        // Beyond this the strip is refused anyway.
        while self.strip.is_live() && changes <= MOST_CHANGES * (strip.len() + 100) {
            end = self.take_next();
            changes += self.changed.len();
            let Some(&target) = targets.get(end as usize) else { break };
            for &element in &self.changed {
                self.strip.change(element, target);
            }
            for &element in &self.changed {
                self.strip.settle(element, positions);
                self.queue.push(Reverse((target, element)));
            }
        }
        end
    }

    /// Puts the elements of the next vertex to disappear into `changed`, and says which it is. A
    /// live strip has one.
    fn take_next(&mut self) -> u32 {
        self.changed.clear();
        let mut vertex = u32::MAX;
        while let Some(&Reverse((v, element))) = self.queue.peek() {
            if self.strip.is_left(element) {
                if !self.changed.is_empty() && v != vertex {
                    break;
                }
                vertex = v;
                self.changed.push(element);
            }
            self.queue.pop();
        }
        vertex
    }
}
