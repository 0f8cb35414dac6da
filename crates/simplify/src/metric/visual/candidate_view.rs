//! What a collapse would change in a picture, found by drawing only the faces that it would move.
//! An *item* is what a pixel shows: a face, or the background.

use super::view::View;
use crate::cut::{Corner, WorkingMesh};
use lodc_raster::{Fragment, Window};

/// Buffers of one thread.
#[derive(Default)]
pub(crate) struct ViewScratch {
    /// For each face: the last epoch in which it was in the star that moves.
    marks: Vec<u32>,
    /// The number of the present star, so that marks need not be cleared.
    epoch: u32,
    /// For each pixel of the window: the front fragment without the star.
    base: Vec<Fragment>,
    /// For each pixel of the window: the nearest fragment of the moved star in front of `base`.
    moved: Vec<Fragment>,
    /// Pixels of the window where the star is seen, and which face of it.
    star_seen: Vec<(u32, u32)>,
    /// Pixels of the window where the moved star is.
    covered: Vec<u32>,
    /// For each face, and last for the background: the pixels that it gains.
    pub(super) change: Vec<i32>,
    /// The items with an entry in `change`, some of them twice.
    pub(super) changed: Vec<u32>,
    /// Logarithms of the areas in space of the moved star, candidate by candidate.
    pub(super) log_areas: Vec<f64>,
    /// What all pictures say that each candidate costs.
    pub(super) seen: Vec<f64>,
}

impl ViewScratch {
    /// Marks the faces of the star that is to move.
    pub(super) fn prepare(&mut self, faces: usize, star: &[Corner]) {
        if self.marks.len() < faces {
            self.marks.resize(faces, 0);
            // The last entry is the background's.
            self.change.resize(faces + 1, 0);
        }
        self.epoch = self.epoch.checked_add(1).unwrap_or_else(|| {
            self.marks.fill(0);
            1
        });
        for corner in star {
            self.marks[corner.face() as usize] = self.epoch;
        }
    }

    /// Stores the front fragments of a window without the star, and where the star is seen now.
    pub(super) fn gather(&mut self, view: &View, window: Window) {
        self.base.clear();
        self.base.resize(window.len(), Fragment::NOTHING);
        self.star_seen.clear();
        let Self { star_seen, base, marks, epoch, .. } = self;
        let in_star = |item: u32| marks.get(item as usize) == Some(epoch);
        let mut slots = (0..).zip(base);
        view.each_front(window, |pixel, front| {
            let Some((at, slot)) = slots.next() else { return };
            *slot = if in_star(front.item()) {
                star_seen.push((at, front.item()));
                view.behind(pixel, in_star)
            } else {
                front
            };
        });
        self.moved.clear();
        self.moved.resize(window.len(), Fragment::NOTHING);
    }

    /// Fills `change` with what the picture loses and gains if the star moves as given.
    pub(super) fn compare(
        &mut self,
        view: &View,
        window: Window,
        mesh: &WorkingMesh,
        from: u32,
        to: u32,
    ) {
        let Self { base, moved, covered, star_seen, change, changed, .. } = self;
        let width = window.width() as i32;
        covered.clear();
        changed.clear();
        for corner in mesh.star(from) {
            let groups = mesh.faces[corner.face() as usize].groups;
            if groups.contains(&to) {
                continue;
            }
            let groups = groups.map(|g| if g == from { to } else { g });
            view.cover(groups, corner.face(), window, |column, row, fragment| {
                let at = (row - window.top) * width + column - window.left;
                // What stays behind something else is not seen.
                if fragment < base[at as usize] {
                    let nearest = &mut moved[at as usize];
                    if *nearest == Fragment::NOTHING {
                        covered.push(at as u32);
                    }
                    *nearest = fragment.min(*nearest);
                }
            });
        }
        let background = change.len() - 1;
        let mut trade = |old: u32, new: u32| {
            for (item, by) in [(old, -1), (new, 1)] {
                let slot = &mut change[(item as usize).min(background)];
                if *slot == 0 {
                    changed.push(item);
                }
                *slot += by;
            }
        };
        for &(at, front) in star_seen.iter() {
            let new = moved[at as usize].min(base[at as usize]).item();
            moved[at as usize] = Fragment::NOTHING;
            if new != front {
                trade(front, new);
            }
        }
        for &at in covered.iter() {
            let new = std::mem::replace(&mut moved[at as usize], Fragment::NOTHING);
            if new != Fragment::NOTHING {
                trade(base[at as usize].item(), new.item());
            }
        }
    }
}
