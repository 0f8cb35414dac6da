//! Viewpoint metrics: a collapse costs what it changes in pictures from all sides (thesis 3.2.1 and
//! 4.2.1; Castelló et al. 2007), `C = Σ_v |H_v − H'_v|`, where H_v is the entropy of view v before
//! it and H'_v after it, or their divergence from the pictures of LOD 0 (`score`), with the quadric
//! where nothing that is seen changes.
//!
//! Every camera keeps the sorted list of everything behind each of its pixels, so that looking at a
//! collapse is exact, occlusion included, without drawing anything but the faces that move. All
//! areas are integers and stay those of a picture drawn afresh. What is hidden changes no picture
//! and goes first.
//!
//! Faces smaller than pixels leave nothing to count: as long as there is more than one
//! face for every eight pixels covered (all views together), the quadric alone decides.
//!
//! An *item* is what a pixel shows: a face, or the background.

mod candidate_view;
mod score;
#[cfg(test)]
mod tests;
mod view;

pub(crate) use candidate_view::ViewScratch;
pub(crate) use score::Score;

use crate::cut::{Corner, Wedges, WorkingMesh};
use crate::metric::reevaluate::{Reevaluate, cameras};
use lodc_raster::{Camera, Window, scan};
use rayon::prelude::*;
use score::{Table, log_area};
use view::{BACKGROUND, View};

/// Covered pixels per face, of all views together, from which on pictures can price a face. Below
/// that most faces cover no pixel in any view. Chosen by hand.
const PIXELS_PER_FACE: u64 = 8;
/// Meshes of fewer faces have smaller pictures, so that a face has as many pixels as one of these:
/// full ones take seconds even for a box and gain nothing (over eight meshes smaller ones have 0.98
/// times the image error of full ones on average, 1.1 at most).
const FULL_SIZE_FACES: f64 = 2_000.0;
/// Pixels across the smallest pictures, unless the options ask for fewer. Chosen by hand.
const MIN_SIZE: u32 = 48;

/// The most faces times candidates that are drawn for a group, the geometrically cheapest
/// candidates first: a bound on its time, chosen by hand.
const MAX_FACES_VIEWED: usize = 64;
/// The most candidates of a group that are drawn: all of most groups. Chosen by hand.
const MAX_CANDIDATES: usize = 8;
/// Weight of geometry beside what is seen, small enough to decide only where nothing seen changes.
/// Chosen by hand.
const GEOMETRY_WEIGHT: f64 = 1e-6;

/// The state of a viewpoint metric.
pub(crate) struct VisualMetric {
    score: Score,
    cameras: Vec<Camera>,
    /// Empty while the quadric decides.
    views: Vec<View>,
    table: Table,
    /// Logarithm of each face's area in space.
    log_areas: Vec<f64>,
    /// `Σ aᵢ log₂(aᵢ/Aᵢ)` of each view, over faces of `aᵢ` pixels and area `Aᵢ` in space.
    divergences: Vec<f64>,
    /// Pictures decide once there are no more faces than this.
    face_limit: u64,
    /// True once the legal phase is over.
    is_finished: bool,
}

impl VisualMetric {
    /// `size` is the most pixels across each picture.
    pub(crate) fn new(mesh: &WorkingMesh, score: Score, size: u32) -> Self {
        let size = picture_size(size.clamp(8, 1024), mesh.live_faces);
        let cameras = cameras(mesh, size);
        let covered: u64 = cameras.par_iter().map(|camera| covered(mesh, camera)).sum();
        Self {
            score,
            cameras,
            views: Vec::new(),
            table: Table::new((size * size) as usize),
            log_areas: Vec::new(),
            divergences: Vec::new(),
            face_limit: covered / PIXELS_PER_FACE,
            is_finished: false,
        }
    }

    fn start(&mut self, mesh: &WorkingMesh) {
        self.views = self.cameras.par_iter().map(|camera| View::new(mesh, camera)).collect();
        if self.score == Score::Divergence {
            self.log_areas =
                mesh.faces.par_iter().map(|f| log_area(mesh.area_of(f.groups))).collect();
            self.divergences = self.views.iter().map(|view| self.divergence(mesh, view)).collect();
        }
    }

    /// `Σ aᵢ log₂(aᵢ/Aᵢ)` of a view.
    fn divergence(&self, mesh: &WorkingMesh, view: &View) -> f64 {
        mesh.live().map(|face| self.term(view.area(face), self.log_areas[face as usize])).sum()
    }

    /// One face's part of that sum.
    fn term(&self, pixels: u32, log_area: f64) -> f64 {
        self.table.at(pixels) - f64::from(pixels) * log_area
    }

