//! `crowd` of `bench --json`. Its keys are a contract as those in `crate::report` are.

use crate::timings::Spread;
use serde::Serialize;
use std::collections::BTreeMap;

/// A crowd that was measured.
#[derive(Debug, Serialize)]
pub struct CrowdReport {
    pub(crate) instances: u32,
    pub(crate) frames: u32,
    pub(crate) seed: u64,
    pub(crate) models: BTreeMap<&'static str, Policies>,
    /// Everything at LOD 0.
    pub(crate) none: Frames,
    /// Over time.
    pub(crate) curve: CrowdCurve,
    /// Over distance.
    pub(crate) by_distance: DistanceCurve,
    /// Null if nothing was drawn on a graphics device.
    pub(crate) gpu: Option<CrowdOnDevice>,
}

/// A structure with levels by distance.
#[derive(Debug, Serialize)]
pub(crate) struct Policies {
    /// Every LOD.
    pub(crate) continuous: Frames,
    /// Five levels, each with 25 % fewer triangles than the one before.
    pub(crate) discrete: Frames,
}

/// Means over frames.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Frames {
    pub(crate) triangles_per_frame: f64,
    /// Null with `--no-times`.
    pub(crate) extraction_ms_per_frame: Option<f64>,
    /// Over all rounds, in which structures take turns; null with `--no-times`.
    pub(crate) extraction_spread: Option<Spread>,
    /// At each point of the crowd's curve, each frame in its best round; null with `--no-times`.
    pub(crate) extraction_ms_curve: Option<Vec<f64>>,
    /// Share of the instances whose level another one of the same input has in the same frame.
    pub(crate) shared: f64,
    /// Share of the instances whose level is another one than in the frame before.
    pub(crate) changed: f64,
}

/// Curves of a crowd: up to a hundred points, each the mean of as many frames.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct CrowdCurve {
    /// The last second of each point.
    pub(crate) seconds: Vec<f64>,
    /// Triangles of a frame.
    pub(crate) continuous: Vec<f64>,
    pub(crate) discrete: Vec<f64>,
    pub(crate) none: Vec<f64>,
}

/// Triangles of a figure over its distance, the mean of all inputs.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct DistanceCurve {
    /// From 0, the viewer, to 1, the corners.
    pub(crate) distance: Vec<f64>,
    pub(crate) continuous: Vec<f64>,
    pub(crate) discrete: Vec<f64>,
    pub(crate) none: Vec<f64>,
}

/// A crowd on a graphics device.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct CrowdOnDevice {
    pub(crate) adapter: String,
    /// Whose clock: `device` (time stamps around passes) or `host` (from submitting to being done).
    pub(crate) clock: &'static str,
    /// Frames that were drawn, evenly over the time.
    pub(crate) frames: u32,
    pub(crate) continuous: DrawnFrames,
    pub(crate) discrete: DrawnFrames,
    pub(crate) none: DrawnFrames,
}

/// Means over the frames that were drawn.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct DrawnFrames {
    /// Of the best round.
    pub(crate) draw_ms_per_frame: f64,
    /// Instanced draws: instances with the same level in the same pose share one.
    pub(crate) draws_per_frame: f64,
    /// Bytes of the index lists of all levels, each sent once for a frame.
    pub(crate) index_bytes_per_frame: f64,
    pub(crate) triangles_per_frame: f64,
}
