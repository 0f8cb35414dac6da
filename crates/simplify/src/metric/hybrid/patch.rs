//! The faces whose shading a collapse changes: those that move, and those that share a corner with
//! them.

use super::appearance::{Appearance, Colour};
use super::knob::knob;
use super::pixel::shading_error;
use super::samples::{CREASE, Sample, Samples, mix, mix2};
use crate::wedges::Wedges;
use crate::working::Working;
use glam::Vec3;

/// What counts for a place of the input that nothing stands for any more, beside a normal that is
/// off by one (60°): about as much as a pixel that shows the background differs from a lit one.
const LOST: f32 = 1.5;
/// What counts for a place of a face where the input has nothing.
const FOREIGN: f32 = 2.0;
/// The input is near where a sample is nearer than this many times its extent.
const NEAR: f32 = 1.5;
/// A place counts for no more than this, however far away it is: a pixel can be no more than wrong.
const WORST: f32 = 3.0;
/// Where moved faces are looked at for that: shares of the second and third corner.
const PLACES: [[f32; 2]; 4] = [
    [1.0 / 3.0, 1.0 / 3.0],
    [2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0],
    [1.0 / 6.0, 1.0 / 6.0],
];

/// Stars with more faces than this are looked at without the faces around them.
const WIDE: usize = 32;

/// A face with the normals that it is shaded with.
#[derive(Clone, Copy, Debug)]
struct Shaded {
    face: u32,
    /// Its corners, as vertices of the patch; `u32::MAX` for those that are none.
    corners: [u32; 3],
    normal: Vec3,
    shading: [Vec3; 3],
    submesh: u32,
    /// Texture coordinates of its corners.
    texture: [[f32; 2]; 3],
}

/// Where a moved face lies, so that samples find their place in it.
#[derive(Clone, Copy, Debug)]
struct Placed {
    origin: Vec3,
    edges: [Vec3; 2],
    /// The dual basis of the edges.
    dual: [Vec3; 2],
    /// Inverse squared lengths of the edges from the origin and of the third; zero if it has none.
    inverse: [f32; 3],
}

impl Placed {
    /// The place of these shares.
    fn at(&self, [u, v]: [f32; 2]) -> Vec3 {
        self.origin + self.edges[0] * u + self.edges[1] * v
    }

    fn new(corners: [Vec3; 3]) -> (Self, Vec3) {
        let [e1, e2] = [corners[1] - corners[0], corners[2] - corners[0]];
        let n = e1.cross(e2);
        let invert = |x: f32| if x > 0.0 { 1.0 / x } else { 0.0 };
        let inverse = invert(n.length_squared());
        let dual = [e2.cross(n) * inverse, n.cross(e1) * inverse];
        let lengths = [e1, e2, e2 - e1].map(|e| invert(e.length_squared()));
        let placed = Self { origin: corners[0], edges: [e1, e2], dual, inverse: lengths };
        (placed, n * inverse.sqrt())
    }

    /// The nearest place in the triangle: shares of two corners, and the squared distance.
    #[inline]
    fn locate(&self, point: Vec3) -> ([f32; 2], f32) {
        let r = point - self.origin;
        let (u, v) = (r.dot(self.dual[0]), r.dot(self.dual[1]));
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && self.dual[0] != Vec3::ZERO;
        let at = if inside { [u, v] } else { self.on_edge(r) };
        (at, (self.edges[0] * at[0] + self.edges[1] * at[1] - r).length_squared())
    }

    /// The nearest place on the triangle's edges to a point, given from the origin.
    fn on_edge(&self, r: Vec3) -> [f32; 2] {
        let [e1, e2] = self.edges;
        let s = (r.dot(e1) * self.inverse[0]).clamp(0.0, 1.0);
        let t = (r.dot(e2) * self.inverse[1]).clamp(0.0, 1.0);
        let w = ((r - e1).dot(e2 - e1) * self.inverse[2]).clamp(0.0, 1.0);
        let mut best = ([s, 0.0], (e1 * s - r).length_squared());
        for at in [[0.0, t], [1.0 - w, w]] {
            let squared = (e1 * at[0] + e2 * at[1] - r).length_squared();
            if squared < best.1 {
                best = (at, squared);
            }
        }
        best.0
    }
}

