//! The compute shaders of Interactive Meshes, by name, for replays and for engines
//! (docs/ENGINE.md).

use lodc_plan::{SCAN, SCAN_ADD, Shader};

/// Construction: lengths of collapse lists.
pub(super) const LISTS_LENGTH: Shader =
    Shader { name: "lists_length", wgsl: include_str!("lists_length.wgsl") };
/// Construction: collapse lists.
pub(super) const LISTS_FILL: Shader =
    Shader { name: "lists_fill", wgsl: include_str!("lists_fill.wgsl") };
/// Continuous extraction.
pub(super) const EXTRACT: Shader = Shader { name: "extract", wgsl: include_str!("extract.wgsl") };
/// Live triangles.
pub(super) const LIVE: Shader = Shader { name: "live", wgsl: include_str!("live.wgsl") };
/// Continuous extraction of many instances.
pub(super) const EXTRACT_MANY: Shader =
    Shader { name: "extract_many", wgsl: include_str!("extract_many.wgsl") };
/// Live triangles of many instances.
pub(super) const LIVE_MANY: Shader =
    Shader { name: "live_many", wgsl: include_str!("live_many.wgsl") };
/// View-dependent extraction.
pub(super) const VIEW: Shader = Shader { name: "view", wgsl: include_str!("view/view.wgsl") };
/// Degenerate filter: which triangles are drawn.
pub(super) const FILTER_COUNT: Shader =
    Shader { name: "filter_count", wgsl: include_str!("view/filter_count.wgsl") };
/// Degenerate filter: their corners.
pub(super) const FILTER_WRITE: Shader =
    Shader { name: "filter_write", wgsl: include_str!("view/filter_write.wgsl") };
/// Degenerate filter: arguments of draws.
pub(super) const FILTER_DRAWS: Shader =
    Shader { name: "filter_draws", wgsl: include_str!("view/filter_draws.wgsl") };

/// All that an engine needs, in the order in which it needs them.
pub const ALL: [Shader; 12] = [
    LISTS_LENGTH,
    SCAN,
    SCAN_ADD,
    LISTS_FILL,
    EXTRACT,
    LIVE,
    EXTRACT_MANY,
    LIVE_MANY,
    VIEW,
    FILTER_COUNT,
    FILTER_WRITE,
    FILTER_DRAWS,
];
