//! Pricing plain groups, whose star is a closed fan without seams, four collapses at a time.
//!
//! The spokes (vectors from the group to each neighbour) are transposed into SIMD lanes. With `cᵢ`
//! the cross product of consecutive spokes, a face costs `wᵢ(cᵢ·δ)²` with `wᵢ = ½/|cᵢ|`, so nothing
//! cancels in single precision. Only element-wise operations: the same bits on every machine.

use crate::cut::{Choice, Corner, InMotion, Quadric, WorkingMesh, fold_plane};
use crate::metric::{MEMORY, TIE_WEIGHT};
use crate::number::each_shape;
use glam::{BVec4A, Mat4, Vec3, Vec4};

/// Factor of a cost before it becomes a key of the queue. In working units every mesh is one to two
/// across, so costs lie between 1 and about 1e-37: [`TIE_WEIGHT`] times area and squared length of
/// the smallest faces that `f32` can place. Scaled, all of them are normal numbers.
pub(super) const COST_SCALE: f32 = 1e12;
/// Rings with more neighbours than this are priced edge by edge: three vectors of four lanes hold
/// twelve neighbours, and the last of them is the first one again.
pub(crate) const MAX_LEN: usize = 11;

/// The numbers of all lanes.
const LANES: [Vec4; 3] =
    [Vec4::new(0.0, 1.0, 2.0, 3.0), Vec4::new(4.0, 5.0, 6.0, 7.0), Vec4::new(8.0, 9.0, 10.0, 11.0)];
/// Single precision is trusted with how far a face turns if twice its area is at least this share
/// of the longest spoke squared: its cross product is off by about 1e-6 of that square, so its
/// direction by 0.001.
const LEAST_AREA: f32 = 1e-3;

/// One coordinate of up to four neighbours for each vector.
pub(super) type LaneArray<const N: usize> = [Vec4; N];

/// A cost besides that of the quadric.
pub(super) trait AttributeCost {
    /// True if there is none.
    const IS_ZERO: bool;

    /// The costs of moving onto each neighbour, in working units to the fourth power; not NaN.
    fn costs<const N: usize>(&self, ring: &OneRing<N>, star: &[Corner]) -> LaneArray<N>;

    /// Raises these costs to those in the shape in motion where they are most.
    fn raise_in_motion<const N: usize>(
        &self,
        view: &InMotion<'_>,
        from: u32,
        star: &[Corner],
        costs: &mut LaneArray<N>,
    );
}

/// No attribute cost.
pub(super) struct NoAttributeCost;

impl AttributeCost for NoAttributeCost {
    const IS_ZERO: bool = true;

    fn costs<const N: usize>(&self, _: &OneRing<N>, _: &[Corner]) -> LaneArray<N> {
        [Vec4::ZERO; N]
    }

    fn raise_in_motion<const N: usize>(
        &self,
        _: &InMotion<'_>,
        _: u32,
        _: &[Corner],
        _: &mut LaneArray<N>,
    ) {
    }
}

/// The cheapest collapse of a plain group; none if its ring is too short or too long.
#[inline]
pub(super) fn cheapest(
    mesh: &WorkingMesh,
    quadric: &Quadric,
    from: u32,
    in_motion: Option<InMotion<'_>>,
    attribute_cost: &impl AttributeCost,
) -> Option<Choice> {
    let star = mesh.star(from);
    match star.len() {
        3..=7 => Some(price::<2>(mesh, quadric, from, star, in_motion, attribute_cost)),
        8..=MAX_LEN => Some(price::<3>(mesh, quadric, from, star, in_motion, attribute_cost)),
        _ => None,
    }
}

/// The ring of a group in lanes.
pub(crate) struct OneRing<const N: usize> {
    /// Number of neighbours, less than `4 N`.
    pub(super) len: usize,
    /// Spokes, from the group to each neighbour, and the first once more.
    x: LaneArray<N>,
    y: LaneArray<N>,
    z: LaneArray<N>,
    /// Each neighbour's own part of the cost.
    target_cost: LaneArray<N>,
    /// Cross product of each spoke and the next.
    cx: LaneArray<N>,
    cy: LaneArray<N>,
    cz: LaneArray<N>,
}