/// Buffers of one thread, and the patch that they hold.
#[derive(Default)]
pub(crate) struct Patch {
    /// For each group: the epoch in which it was a vertex of the patch, and which.
    vertex_of: Vec<(u32, u32)>,
    /// For each face: the epoch in which it was in the patch.
    marks: Vec<u32>,
    epoch: u32,
    /// The groups next to the one that moves.
    ring: Vec<u32>,
    /// For each of them, where the normals of its faces that stay begin.
    fixed_start: Vec<u32>,
    fixed: Vec<Vec3>,
    /// Faces around the star. Their shading holds the part that stays, not yet of unit length.
    far: Vec<Shaded>,
    /// Faces of the star that move, and where to.
    moved: Vec<Shaded>,
    placed: Vec<Placed>,
    /// Wedges of the group that moves, and those at the target that they share a face with.
    targets: Vec<(u32, u32)>,
    /// Samples of the star.
    pub(super) samples: Vec<u32>,
    /// What the whole patch counts for at present.
    pub(super) present: f64,
    /// How much of the star is seen: 0 nothing, 1 as much as of a face with nothing before it.
    pub(super) seen: f64,
}

/// The cosine between a sample's normal and the one it is shaded with at a place of a face.
#[inline]
fn cosine(shading: &[Vec3; 3], at: [f32; 2], normal: Vec3) -> f32 {
    let n = mix(shading, at);
    let length = n.length();
    if length > 0.0 { n.dot(normal) / length } else { 0.5 }
}

impl Patch {
    /// Gathers what is around a group. `energy` is what each face counts for at present.
    pub(super) fn gather(
        &mut self,
        mesh: &Working,
        appearance: &Appearance<'_>,
        from: u32,
        samples: &Samples,
        energy: &[f64],
    ) {
        let star = mesh.star(from);
        self.start(mesh);
        self.present = 0.0;
        let (mut seen, mut area) = (0.0, 0.0);
        for &corner in star {
            for s in samples.of(corner.face()).map(|s| samples.get(s)) {
                area += f64::from(s.extent * s.extent);
                seen += f64::from(s.weight);
            }
            self.marks[corner.face() as usize] = self.epoch;
            self.present += energy[corner.face() as usize];
            self.samples.extend(samples.of(corner.face()));
            for g in mesh.others(corner) {
                if self.vertex_of[g as usize].0 != self.epoch {
                    self.vertex_of[g as usize] = (self.epoch, self.ring.len() as u32);
                    self.ring.push(g);
                }
            }
        }
        self.seen = if area > seen { seen / area } else { 1.0 };
        if appearance.has_normals() {
            return;
        }
        for i in 0..self.ring.len() {
            self.fixed_start.push(self.fixed.len() as u32);
            for &corner in mesh.star(self.ring[i]) {
                let f = &mesh.faces[corner.face() as usize];
                if !f.groups.contains(&from) {
                    self.fixed.push(f.normal);
                }
            }
        }
        self.fixed_start.push(self.fixed.len() as u32);
        if star.len() > WIDE {
            return;
        }
        for i in 0..self.ring.len() {
            for &corner in mesh.star(self.ring[i]) {
                let face = corner.face();
                if self.marks[face as usize] != self.epoch {
                    self.marks[face as usize] = self.epoch;
                    self.present += energy[face as usize];
                    self.add_far(mesh, face);
                }
            }
        }
    }

    fn start(&mut self, mesh: &Working) {
        if self.marks.len() < mesh.faces.len() {
            self.marks.resize(mesh.faces.len(), 0);
            self.vertex_of.resize(mesh.places.len(), (0, 0));
        }
        self.epoch = self.epoch.checked_add(1).unwrap_or_else(|| {
            self.marks.fill(0);
            self.vertex_of.fill((0, 0));
            1
        });
        self.ring.clear();
        self.fixed_start.clear();
        self.fixed.clear();
        self.far.clear();
        self.samples.clear();
    }

    fn vertex(&self, group: u32) -> u32 {
        let (epoch, vertex) = self.vertex_of[group as usize];
        if epoch == self.epoch { vertex } else { u32::MAX }
    }

    fn add_far(&mut self, mesh: &Working, face: u32) {
        let f = &mesh.faces[face as usize];
        let corners = f.groups.map(|g| self.vertex(g));
        let shading = [0, 1, 2].map(|c| match corners[c] {
            u32::MAX => {
                let normals =
                    mesh.star(f.groups[c]).iter().map(|c| mesh.faces[c.face() as usize].normal);
                smooth(normals, f.normal)
            }
            vertex => smooth(self.fixed_at(vertex).iter().copied(), f.normal),
        });
        self.far.push(Shaded {
            face,
            corners,
            normal: f.normal,
            shading,
            submesh: 0,
            texture: [[0.0; 2]; 3],
        });
    }

    fn fixed_at(&self, vertex: u32) -> &[Vec3] {
        let start = &self.fixed_start[vertex as usize..];
        &self.fixed[start[0] as usize..start[1] as usize]
    }