    /// Updates every view for a collapse whose faces have their new wedges but not yet their new
    /// groups.
    fn redraw(&mut self, mesh: &WorkingMesh, from: u32, to: u32) {
        if self.score == Score::Entropy {
            self.views
                .par_iter_mut()
                .with_min_len(10)
                .for_each(|view| view.collapse(mesh, from, to, |_, _, _| {}));
            return;
        }
        let star = mesh.star(from);
        let new: Vec<f64> = areas_after(mesh, from, to).collect();
        let (table, areas) = (&self.table, &self.log_areas);
        self.views.par_iter_mut().zip(&mut self.divergences).with_min_len(10).for_each(
            |(view, sum)| {
                view.collapse(mesh, from, to, |item, before, after| {
                    if item != BACKGROUND {
                        let pixels = f64::from(after) - f64::from(before);
                        *sum += table.at(after) - table.at(before) - pixels * areas[item as usize];
                    }
                });
                for (corner, new) in star.iter().zip(&new) {
                    *sum -=
                        f64::from(view.area(corner.face())) * (new - areas[corner.face() as usize]);
                }
            },
        );
        for (corner, new) in star.iter().zip(new) {
            self.log_areas[corner.face() as usize] = new;
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

    /// `|KL' − KL|` of one view for candidate `i`; `now` is the view's sum before the collapse.
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
        for (corner, &area) in star.iter().zip(&scratch.log_areas[i * star.len()..]) {
            let face = corner.face() as usize;
            let pixels = view.area(corner.face());
            let by = std::mem::take(&mut scratch.change[face]);
            sum += self.term(pixels.wrapping_add_signed(by), area)
                - self.term(pixels, self.log_areas[face]);
        }
        for &item in scratch.changed.iter().filter(|&&item| item != BACKGROUND) {
            let by = std::mem::take(&mut scratch.change[item as usize]);
            let (pixels, area) = (view.area(item), self.log_areas[item as usize]);
            sum += self.term(pixels.wrapping_add_signed(by), area) - self.term(pixels, area);
        }
        let covered = view.pixels() - view.area(BACKGROUND);
        let later = covered.wrapping_add_signed(-uncovered);
        (divergence(sum, later, &self.table) - divergence(now, covered, &self.table)).abs()
    }
}

/// Pixels across the pictures of a mesh with a number of faces.
fn picture_size(size: u32, faces: u32) -> u32 {
    let share = f64::from(faces) / FULL_SIZE_FACES;
    // Roots are exact to the last bit on every machine.
    ((f64::from(size) * share.sqrt()) as u32).clamp(MIN_SIZE.min(size), size)
}

/// Number of covered pixels of a picture.
fn covered(mesh: &WorkingMesh, camera: &Camera) -> u64 {
    let size = camera.size;
    let mut seen = vec![false; (size * size) as usize];
    for face in mesh.live() {
        let corners = mesh.faces[face as usize].groups.map(|g| camera.project(mesh.position(g)));
        scan(corners, Window::whole(size), |column, row, _| {
            seen[(row * size as i32 + column) as usize] = true;
        });
    }
    seen.into_iter().filter(|&s| s).count() as u64
}

/// The logarithm of the area in space of every face around `from` after its collapse onto `to`.
fn areas_after(mesh: &WorkingMesh, from: u32, to: u32) -> impl Iterator<Item = f64> + '_ {
    mesh.star(from).iter().map(move |corner| {
        let groups = mesh.faces[corner.face() as usize].groups;
        log_area(mesh.area_of(groups.map(|g| if g == from { to } else { g })))
    })
}

/// A view's divergence, given its sum and its covered pixels, without the constant `log₂ A`.
fn divergence(sum: f64, covered: u32, table: &Table) -> f64 {
    if covered == 0 { 0.0 } else { (sum - table.at(covered)) / f64::from(covered) }
}

impl Reevaluate for VisualMetric {
    const IS_LOCAL: bool = false;
    type ViewScratch = ViewScratch;

    fn collapsed(&mut self, mesh: &WorkingMesh, _wedges: &Wedges, from: u32, to: u32) {
        if self.is_active() {
            self.redraw(mesh, from, to);
        }
    }

    fn is_active(&self) -> bool {
        !self.views.is_empty()
    }

    fn activity_changes(&self, mesh: &WorkingMesh) -> bool {
        !self.is_active() && !self.is_finished && u64::from(mesh.live_faces) <= self.face_limit
    }

    fn update_activity(&mut self, mesh: &WorkingMesh, legal: bool) {
        if legal {
            if self.activity_changes(mesh) {
                self.start(mesh);
            }
        } else {
            self.views = Vec::new();
            self.is_finished = true;
        }
    }

    fn reevaluate(
        &self,
        mesh: &WorkingMesh,
        _wedges: &Wedges,
        from: u32,
        candidates: &mut [(f64, u32)],
        _only_cheapest: bool,
        scratch: &mut ViewScratch,
    ) {
        let star = mesh.star(from);
        scratch.prepare(mesh.faces.len(), star);
        let drawn = (MAX_FACES_VIEWED / star.len().max(1)).clamp(1, MAX_CANDIDATES);
        candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (priced, others) = candidates.split_at_mut(drawn.min(candidates.len()));
        scratch.seen.clear();
        scratch.seen.resize(priced.len(), 0.0);
        if self.score == Score::Divergence {
            scratch.log_areas.clear();
            for &(_, to) in priced.iter() {
                scratch.log_areas.extend(areas_after(mesh, from, to));
            }
        }
        for (v, view) in self.views.iter().enumerate() {
            let window = view.window(mesh, star);
            if window.is_empty() {
                continue;
            }
            scratch.gather(view, window);
            for (i, &(_, to)) in priced.iter().enumerate() {
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
        for (candidate, &seen) in priced.iter_mut().zip(&scratch.seen) {
            candidate.0 = seen + GEOMETRY_WEIGHT * candidate.0;
            worst = candidate.0.max(worst);
        }
        // Candidates that were not looked at come after all that were.
        for candidate in others {
            candidate.0 = worst + GEOMETRY_WEIGHT * candidate.0;
        }
    }
}