/// Vectors from lanes.
#[inline]
fn vectors<const N: usize>(
    x: &LaneArray<N>,
    y: &LaneArray<N>,
    z: &LaneArray<N>,
) -> [Vec3; MAX_LEN + 1] {
    let mut all = [Vec3::ZERO; MAX_LEN + 1];
    for (t, four) in all.as_chunks_mut::<4>().0.iter_mut().take(N).enumerate() {
        let (x, y, z) = (x[t].to_array(), y[t].to_array(), z[t].to_array());
        *four = std::array::from_fn(|i| Vec3::new(x[i], y[i], z[i]));
    }
    all
}

/// Vector `t` of the lanes shifted by one, so that lane i holds value i + 1; zero behind the last.
#[inline]
fn following<const N: usize>(lanes: &LaneArray<N>, t: usize) -> Vec4 {
    let (a, next) = (lanes[t], if t + 1 < N { lanes[t + 1] } else { Vec4::ZERO });
    Vec4::new(a.y, a.z, a.w, next.x)
}

impl<const N: usize> OneRing<N> {
    #[inline]
    pub(crate) fn new(mesh: &WorkingMesh, from: u32, star: &[Corner]) -> Self {
        let origin = mesh.group_positions[from as usize].position;
        Self::of_rows(origin, star, |group| mesh.group_positions[group as usize].row())
    }

    /// The ring in a shape in motion, without costs of targets.
    #[inline]
    pub(super) fn in_motion(view: &InMotion<'_>, from: u32, star: &[Corner], shape: u32) -> Self {
        let position = |group: u32| view.position(group, shape);
        Self::of_rows(position(from), star, |group| position(group).extend(0.0))
    }

    /// The ring, given the position of its group, and of its neighbours with their costs.
    #[inline(always)]
    fn of_rows(origin: Vec3, star: &[Corner], neighbour: impl Fn(u32) -> Vec4) -> Self {
        let len = star.len();
        let origin = origin.extend(0.0);
        let mut row = [Vec4::ZERO; MAX_LEN + 2];
        for (row, corner) in row.iter_mut().zip(star) {
            *row = neighbour(corner.ahead) - origin;
        }
        // The first two neighbours once more, for the face between the last and the first.
        row[len] = row[0];
        row[len + 1] = row[1];
        let zero = [Vec4::ZERO; N];
        let (mut x, mut y, mut z, mut target_cost) = (zero, zero, zero, zero);
        let (mut cx, mut cy, mut cz) = (zero, zero, zero);
        for t in 0..N {
            let rows = |i: usize| Mat4::from_cols(row[i], row[i + 1], row[i + 2], row[i + 3]);
            let p = rows(4 * t).transpose();
            let q = rows(4 * t + 1).transpose();
            (x[t], y[t], z[t], target_cost[t]) = (p.x_axis, p.y_axis, p.z_axis, p.w_axis);
            cx[t] = y[t] * q.z_axis - z[t] * q.y_axis;
            cy[t] = z[t] * q.x_axis - x[t] * q.z_axis;
            cz[t] = x[t] * q.y_axis - y[t] * q.x_axis;
        }
        Self { len, x, y, z, target_cost, cx, cy, cz }
    }

    /// The spokes, and the first once more.
    #[inline]
    pub(super) fn spokes(&self) -> [Vec3; MAX_LEN + 1] {
        vectors(&self.x, &self.y, &self.z)
    }

    /// The cross product of each spoke and the next.
    #[inline]
    pub(super) fn normals(&self) -> [Vec3; MAX_LEN + 1] {
        vectors(&self.cx, &self.cy, &self.cz)
    }

