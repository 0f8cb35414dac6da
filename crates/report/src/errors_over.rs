//! The poses over which stated errors are the largest, as reports name them.

use crate::text::count;
use lodc_formats::ObjectInfo;
use serde::Serialize;

/// The poses that the errors of some objects hold in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ErrorsOver {
    /// True: errors hold in the rest pose.
    pub rest: bool,
    /// Other poses, of the object that has most of them.
    pub poses: usize,
}

impl ErrorsOver {
    /// The rest pose alone.
    pub const REST: Self = Self { rest: true, poses: 0 };

    /// The poses that the errors of a file's objects hold in.
    #[must_use]
    pub fn of<'a>(objects: impl IntoIterator<Item = &'a ObjectInfo>) -> Self {
        let max_poses = objects.into_iter().map(|info| info.poses.len()).max();
        Self { poses: max_poses.unwrap_or(0), ..Self::REST }
    }
}

impl std::fmt::Display for ErrorsOver {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.poses {
            0 => f.write_str("errors at rest"),
            poses => write!(f, "errors over rest and {}", count(poses as u64, "pose")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn people_read_what_errors_are_over() {
        assert_eq!(ErrorsOver::of([]).to_string(), "errors at rest");
        let over = |poses| ErrorsOver { poses, ..ErrorsOver::REST }.to_string();
        assert_eq!(over(1), "errors over rest and 1 pose");
        assert_eq!(over(8), "errors over rest and 8 poses");
    }
}