    /// Moves the star to `to` and shades what moves.
    pub(super) fn move_to(
        &mut self,
        mesh: &Working,
        wedges: &Wedges,
        appearance: &Appearance<'_>,
        from: u32,
        to: u32,
    ) {
        self.moved.clear();
        self.placed.clear();
        self.find_targets(mesh, from, to);
        for &corner in mesh.star(from) {
            let face = corner.face();
            let groups = mesh.faces[face as usize].groups;
            if groups.contains(&to) {
                continue;
            }
            let groups = groups.map(|g| if g == from { to } else { g });
            let (placed, normal) = Placed::new(groups.map(|g| mesh.places[g as usize].position));
            let corners = groups.map(|g| self.vertex(g));
            let mut own = mesh.wedges(face);
            let submesh = wedges.submesh[own[0] as usize];
            own[corner.at()] = self.target(wedges, own[corner.at()]);
            let vertices = own.map(|w| wedges.attributes_of[w as usize]);
            let shading = if appearance.has_normals() {
                vertices.map(|v| appearance.normal(v))
            } else {
                [normal; 3]
            };
            let texture = vertices.map(|v| appearance.place(v));
            self.moved.push(Shaded { face, corners, normal, shading, submesh, texture });
            self.placed.push(placed);
        }
        if appearance.has_normals() {
            return;
        }
        for i in 0..self.moved.len() {
            let own = self.moved[i];
            self.moved[i].shading = own.corners.map(|vertex| {
                let fixed = smooth(self.fixed_at(vertex).iter().copied(), own.normal);
                (fixed + self.moving_at(vertex, own.normal)).normalize_or_zero()
            });
        }
    }

    /// Finds the wedges that lose a face between `from` and `to`, and their counterparts.
    fn find_targets(&mut self, mesh: &Working, from: u32, to: u32) {
        self.targets.clear();
        if mesh.one_wedge_each() {
            self.targets.push((from, to));
            return;
        }
        for &corner in mesh.star(from) {
            let face = corner.face();
            let groups = mesh.faces[face as usize].groups;
            if let Some(end) = groups.iter().position(|&g| g == to) {
                let wedges = mesh.wedges(face);
                self.targets.push((wedges[corner.at()], wedges[end]));
            }
        }
    }

    /// The wedge that shows the attributes of a wedge after the move: one that it shares a face
    /// with, or a wedge with the same attributes, or itself where it will be a fake.
    fn target(&self, wedges: &Wedges, wedge: u32) -> u32 {
        let class = wedges.class[wedge as usize];
        let same = self.targets.iter().find(|t| t.0 == wedge);
        same.or_else(|| self.targets.iter().find(|t| wedges.class[t.0 as usize] == class))
            .map_or(wedge, |t| t.1)
    }

    /// The sum of the normals of moved faces at a vertex that are shaded together with `own`.
    fn moving_at(&self, vertex: u32, own: Vec3) -> Vec3 {
        smooth(self.moved.iter().filter(|f| f.corners.contains(&vertex)).map(|f| f.normal), own)
    }

    /// The moved face that is nearest to a sample, where in it, and the squared distance.
    fn nearest(&self, point: Vec3) -> Option<(usize, [f32; 2], f32)> {
        let mut best: Option<(usize, [f32; 2], f32)> = None;
        for (i, placed) in self.placed.iter().enumerate() {
            let (at, squared) = placed.locate(point);
            if best.is_none_or(|b| squared < b.2) {
                best = Some((i, at, squared));
            }
        }
        best
    }

    fn far_shading(&self, f: &Shaded) -> [Vec3; 3] {
        [0, 1, 2].map(|c| match f.corners[c] {
            u32::MAX => f.shading[c].normalize_or_zero(),
            vertex => (f.shading[c] + self.moving_at(vertex, f.normal)).normalize_or_zero(),
        })
    }

    /// What a sample counts for by its distance from where it now lies in a moved face. Aside of
    /// its own plane there is nothing in its place.
    fn geometry(
        &self,
        i: usize,
        at: [f32; 2],
        squared: f32,
        sample: &Sample,
        weight_of_distance: f32,
    ) -> f32 {
        let placed = &self.placed[i];
        let away = sample.position - placed.at(at);
        let along = away.dot(sample.normal);
        let aside = (squared - along * along).max(0.0).sqrt();
        let lost = if aside < sample.extent { aside / sample.extent } else { 1.0 };
        let worst = knob(3, WORST);
        let linear = squared.sqrt() * (knob(9, 0.0) * weight_of_distance.sqrt() + knob(16, 0.0) * sample.curvature);
        (weight_of_distance * squared + linear + knob(0, LOST) * lost).min(worst) * (knob(14, 0.0) + (1.0 - knob(14, 0.0)) * sample.colour.power())
    }