    /// A quadratic form at each spoke.
    #[inline]
    pub(super) fn quadratic(&self, a: [f32; 6]) -> LaneArray<N> {
        let [xx, xy, xz, yy, yz, zz] = a.map(Vec4::splat);
        let two = Vec4::splat(2.0);
        std::array::from_fn(|t| {
            let (x, y, z) = (self.x[t], self.y[t], self.z[t]);
            x * (xx * x + two * (xy * y + xz * z)) + y * (yy * y + two * (yz * z)) + z * (zz * z)
        })
    }

    /// Returns whether two consecutive faces are more than 90° apart.
    #[inline]
    pub(super) fn is_folded(&self) -> bool {
        let mut folded = BVec4A::FALSE;
        for t in 0..N {
            let next = |a| following(a, t);
            let dot = self.cx[t] * next(&self.cx)
                + self.cy[t] * next(&self.cy)
                + self.cz[t] * next(&self.cz);
            folded |= dot.cmplt(Vec4::ZERO);
        }
        folded.any()
    }

    /// Adds what moving off the planes along folded edges costs.
    #[cold]
    #[inline(never)]
    fn add_folds(&self, sums: &mut LaneArray<N>) {
        let (spokes, normals) = (self.spokes(), self.normals().map(Vec3::normalize_or_zero));
        for i in 1..=self.len {
            let edge = spokes[i].as_dvec3();
            if let Some(plane) = fold_plane(normals[i - 1], normals[i], edge) {
                self.add_plane(plane.normal.as_vec3().to_array(), plane.weight as f32, sums);
            }
        }
    }

    /// Half the inverse length of each cross product, zero where there is no face, and the area of
    /// all faces.
    #[inline]
    pub(super) fn weights(&self) -> (LaneArray<N>, f32) {
        let mut weights = [Vec4::ZERO; N];
        let mut area = Vec4::ZERO;
        let len = Vec4::splat(self.len as f32);
        for t in 0..N {
            let squared =
                self.cx[t] * self.cx[t] + self.cy[t] * self.cy[t] + self.cz[t] * self.cz[t];
            let length = squared.sqrt();
            let is_used = LANES[t].cmplt(len) & squared.cmpgt(Vec4::ZERO);
            weights[t] = Vec4::select(is_used, Vec4::splat(0.5) / length, Vec4::ZERO);
            area += Vec4::select(is_used, length, Vec4::ZERO);
        }
        (weights, 0.5 * ((area.x + area.y) + (area.z + area.w)))
    }

    /// The accumulated part of the costs, and what orders equal ones by length. In double
    /// precision: where a surface is flat, nearly all of it cancels.
    #[inline]
    fn accumulated(&self, quadric: &Quadric, area: f32) -> LaneArray<N> {
        let tie = TIE_WEIGHT * f64::from(area);
        let a = quadric.a.map(|a| MEMORY * a);
        let (xx, yy, zz) = (a[0] + tie, a[3] + tie, a[5] + tie);
        let [xy, xz, yz] = [2.0 * a[1], 2.0 * a[2], 2.0 * a[4]];
        let (b, c) = ((2.0 * MEMORY) * quadric.b, MEMORY * quadric.c);
        std::array::from_fn(|t| {
            let [x, y, z] = [self.x[t], self.y[t], self.z[t]].map(|v| v.to_array().map(f64::from));
            Vec4::from_array(std::array::from_fn(|i| {
                let (x, y, z) = (x[i], y[i], z[i]);
                let moved = x * ((xx * x + xy * y) + (xz * z + b.x))
                    + y * ((yy * y + yz * z) + b.y)
                    + (z * (zz * z + b.z) + c);
                if moved > 0.0 { moved as f32 } else { 0.0 }
            }))
        })
    }

