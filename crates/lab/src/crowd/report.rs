//! `crowd` of `bench --json`. Its keys are a contract as those in `crate::report` are.

use serde::Serialize;
use std::collections::BTreeMap;

/// A crowd that was measured.
#[derive(Debug, Serialize)]
pub(in crate::commands::bench) struct CrowdReport {
    pub(super) instances: u32,
    pub(super) frames: u32,
    pub(super) seed: u64,
    pub(super) models: BTreeMap<&'static str, Policies>,
    /// Everything at LOD 0.
    pub(super) none: Frames,
    /// Over time.
    pub(super) curve: CrowdCurve,
    /// Null if nothing was drawn on a graphics device.
    pub(super) gpu: Option<CrowdOnDevice>,
}

/// A structure with levels by distance.
#[derive(Debug, Serialize)]
pub(super) struct Policies {
    /// Every LOD.
    pub(super) continuous: Frames,
    /// Five levels, each with 25 % fewer triangles than the one before.
    pub(super) discrete: Frames,
}

/// Means over frames.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Frames {
    pub(super) triangles_per_frame: f64,
    /// Null with `--no-times`.
    pub(super) extraction_ms_per_frame: Option<f64>,
    /// At each point of the crowd's curve, each frame in its best round; null with `--no-times`.
    pub(super) extraction_ms_curve: Option<Vec<f64>>,
    /// Share of the instances whose level another one of the same input has in the same frame.
    pub(super) shared: f64,
    /// Share of the instances whose level is another one than in the frame before.
    pub(super) changed: f64,
}

/// Curves of a crowd: up to a hundred points, each the mean of as many frames.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct CrowdCurve {
    /// The last second of each point.
    pub(super) seconds: Vec<f64>,
    /// Triangles of a frame.
    pub(super) continuous: Vec<f64>,
    pub(super) discrete: Vec<f64>,
    pub(super) none: Vec<f64>,
}

/// A crowd on a graphics device.
#[derive(Clone, Debug, Serialize)]
pub(super) struct CrowdOnDevice {
    pub(super) adapter: String,
    /// Whose clock: `device` (time stamps around passes) or `host` (from submitting to being done).
    pub(super) clock: &'static str,
    /// Frames that were drawn, evenly over the time.
    pub(super) frames: u32,
    pub(super) continuous: DrawnFrames,
    pub(super) discrete: DrawnFrames,
    pub(super) none: DrawnFrames,
}

/// Means over the frames that were drawn.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct DrawnFrames {
    /// Of the best round.
    pub(super) draw_ms_per_frame: f64,
    /// Instanced draws: instances with the same level in the same pose share one.
    pub(super) draws_per_frame: f64,
    /// Bytes of the index lists of all levels, each sent once for a frame.
    pub(super) index_bytes_per_frame: f64,
    pub(super) triangles_per_frame: f64,
}
