//! Looking at collapses that have not happened: what each would change in every picture.

use super::score::{Score, log_area};
use super::view::{BACKGROUND, View};
use super::{VisualMetric, divergence};
use crate::cut::mesh::{Corner, WorkingMesh};
use lodc_raster::{Fragment, Window};

/// Faces times candidates that are looked at; beyond, only the geometrically cheapest are.
const PATIENCE: usize = 64;
/// No more candidates than this are looked at.
const MOST: usize = 8;
/// Weight of geometry beside what is seen: it decides where nothing is.
pub(crate) const TIE: f64 = 1e-6;

/// Buffers of one thread.
#[derive(Default)]
pub(crate) struct ViewScratch {
    /// For each face: the epoch in which it was in the star looked at.
    marks: Vec<u32>,
    epoch: u32,
    /// For each pixel of the window: what is seen without the star, and the nearest of the moved
    /// star before that.
    base: Vec<Fragment>,
    moved: Vec<Fragment>,
    /// Pixels of the window where the star is seen, and which face of it.
    star_seen: Vec<(u32, u32)>,
    /// Pixels of the window where the moved star is.
    covered: Vec<u32>,
    /// For each item that changes: by how many pixels.
    change: Vec<i32>,
    changed: Vec<u32>,
    /// Logarithms of the areas in space of the moved star, candidate by candidate.
    areas: Vec<f64>,
    seen: Vec<f64>,
}

impl ViewScratch {
    fn prepare(&mut self, faces: usize, star: &[Corner]) {
        if self.marks.len() < faces {
            self.marks.resize(faces, 0);
            // The last place is the background's.
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

    /// Notes what is seen in a window without the star, and where the star is seen now.
    fn gather(&mut self, view: &View, window: Window) {
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
    fn compare(&mut self, view: &View, window: Window, mesh: &WorkingMesh, from: u32, to: u32) {
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
                // What stays behind something else is as good as not there.
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

impl VisualMetric {
    /// Sums over all views how much the score changes, for
    /// [`Reprice::reprice`](crate::metric::Reprice::reprice).
    pub(crate) fn see(
        &self,
        mesh: &WorkingMesh,
        from: u32,
        candidates: &mut [(f64, u32)],
        scratch: &mut ViewScratch,
    ) {
        let star = mesh.star(from);
        scratch.prepare(mesh.faces.len(), star);
        let looked_at = (PATIENCE / star.len().max(1)).clamp(1, MOST);
        candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (near, far) = candidates.split_at_mut(looked_at.min(candidates.len()));
        scratch.seen.clear();
        scratch.seen.resize(near.len(), 0.0);
        if self.score == Score::Divergence {
            measure(mesh, from, near, &mut scratch.areas);
        }
        for (v, view) in self.views.iter().enumerate() {
            let window = view.window(mesh, star);
            if window.is_empty() {
                continue;
            }
            scratch.gather(view, window);
            for (i, &(_, to)) in near.iter().enumerate() {
                scratch.compare(view, window, mesh, from, to);
                scratch.seen[i] += match self.score {
                    Score::Entropy => self.entropy_change(view, scratch),
                    Score::Divergence => {
                        self.divergence_change(view, self.divergences[v], star, i, scratch)
                    }
                };
            }
        }
        let mut worst = 0.0;
        for (candidate, &seen) in near.iter_mut().zip(&scratch.seen) {
            candidate.0 = seen + TIE * candidate.0;
            worst = candidate.0.max(worst);
        }
        for candidate in far {
            candidate.0 = worst + TIE * candidate.0;
        }
    }

    /// `|H' − H|` of one view.
    fn entropy_change(&self, view: &View, scratch: &mut ViewScratch) -> f64 {
        let background = scratch.change.len() - 1;
        let mut sum = 0.0;
        for &item in &scratch.changed {
            let by = std::mem::take(&mut scratch.change[(item as usize).min(background)]);
            let area = view.area(item);
            sum += self.table.at(area.wrapping_add_signed(by)) - self.table.at(area);
        }
        sum.abs() / f64::from(view.pixels())
    }

    /// `|KL' − KL|` of one view; `now` is its sum.
    fn divergence_change(
        &self,
        view: &View,
        now: f64,
        star: &[Corner],
        i: usize,
        scratch: &mut ViewScratch,
    ) -> f64 {
        let background = scratch.change.len() - 1;
        let uncovered = std::mem::take(&mut scratch.change[background]);
        let mut sum = now;
        for (corner, &area) in star.iter().zip(&scratch.areas[i * star.len()..]) {
            let face = corner.face() as usize;
            let pixels = view.area(corner.face());
            let by = std::mem::take(&mut scratch.change[face]);
            sum += self.term(pixels.wrapping_add_signed(by), area)
                - self.term(pixels, self.areas[face]);
        }
        for &item in scratch.changed.iter().filter(|&&item| item != BACKGROUND) {
            let by = std::mem::take(&mut scratch.change[item as usize]);
            let (pixels, area) = (view.area(item), self.areas[item as usize]);
            sum += self.term(pixels.wrapping_add_signed(by), area) - self.term(pixels, area);
        }
        let covered = view.pixels() - view.area(BACKGROUND);
        let later = covered.wrapping_add_signed(-uncovered);
        (divergence(sum, later, &self.table) - divergence(now, covered, &self.table)).abs()
    }
}

/// The logarithm of the area in space of every face around `from`, for each candidate after its
/// collapse.
fn measure(mesh: &WorkingMesh, from: u32, candidates: &[(f64, u32)], areas: &mut Vec<f64>) {
    areas.clear();
    for &(_, to) in candidates {
        for corner in mesh.star(from) {
            let groups = mesh.faces[corner.face() as usize].groups;
            areas.push(log_area(mesh.area_of(groups.map(|g| if g == from { to } else { g }))));
        }
    }
}