    /// The costs of moving onto each neighbour by the shape alone.
    #[inline(always)]
    fn geometric(&self, quadric: &Quadric) -> LaneArray<N> {
        let (weights, area) = self.weights();
        let mut sums = self.accumulated(quadric, area);
        self.add_faces(&weights, &mut sums);
        if self.is_folded() {
            self.add_folds(&mut sums);
        }
        sums
    }

    /// Adds what moving onto each neighbour costs by the planes of the faces. Face by face and all
    /// neighbours at a time: the other way round each face would have to be read again for each
    /// vector of neighbours.
    #[inline(always)]
    pub(super) fn add_faces(&self, weights: &LaneArray<N>, sums: &mut LaneArray<N>) {
        for (f, weights) in weights.iter().enumerate() {
            let (cx, cy, cz) = (self.cx[f], self.cy[f], self.cz[f]);
            let faces = cx.to_array().into_iter().zip(cy.to_array()).zip(cz.to_array());
            let faces = faces.zip(weights.to_array()).take(self.len - (4 * f).min(self.len));
            for (((cx, cy), cz), weight) in faces {
                self.add_plane([cx, cy, cz], weight, sums);
            }
        }
    }

    /// Adds what moving off a plane through the group costs: its weight times the square of the
    /// product with its normal.
    #[inline(always)]
    fn add_plane(&self, normal: [f32; 3], weight: f32, sums: &mut LaneArray<N>) {
        let ([nx, ny, nz], weight) = (normal.map(Vec4::splat), Vec4::splat(weight));
        for (t, sum) in sums.iter_mut().enumerate() {
            let distance = nx * self.x[t] + ny * self.y[t] + nz * self.z[t];
            *sum += distance * weight * distance;
        }
    }

    /// Returns whether, beyond doubt, no face turns by more than the cosine `turn` or loses its
    /// area when the group moves onto a neighbour. Single precision leaves some in doubt: faces
    /// whose area is below a thousandth of the longest spoke squared.
    #[inline]
    pub(crate) fn surely_turns_less(&self, to: usize, turn: f32) -> bool {
        let at = |lanes: &LaneArray<N>| Vec4::splat(lanes[to / 4][to % 4]);
        let (dx, dy, dz) = (at(&self.x), at(&self.y), at(&self.z));
        let mut longest = Vec4::ZERO;
        for t in 0..N {
            let (x, y, z) = (self.x[t], self.y[t], self.z[t]);
            longest = longest.max(x * x + y * y + z * z);
        }
        let least = longest.max_element() * LEAST_AREA;
        let least = Vec4::splat(least * least);
        let limit = Vec4::splat(turn * turn);
        let before = if to == 0 { self.len - 1 } else { to - 1 };
        let (to, before) = (Vec4::splat(to as f32), Vec4::splat(before as f32));
        let len = Vec4::splat(self.len as f32);
        let mut fails = BVec4A::FALSE;
        for (t, &lanes) in LANES[..N].iter().enumerate() {
            let (cx, cy, cz) = (self.cx[t], self.cy[t], self.cz[t]);
            let next = |a| following(a, t);
            let (ex, ey, ez) =
                (next(&self.x) - self.x[t], next(&self.y) - self.y[t], next(&self.z) - self.z[t]);
            // The spokes from the neighbour: their cross product.
            let (nx, ny, nz) =
                (cx + (ey * dz - ez * dy), cy + (ez * dx - ex * dz), cz + (ex * dy - ey * dx));
            let old = cx * cx + cy * cy + cz * cz;
            let new = nx * nx + ny * ny + nz * nz;
            let dot = nx * cx + ny * cy + nz * cz;
            let holds = dot.cmpgt(Vec4::ZERO)
                & (dot * dot).cmpgt(limit * (new * old))
                & new.cmpgt(least)
                & old.cmpgt(least);
            let dies = lanes.cmpeq(to) | lanes.cmpeq(before);
            fails |= !(holds | dies) & lanes.cmplt(len);
        }
        !fails.any()
    }
}

