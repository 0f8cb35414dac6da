//! The paths of a crowd's characters: each walks from one random point to the next; the same paths
//! for the same seed.

use lodc_mesh::SplitMix64;

/// Frames of a second.
pub(crate) const FRAMES_PER_SECOND: u32 = 10;
/// Side of the square for each instance, in sizes of what walks: the crowd's square grows with it.
const ROOM: f64 = 6.0;
/// Speed in sizes a second.
const SPEED: f64 = 0.8;

/// A crowd in a square with the viewer in its middle. Lengths are in sizes of what walks.
pub(crate) struct Crowd {
    random: SplitMix64,
    /// Half the side of the square.
    half: f64,
    walkers: Vec<Walker>,
}

/// One of a crowd. Positions are relative to the viewer.
struct Walker {
    place: [f64; 2],
    goal: [f64; 2],
}

/// Where a walker is in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WalkerPosition {
    /// Relative to the viewer.
    pub(crate) place: [f64; 2],
    /// Direction of the way, of length 1.
    pub(crate) ahead: [f64; 2],
    /// From the viewer: 0 up to one size away, 1 in the corners.
    pub(crate) distance: f64,
}

impl Crowd {
    pub(crate) fn new(instances: u32, seed: u64) -> Self {
        let half = ROOM * f64::from(instances).sqrt() / 2.0;
        let mut crowd = Self { random: SplitMix64::new(seed), half, walkers: Vec::new() };
        for _ in 0..instances {
            let walker = Walker { place: crowd.anywhere(), goal: crowd.anywhere() };
            crowd.walkers.push(walker);
        }
        crowd
    }

    fn anywhere(&mut self) -> [f64; 2] {
        std::array::from_fn(|_| (f64::from(self.random.unit()) * 2.0 - 1.0) * self.half)
    }

    /// Moves everyone by one frame.
    pub(crate) fn step(&mut self) {
        let step = SPEED / f64::from(FRAMES_PER_SECOND);
        for i in 0..self.walkers.len() {
            let Walker { place, goal } = &mut self.walkers[i];
            let way = [goal[0] - place[0], goal[1] - place[1]];
            let length = length(way);
            if length > step {
                *place = [place[0] + way[0] / length * step, place[1] + way[1] / length * step];
            } else {
                *place = *goal;
                self.walkers[i].goal = self.anywhere();
            }
        }
    }

    /// Returns where everyone is.
    pub(crate) fn positions(&self) -> Vec<WalkerPosition> {
        let far = length([self.half; 2]);
        let walker = |w: &Walker| {
            let way = [w.goal[0] - w.place[0], w.goal[1] - w.place[1]];
            let steps = length(way);
            let ahead = if steps > 0.0 { way.map(|c| c / steps) } else { [0.0, 1.0] };
            let distance = ((length(w.place) - 1.0) / (far - 1.0).max(1.0)).clamp(0.0, 1.0);
            WalkerPosition { place: w.place, ahead, distance }
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
            let before: Vec<_> = a.walkers.iter().map(|w| w.place).collect();
            [&mut a, &mut b, &mut c].into_iter().for_each(Crowd::step);
            for (walker, before) in a.walkers.iter().zip(before) {
                let moved = length([walker.place[0] - before[0], walker.place[1] - before[1]]);
                assert!(moved <= SPEED / f64::from(FRAMES_PER_SECOND) + 1e-9);
                assert!(walker.place.iter().all(|c| c.abs() <= a.half));
            }
            assert!(a.positions().iter().all(|s| (0.0..=1.0).contains(&s.distance)));
        }
        assert_eq!(a.positions(), b.positions());
        assert!(a.positions() != c.positions() && a.positions() != first);
    }
}
