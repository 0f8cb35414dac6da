//! How the costs of a collapse in several shapes become one.

use glam::Vec4;
use std::sync::LazyLock;

static RULE: LazyLock<(u8, f64)> = LazyLock::new(|| {
    let text = std::env::var("LODC_COMB").unwrap_or_else(|_| "max".into());
    if text == "max" {
        (0, 0.0)
    } else if text == "sum" {
        (1, 0.0)
    } else {
        (2, text.parse().unwrap())
    }
});

/// The cost in two shapes.
#[inline]
pub(super) fn together(a: f64, b: f64) -> f64 {
    match RULE.0 {
        0 => a.max(b),
        1 => a + b,
        _ => a.max(b) + RULE.1 * a.min(b),
    }
}

/// The same for four costs at a time.
#[inline]
pub(super) fn together_of_four(a: Vec4, b: Vec4) -> Vec4 {
    match RULE.0 {
        0 => a.max(b),
        1 => a + b,
        _ => a.max(b) + RULE.1 as f32 * a.min(b),
    }
}