/// Raises what moving onto each neighbour costs to what it costs in the shape in motion where that
/// is most.
#[inline(never)]
fn raise_in_motion<const N: usize>(
    view: &InMotion<'_>,
    from: u32,
    star: &[Corner],
    sums: &mut LaneArray<N>,
) {
    for shape in each_shape(view.around(from)) {
        let ring = OneRing::<N>::in_motion(view, from, star, shape);
        let weight = Vec4::splat(view.shapes.weight(shape) as f32);
        let moving = ring.geometric(&view.quadric(from, shape));
        for (sum, cost) in sums.iter_mut().zip(moving) {
            *sum = sum.max(cost * weight);
        }
    }
}

/// Returns whether an attribute cost is zero.
#[inline(always)]
fn is_zero<S: AttributeCost>(_: &S) -> bool {
    S::IS_ZERO
}

#[inline(always)]
fn price<const N: usize>(
    mesh: &WorkingMesh,
    quadric: &Quadric,
    from: u32,
    star: &[Corner],
    in_motion: Option<InMotion<'_>>,
    attribute_cost: &impl AttributeCost,
) -> Choice {
    let ring = OneRing::<N>::new(mesh, from, star);
    let mut sums = ring.geometric(quadric);
    if let Some(view) = in_motion {
        raise_in_motion(&view, from, star, &mut sums);
    }
    if !is_zero(attribute_cost) {
        let mut costs = attribute_cost.costs(&ring, star);
        if let Some(view) = in_motion {
            attribute_cost.raise_in_motion(&view, from, star, &mut costs);
        }
        for (sum, cost) in sums.iter_mut().zip(costs) {
            *sum += cost;
        }
    }
    let mut best = u64::MAX;
    for ((sums, target_cost), corners) in sums.iter().zip(ring.target_cost).zip(star.chunks(4)) {
        let costs = ((*sums + target_cost) * COST_SCALE).min(Vec4::splat(f32::MAX));
        for (cost, corner) in costs.to_array().into_iter().zip(corners) {
            best = best.min(u64::from(cost.to_bits()) << 32 | u64::from(corner.ahead));
        }
    }
    Choice { cost: f32::from_bits((best >> 32) as u32), to: best as u32 }
}

#[cfg(test)]
mod tests {
    use super::NoAttributeCost;
    use crate::cut::{Neighbourhood, OPEN, Quadrics, Region};
    use crate::number::Input;

    #[test]
    fn four_at_a_time_cost_what_one_by_one_costs() {
        let mut compared = 0;
        for mesh in [lodc_fixtures::icosphere(3), lodc_fixtures::machine_part()] {
            let region = Region::whole(&Input::new(&mesh), false);
            let Region { mesh, wedges, quadrics, .. } = &region;
            let mut around = Neighbourhood::default();
            for g in (0..region.own_groups() as u32).filter(|&g| !mesh.has(g, OPEN)) {
                let quadric = &quadrics.surface[g as usize];
                let Some(choice) = super::cheapest(mesh, quadric, g, None, &NoAttributeCost) else {
                    continue;
                };
                around.gather(mesh, wedges, g);
                let planes: Vec<_> = around.planes.drain(..).collect();
                if around.seams > 0 {
                    continue;
                }
                let refitted = Quadrics::refit(quadrics, g, &around.facets, &planes);
                let cost = |to: u32| {
                    let delta = mesh.position(to) - mesh.position(g);
                    refitted.cost(delta) + f64::from(mesh.group_positions[to as usize].target_cost)
                };
                let best = around.edges.iter().map(|e| cost(e.group)).fold(f64::INFINITY, f64::min);
                let found = cost(choice.to);
                assert!(found <= best * 1.0001 + 1e-18, "{g}: found {found}, best {best}");
                let said = f64::from(choice.cost) * 1e-12;
                assert!((said - found).abs() <= 1e-3 * found + 1e-16, "{g}: {said}, {found}");
                compared += 1;
            }
        }
        assert!(compared > 300, "{compared}");
    }
}
