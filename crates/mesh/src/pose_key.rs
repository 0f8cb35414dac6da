//! How a pose of one object is named: a moment of an animation, or a morph target.

/// A pose that gives an object another shape than at rest, named by its cause.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PoseKey {
    /// A moment of an animation of its file.
    Moment {
        /// Number of the animation, from 0.
        animation: u32,
        /// Seconds, at least 0.
        seconds: f64,
    },
    /// The morph target of this number at weight 1, all else at rest.
    Target(u32),
}
