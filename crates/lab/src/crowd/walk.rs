//! The paths of a crowd's characters: each walks from one random point to the next; the same paths
//! for the same seed.

use lodc_mesh::SplitMix64;

/// Frames of a second.
pub(crate) const FRAMES_PER_SECOND: u32 = 10;
/// Side of the ground for each walker, in sizes of what walks. Chosen by hand.
const SPACING: f64 = 6.0;
/// Speed in sizes a second. Chosen by hand: a walk.
const SPEED: f64 = 0.8;

/// A crowd in a square with the viewer in its middle. Lengths are in sizes of what walks.
pub(crate) struct Crowd {
    random: SplitMix64,
    /// Half the side of the square.
    half_side: f64,
    walkers: Vec<Walker>,
}

/// One of a crowd. Positions are relative to the viewer.
struct Walker {
    position: [f64; 2],
    /// The random point that it walks to.
    goal: [f64; 2],
}

/// Where a walker is in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WalkerPosition {
    /// Relative to the viewer.
    pub(crate) position: [f64; 2],
    /// Direction of the way, of length 1.
    pub(crate) direction: [f64; 2],
    /// Distance from the viewer: 0 up to one size away, 1 in the corners.
    pub(crate) remoteness: f64,
}

impl Crowd {
    pub(crate) fn new(instances: u32, seed: u64) -> Self {
        let half_side = SPACING * f64::from(instances).sqrt() / 2.0;
        let mut crowd = Self { random: SplitMix64::new(seed), half_side, walkers: Vec::new() };
        for _ in 0..instances {
            let walker = Walker { position: crowd.random_point(), goal: crowd.random_point() };
            crowd.walkers.push(walker);
        }
        crowd
    }

    fn random_point(&mut self) -> [f64; 2] {
        std::array::from_fn(|_| (f64::from(self.random.unit()) * 2.0 - 1.0) * self.half_side)
    }

    /// Moves everyone by one frame.
    pub(crate) fn advance(&mut self) {
        let max_distance = SPEED / f64::from(FRAMES_PER_SECOND);
        for i in 0..self.walkers.len() {
            let Walker { position, goal } = &mut self.walkers[i];
            let way = [goal[0] - position[0], goal[1] - position[1]];
            let length = length(way);
            if length > max_distance {
                *position = [
                    position[0] + way[0] / length * max_distance,
                    position[1] + way[1] / length * max_distance,
                ];
            } else {
                *position = *goal;
                self.walkers[i].goal = self.random_point();
            }
        }
    }

    /// Returns where everyone is.
    pub(crate) fn positions(&self) -> Vec<WalkerPosition> {
        let corner_distance = length([self.half_side; 2]);
        let walker = |w: &Walker| {
            let way = [w.goal[0] - w.position[0], w.goal[1] - w.position[1]];
            let remaining = length(way);
            let direction = if remaining > 0.0 { way.map(|c| c / remaining) } else { [0.0, 1.0] };
            let remoteness = (length(w.position) - 1.0) / (corner_distance - 1.0).max(1.0);
            let remoteness = remoteness.clamp(0.0, 1.0);
            WalkerPosition { position: w.position, direction, remoteness }
        };
        self.walkers.iter().map(walker).collect()
    }
}

fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crowd_is_the_same_for_a_seed_and_walks_without_leaps() {
        let (mut a, mut b, mut c) = (Crowd::new(40, 3), Crowd::new(40, 3), Crowd::new(40, 4));
        let first = a.positions();
        for _ in 0..500 {
            let before: Vec<_> = a.walkers.iter().map(|w| w.position).collect();
            [&mut a, &mut b, &mut c].into_iter().for_each(Crowd::advance);
            for (walker, before) in a.walkers.iter().zip(before) {
                let moved =
                    length([walker.position[0] - before[0], walker.position[1] - before[1]]);
                assert!(moved <= SPEED / f64::from(FRAMES_PER_SECOND) + 1e-9);
                assert!(walker.position.iter().all(|c| c.abs() <= a.half_side));
            }
            assert!(a.positions().iter().all(|s| (0.0..=1.0).contains(&s.remoteness)));
        }
        assert_eq!(a.positions(), b.positions());
        assert!(a.positions() != c.positions() && a.positions() != first);
    }
}
