//! The faces whose shading a collapse changes: those that move, and those that share a corner with
//! them.

use super::samples::{CREASE, Sample, Samples};
use crate::working::{Corner, WorkingMesh};
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
}

/// Where a moved face lies, so that samples find their place in it.
#[derive(Clone, Copy, Debug)]
struct Placed {
    origin: Vec3,
    edges: [Vec3; 2],
    /// The dual basis of the edges.
    dual: [Vec3; 2],
}

impl Placed {
    /// The place of these shares.
    fn at(&self, [u, v]: [f32; 2]) -> Vec3 {
        self.origin + self.edges[0] * u + self.edges[1] * v
    }

    fn new(corners: [Vec3; 3]) -> (Self, Vec3) {
        let [e1, e2] = [corners[1] - corners[0], corners[2] - corners[0]];
        let n = e1.cross(e2);
        let nn = n.length_squared();
        let inverse = if nn > 0.0 { 1.0 / nn } else { 0.0 };
        let dual = [e2.cross(n) * inverse, n.cross(e1) * inverse];
        (Self { origin: corners[0], edges: [e1, e2], dual }, n * inverse.sqrt())
    }

    /// The nearest place in the face, nearly: shares of two corners, and the squared distance.
    #[inline]
    fn locate(&self, point: Vec3) -> ([f32; 2], f32) {
        let r = point - self.origin;
        let (mut u, mut v) = (r.dot(self.dual[0]), r.dot(self.dual[1]));
        let w = 1.0 - u - v;
        if u < 0.0 || v < 0.0 || w < 0.0 {
            (u, v) = (u.max(0.0), v.max(0.0));
            let scale = 1.0 / (u + v + w.max(0.0));
            (u, v) = (u * scale, v * scale);
        }
        ([u, v], (self.edges[0] * u + self.edges[1] * v - r).length_squared())
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
    /// Samples of the star.
    pub(super) samples: Vec<u32>,
    /// What the whole patch counts for at present.
    pub(super) present: f64,
    /// How much of the star is seen: 0 nothing, 1 as much as of a face with nothing before it.
    pub(super) seen: f64,
}

/// What a sample counts for if shaded with these corner normals.
#[inline]
fn shading_error(shading: &[Vec3; 3], at: [f32; 2], normal: Vec3) -> f32 {
    let n = shading[0] * (1.0 - at[0] - at[1]) + shading[1] * at[0] + shading[2] * at[1];
    let length = n.length();
    if length > 0.0 { (n / length).distance_squared(normal) } else { 1.0 }
}

impl Patch {
    /// Gathers what is around a group. `energy` is what each face counts for at present.
    pub(super) fn gather(
        &mut self,
        mesh: &WorkingMesh,
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
        for i in 0..self.ring.len() {
            self.fixed_start.push(self.fixed.len() as u32);
            for &corner in mesh.star(self.ring[i]) {
                let f = &mesh.faces[corner.face() as usize];
                if !f.groups.contains(&from) {
                    self.fixed.push(mesh.normal(corner.face()));
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

    fn start(&mut self, mesh: &WorkingMesh) {
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

    fn add_far(&mut self, mesh: &WorkingMesh, face: u32) {
        let (f, normal) = (&mesh.faces[face as usize], mesh.normal(face));
        let corners = f.groups.map(|g| self.vertex(g));
        let shading = [0, 1, 2].map(|c| match corners[c] {
            u32::MAX => {
                let normals = mesh.star(f.groups[c]).iter().map(|c| mesh.normal(c.face()));
                smooth(normals, normal)
            }
            vertex => smooth(self.fixed_at(vertex).iter().copied(), normal),
        });
        self.far.push(Shaded { face, corners, normal, shading });
    }

    fn fixed_at(&self, vertex: u32) -> &[Vec3] {
        let start = &self.fixed_start[vertex as usize..];
        &self.fixed[start[0] as usize..start[1] as usize]
    }

    /// Moves the star to `to` and shades what moves.
    pub(super) fn move_to(&mut self, mesh: &WorkingMesh, star: &[Corner], from: u32, to: u32) {
        self.moved.clear();
        self.placed.clear();
        for &corner in star {
            let face = corner.face();
            let groups = mesh.faces[face as usize].groups;
            if groups.contains(&to) {
                continue;
            }
            let groups = groups.map(|g| if g == from { to } else { g });
            let (placed, normal) = Placed::new(groups.map(|g| mesh.places[g as usize].position));
            let corners = groups.map(|g| self.vertex(g));
            self.moved.push(Shaded { face, corners, normal, shading: [normal; 3] });
            self.placed.push(placed);
        }
        for i in 0..self.moved.len() {
            let own = self.moved[i];
            self.moved[i].shading = own.corners.map(|vertex| {
                let fixed = smooth(self.fixed_at(vertex).iter().copied(), own.normal);
                (fixed + self.moving_at(vertex, own.normal)).normalize_or_zero()
            });
        }
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
        (weight_of_distance * squared + LOST * lost).min(WORST)
    }

    /// What the patch counts for with the star moved.
    pub(super) fn energy(&self, samples: &Samples, weight_of_distance: f32) -> f64 {
        let mut sum = 0.0;
        for &s in &self.samples {
            let s = samples.get(s);
            let Some((i, at, squared)) = self.nearest(s.position) else {
                // Nothing is left that could stand for it.
                sum += f64::from(s.weight * LOST);
                continue;
            };
            let error = shading_error(&self.moved[i].shading, at, s.normal)
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
        let share = |at: [f32; 2]| {
            let place = placed.at(at);
            let shares = self.samples.iter().map(|&s| {
                let s = samples.get(s);
                s.position.distance_squared(place)
                    / (NEAR * NEAR * s.extent * s.extent).max(f32::MIN_POSITIVE)
            });
            (shares.fold(2.0, f32::min) - 1.0).max(0.0) / PLACES.len() as f32
        };
        let area = 0.5 * placed.edges[0].cross(placed.edges[1]).length();
        FOREIGN * self.seen as f32 * area * PLACES.map(share).iter().sum::<f32>()
    }

    /// Gives the star's samples to the faces they end up with, and says what every face of the
    /// patch counts for then. Returns the root mean square distance of samples from their faces, as
    /// far as they are seen; 0 if none is.
    pub(super) fn settle(
        &self,
        samples: &mut Samples,
        weight_of_distance: f32,
        energy: &mut [f64],
    ) -> f64 {
        let (mut sum, mut seen) = (0.0, 0.0);
        for &s in &self.samples {
            let (position, weight) = (samples.get(s).position, samples.get(s).weight);
            if let Some((i, at, squared)) = self.nearest(position) {
                sum += f64::from(weight) * f64::from(squared);
                seen += f64::from(weight);
                let g = self.geometry(i, at, squared, samples.get(s), weight_of_distance);
                samples.put(s, self.moved[i].face, at, weight * g);
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
        f64::from(s.weight * shading_error(shading, s.at, s.normal) + s.distance)
    };
    samples.of(face).map(error).sum()
}

/// The sum of the normals that are shaded together with `own`.
fn smooth(normals: impl Iterator<Item = Vec3>, own: Vec3) -> Vec3 {
    normals.filter(|n| n.dot(own) > CREASE).sum()
}
