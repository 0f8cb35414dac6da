//! Loose parts: leaves, blades of grass, tiles, debris. What one loses by going depends on which of
//! the others are left, which no price of its own tells.
//!
//! ```text
//!   along the curve   0   1   2   3   4   5   6   7   8        parts of one kind, in their order
//!   go first              x       x       x       x            odd ones: a neighbour is left
//!   then                      x               x                twice an odd number: two places on
//!   then                                  x                    …
//! ```
//!
//! So survivors are spread evenly at every level, where parts of equal cost would go in clumps.

use glam::Vec3;
use lodc_mesh::DisjointSets;

/// Components of no more faces are loose parts. Chosen by hand.
const MAX_FACES: u32 = 256;
/// Meshes of fewer of them have none. Chosen by hand.
const FEWEST_PARTS: usize = 32;
/// Groups before and after a part's first one on the curve among which a larger component is looked
/// for. Chosen by hand.
const REACH: usize = 16;
/// Odd multiples of a part's stride along the curve at which survivors are looked for. Chosen by
/// hand.
const MULTIPLES: [usize; 4] = [1, 3, 5, 7];

/// A component of a mesh.
#[derive(Clone, Copy)]
struct Component {
    /// Its first group.
    first: u32,
    faces: u32,
    groups: u32,
    sum: Vec3,
    low: Vec3,
    high: Vec3,
}

impl Component {
    const NONE: Self = Self {
        first: u32::MAX,
        faces: 0,
        groups: 0,
        sum: Vec3::ZERO,
        low: Vec3::INFINITY,
        high: Vec3::NEG_INFINITY,
    };

    fn centre(&self) -> Vec3 {
        self.sum / self.groups as f32
    }
}

/// Returns for each of `groups`, in the order of the curve, by how much the price of its part's
/// going is multiplied, at least 1; empty if the mesh has no loose parts. `triangles` are of
/// groups.
pub(super) fn factors(
    groups: usize,
    position: impl Fn(usize) -> Vec3,
    triangles: impl Iterator<Item = [u32; 3]> + Clone,
) -> Vec<f32> {
    let mut sets = DisjointSets::new(groups);
    for [a, b, c] in triangles.clone() {
        sets.join(a, b);
        sets.join(a, c);
    }
    // The component of each group: they are numbered by their first groups, along the curve.
    let mut component_of: Vec<u32> = Vec::with_capacity(groups);
    let mut count = 0;
    for group in 0..groups as u32 {
        let first = sets.find(group);
        component_of.push(if first == group { count } else { component_of[first as usize] });
        count += u32::from(first == group);
    }
    if (count as usize) < FEWEST_PARTS {
        return Vec::new();
    }
    let mut components = vec![Component::NONE; count as usize];
    for [a, ..] in triangles {
        components[component_of[a as usize] as usize].faces += 1;
    }
    for (group, &of) in component_of.iter().enumerate() {
        let component = &mut components[of as usize];
        component.first = component.first.min(group as u32);
        component.groups += 1;
        component.sum += position(group);
        component.low = component.low.min(position(group));
        component.high = component.high.max(position(group));
    }
    let is_large = |group: usize| components[component_of[group] as usize].faces > MAX_FACES;
    let is_loose = |c: &usize| (1..=MAX_FACES).contains(&components[*c].faces);
    let parts: Vec<usize> = (0..components.len()).filter(is_loose).collect();
    if parts.len() < FEWEST_PARTS {
        return Vec::new();
    }
    let mut factor_of = vec![1.0; components.len()];
    for (i, &part) in parts.iter().enumerate() {
        let component = &components[part];
        let centre = component.centre();
        let extent = 0.5 * (component.high - component.low).length_squared();
        // Those that are left when it goes stand at multiples of twice this stride, from 0 on. The
        // first part, which is one of all of these, gets a stride longer than any list.
        let stride = 1usize << i.trailing_zeros().min(26);
        let around = |m: &usize| [i.checked_sub(m * stride), i.checked_add(m * stride)];
        let left = MULTIPLES.iter().flat_map(around).flatten().filter_map(|i| parts.get(i));
        let first = component.first as usize;
        let reach = first.saturating_sub(REACH)..(first + REACH).min(groups);
        let nearest = |others: &mut dyn Iterator<Item = Vec3>| {
            others.map(|other| other.distance_squared(centre)).fold(f32::INFINITY, f32::min)
        };
        let mut left = left.map(|&other| components[other].centre());
        let mut larger = reach.filter(|&group| is_large(group)).map(&position);
        // It stands for the parts that went before it, too, but not on a larger component.
        let cost = (stride as f32 * nearest(&mut left)).min(nearest(&mut larger));
        let factor = cost / extent;
        factor_of[part] = if factor.is_finite() { factor.max(1.0) } else { f32::MAX };
    }
    component_of.iter().map(|&of| factor_of[of as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_second_part_goes_before_the_others() {
        let at = |i: u32, x: f32, y: f32| Vec3::new(i as f32 + x, y, 0.0);
        let positions: Vec<Vec3> =
            (0..64).flat_map(|i| [at(i, 0.0, 0.0), at(i, 0.5, 0.0), at(i, 0.0, 0.5)]).collect();
        let triangles = (0..64).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
        let factors = factors(positions.len(), |g| positions[g], triangles);
        let of = |part: usize| factors[3 * part];
        assert!(factors.chunks(3).all(|part| part.iter().all(|f| *f == part[0])));
        let least =
            |stride: usize| (stride..64).step_by(2 * stride).map(of).fold(f32::INFINITY, f32::min);
        let most = |stride: usize| (stride..64).step_by(2 * stride).map(of).fold(0.0, f32::max);
        for stride in [1, 2, 4, 8] {
            assert!(most(stride) < least(2 * stride), "{stride}");
        }
    }

    #[test]
    fn a_part_on_a_large_one_is_not_missed() {
        // A strip of many faces, and parts beside it.
        let strip = |i: u32| Vec3::new(i as f32 * 0.1, (i % 2) as f32 * 0.1, 0.0);
        let mut positions: Vec<Vec3> = Vec::new();
        let mut triangles = Vec::new();
        for i in 0..400 {
            positions.push(strip(i));
            if i >= 2 {
                let at = |k: u32| k + 3 * (k.div_ceil(10));
                triangles.push([at(i - 2), at(i - 1), at(i)]);
            }
            if i % 10 == 0 {
                let first = positions.len() as u32;
                let corner = |x: f32, y: f32| strip(i) + Vec3::new(x, y, 0.01);
                positions.extend([corner(0.0, 0.0), corner(0.05, 0.0), corner(0.0, 0.05)]);
                triangles.push([first, first + 1, first + 2]);
            }
        }
        let parts = factors(positions.len(), |g| positions[g], triangles.iter().copied());
        assert!(!parts.is_empty() && parts.iter().all(|&f| f < 2.0), "{parts:?}");
    }

    #[test]
    fn one_component_has_no_parts() {
        assert!(factors(4, |_| Vec3::ZERO, [[0, 1, 2], [1, 2, 3]].into_iter()).is_empty());
    }
}
