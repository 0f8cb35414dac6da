//! Options that raise or lower the limits on inputs.

use crate::exit::{Failure, Outcome, Status};
use crate::huge_pages;
use crate::text::{count, size as size_of};
use clap::Args;
use lodc::build::{Need, Size};
use lodc_formats::Limits;
use lodc_formats::import::ImportOptions;
use std::path::PathBuf;

/// Options of reading inputs, shared by every command that reads a mesh.
#[derive(Args, Clone, Debug)]
pub(crate) struct ImportArgs {
    /// Join positions closer than EPS times the bounding box's diagonal (0: identical ones only)
    #[arg(long, value_name = "EPS", default_value = "0", value_parser = weld)]
    weld: f64,
    /// Also read files under DIR that the input refers to (may be given several times)
    #[arg(long, value_name = "DIR")]
    allow_path: Vec<PathBuf>,
    #[command(flatten)]
    limits: LimitArgs,
}

impl ImportArgs {
    pub(crate) fn options(&self) -> ImportOptions {
        ImportOptions {
            limits: self.limits.limits(),
            allowed: self.allow_path.clone(),
            weld: self.weld,
        }
    }
    pub(crate) fn limits(&self) -> &LimitArgs {
        &self.limits
    }
}

/// The limits themselves. Reaching one ends with status 5.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Limits")]
pub(crate) struct LimitArgs {
    /// Largest single file, in bytes (K, M, G, T: powers of 1024) [default: 4G]
    #[arg(long, value_name = "SIZE", value_parser = size)]
    limit_file_bytes: Option<u64>,
    /// Largest sum of all files of one input [default: 8G]
    #[arg(long, value_name = "SIZE", value_parser = size)]
    limit_total_bytes: Option<u64>,
    /// Longest line of a text format [default: 64M]
    #[arg(long, value_name = "SIZE", value_parser = size)]
    limit_line_bytes: Option<u64>,
    /// Most vertices of one input [default: 256M]
    #[arg(long, value_name = "COUNT", value_parser = size)]
    limit_vertices: Option<u64>,
    /// Most triangles of one input [default: 256M]
    #[arg(long, value_name = "COUNT", value_parser = size)]
    limit_triangles: Option<u64>,
    /// Memory that a build may be expected to need [default: what the machine has]
    #[arg(long, value_name = "SIZE", value_parser = size)]
    limit_memory: Option<u64>,
}

impl LimitArgs {
    pub(crate) fn limits(&self) -> Limits {
        let default = Limits::DEFAULT;
        Limits {
            file_bytes: self.limit_file_bytes.unwrap_or(default.file_bytes),
            total_bytes: self.limit_total_bytes.unwrap_or(default.total_bytes),
            line_bytes: self.limit_line_bytes.unwrap_or(default.line_bytes),
            vertices: self.limit_vertices.unwrap_or(default.vertices),
            triangles: self.limit_triangles.unwrap_or(default.triangles),
            ..default
        }
    }

    /// Bytes of memory that may be used: what was asked for, or what the machine has; none if
    /// nobody knows.
    pub(crate) fn memory(&self) -> Option<u64> {
        self.limit_memory.or_else(crate::memory::available_bytes)
    }

    /// Refuses work on an asset that would not fit into memory, before the system kills the process
    /// for it. `name` is the asset's, `needs` are those of the stages that follow. Large work,
    /// or work in little memory, gets no more huge pages.
    ///
    /// # Errors
    /// If a stage needs more than there is, or than `--limit-memory` allows.
    pub(crate) fn check_memory(&self, name: &str, size: Size, needs: &[Need]) -> Outcome<()> {
        let (most, limit) = (needs.iter().max(), self.memory());
        huge_pages::forbid_for(most.map_or(0, |need| need.bytes), limit);
        match (most, limit) {
            (Some(Need { bytes, stage }), Some(limit)) if *bytes > limit => Err(Failure::new(
                Status::Limit,
                format!(
                    "{name}: {} may need {} of memory (stage {stage}), more than the limit of {} \
                     (--limit-memory)",
                    count(size.triangles, "triangle"),
                    size_of(*bytes),
                    size_of(limit)
                ),
            )),
            _ => Ok(()),
        }
    }
}

fn weld(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    if (0.0..1.0).contains(&value) {
        Ok(value)
    } else {
        Err("a share of the diagonal, from 0 to below 1".to_owned())
    }
}

/// A count or size with an optional power of 1024: `123`, `64K`, `2G`.
fn size(text: &str) -> Result<u64, String> {
    let (digits, shift) =
        match text.char_indices().next_back().map(|(i, c)| (i, c.to_ascii_uppercase())) {
            Some((i, 'K')) => (&text[..i], 10),
            Some((i, 'M')) => (&text[..i], 20),
            Some((i, 'G')) => (&text[..i], 30),
            Some((i, 'T')) => (&text[..i], 40),
            _ => (text, 0),
        };
    let number: u64 = digits.parse().map_err(|e| format!("{e}"))?;
    number.checked_mul(1 << shift).ok_or_else(|| "too large".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_take_powers_of_1024_and_refuse_what_does_not_fit() {
        assert_eq!(size("12"), Ok(12));
        assert_eq!(size("64k"), Ok(64 << 10));
        assert_eq!(size("2G"), Ok(2 << 30));
        for wrong in ["", "K", "-1", "1.5M", "99999999999T", "3X", "é"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn welding_takes_a_share_below_one() {
        assert_eq!(weld("0.001"), Ok(0.001));
        for wrong in ["1", "-0.1", "NaN", "inf", "x"] {
            assert!(weld(wrong).is_err(), "{wrong}");
        }
    }
}
