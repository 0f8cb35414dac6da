//! Huge pages: 2 MiB of memory for one page fault instead of 512. Work on meshes of medium size
//! is a tenth to a fifth faster with them. Small meshes gain nothing and would take tens of MB
//! more; large ones would take a third more.

use std::ops::Range;

/// Bytes of memory of the work on an asset for which huge pages are worth it: about 40,000 to
/// 900,000 triangles.
const WORTHWHILE: Range<u64> = 8_000_000..200_000_000;

/// Forbids huge pages for memory taken from now on, also in programs that this one starts.
pub(crate) fn forbid() {
    allow_if(false);
}

/// Allows huge pages if they are worth it for work that is expected to take `bytes` bytes.
pub(crate) fn allow_for(bytes: u64) {
    allow_if(WORTHWHILE.contains(&bytes));
}

/// Forbids huge pages for work that takes more bytes than they are worth it for, or more than a
/// quarter of `available`: with them up to four times the expected bytes were measured.
pub(crate) fn forbid_for(bytes: u64, available: Option<u64>) {
    if bytes >= WORTHWHILE.end || available.is_some_and(|available| bytes > available / 4) {
        forbid();
    }
}

/// Asks the system. Where that fails, work is slower or takes more memory; results are the same.
#[cfg(target_os = "linux")]
fn allow_if(allowed: bool) {
    let _ = rustix::thread::disable_transparent_huge_pages(!allowed);
}

/// Does nothing: other systems have no such pages, or no such setting.
#[cfg(not(target_os = "linux"))]
fn allow_if(_: bool) {}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use lodc::pipeline::Size;
    use rustix::thread::transparent_huge_pages_are_disabled;

    /// The state is the process's: one test for all of it.
    #[test]
    fn huge_pages_are_for_meshes_of_medium_size() {
        let errors =
            |triangles| Size { triangles, vertices: triangles / 2, moving: 0 }.errors().bytes;
        for (triangles, is_medium) in [(5_000, false), (70_000, true), (1_000_000, false)] {
            allow_for(errors(triangles));
            assert_eq!(transparent_huge_pages_are_disabled(), Ok(!is_medium), "{triangles}");
        }
        let [medium, large] = [70_000, 1_000_000].map(errors);
        for (bytes, available, is_forbidden) in [
            (medium, None, false),
            (medium, Some(4 * medium), false),
            (medium, Some(3 * medium), true),
            (large, None, true),
        ] {
            allow_for(medium);
            forbid_for(bytes, available);
            assert_eq!(transparent_huge_pages_are_disabled(), Ok(is_forbidden), "{bytes}");
        }
    }
}