    /// The colour of a moved face where a sample lies in it.
    #[inline]
    fn colour(&self, i: usize, at: [f32; 2], sample: &Sample, appearance: &Appearance<'_>) -> Colour {
        if !appearance.is_textured() {
            return sample.colour;
        }
        let f = &self.moved[i];
        appearance.colour(f.submesh, mix2(&f.texture, at), sample.footprint)
    }

    /// What the patch counts for with the star moved.
    pub(super) fn energy(
        &self,
        samples: &Samples,
        appearance: &Appearance<'_>,
        weight_of_distance: f32,
    ) -> f64 {
        let mut sum = 0.0;
        for &s in &self.samples {
            let s = samples.get(s);
            let Some((i, at, squared)) = self.nearest(s.position) else {
                // Nothing is left that could stand for it.
                sum += f64::from(s.weight * knob(15, LOST) * s.colour.power());
                continue;
            };
            let shown = self.colour(i, at, s, appearance);
            let error = shading_error(cosine(&self.moved[i].shading, at, s.normal), s.colour, shown)
                + self.geometry(i, at, squared, s, weight_of_distance);
            sum += f64::from(s.weight * error);
        }
        for f in &self.far {
            sum += far_energy(f.face, &self.far_shading(f), samples)
                + f64::from(samples.foreign(f.face));
        }
        for i in 0..self.moved.len() {
            sum += f64::from(self.foreign(i, samples));
        }
        sum
    }

    /// What the part of a moved face counts for that lies where the input has nothing: beyond the
    /// extent of every sample. In wide stars, which only inputs have, it is not looked for.
    fn foreign(&self, i: usize, samples: &Samples) -> f32 {
        if self.moved.len() > WIDE {
            return 0.0;
        }
        let placed = &self.placed[i];
        let near = knob(2, NEAR);
        let share = |at: [f32; 2]| {
            let place = placed.at(at);
            let shares = self.samples.iter().map(|&s| {
                let s = samples.get(s);
                s.position.distance_squared(place)
                    / (near * near * s.extent * s.extent).max(f32::MIN_POSITIVE)
            });
            (shares.fold(2.0, f32::min) - 1.0).max(0.0) / PLACES.len() as f32
        };
        let area = 0.5 * placed.edges[0].cross(placed.edges[1]).length();
        knob(1, FOREIGN) * self.seen as f32 * area * PLACES.map(share).iter().sum::<f32>()
    }

    /// Gives the star's samples to the faces they end up with, and says what every face of the
    /// patch counts for then. Returns the root mean square distance of samples from their faces, as
    /// far as they are seen; 0 if none is.
    pub(super) fn settle(
        &self,
        samples: &mut Samples,
        appearance: &Appearance<'_>,
        weight_of_distance: f32,
        energy: &mut [f64],
    ) -> f64 {
        let (mut sum, mut seen) = (0.0, 0.0);
        for &s in &self.samples {
            let sample = *samples.get(s);
            if let Some((i, at, squared)) = self.nearest(sample.position) {
                sum += f64::from(sample.weight) * f64::from(squared);
                seen += f64::from(sample.weight);
                let g = self.geometry(i, at, squared, &sample, weight_of_distance);
                let shown = self.colour(i, at, &sample, appearance);
                samples.put(s, self.moved[i].face, at, sample.weight * g, shown);
            }
        }
        let foreign: Vec<f32> = (0..self.moved.len()).map(|i| self.foreign(i, samples)).collect();
        for (i, f) in self.moved.iter().enumerate() {
            samples.thin(f.face);
            energy[f.face as usize] =
                far_energy(f.face, &f.shading, samples) + f64::from(foreign[i]);
            samples.set_foreign(f.face, foreign[i]);
        }
        for f in &self.far {
            energy[f.face as usize] = far_energy(f.face, &self.far_shading(f), samples)
                + f64::from(samples.foreign(f.face));
        }
        if seen > 0.0 { (sum / seen).sqrt() } else { 0.0 }
    }
}

/// What a face counts for whose samples know where they are.
fn far_energy(face: u32, shading: &[Vec3; 3], samples: &Samples) -> f64 {
    let error = |s| {
        let s = samples.get(s);
        let shading = shading_error(cosine(shading, s.at, s.normal), s.colour, s.shown);
        f64::from(s.weight * shading + s.distance)
    };
    samples.of(face).map(error).sum()
}

/// The sum of the normals that are shaded together with `own`.
fn smooth(normals: impl Iterator<Item = Vec3>, own: Vec3) -> Vec3 {
    normals.filter(|n| n.dot(own) > CREASE).sum()
}
