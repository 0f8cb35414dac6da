//! Comparisons as CI systems show them.

use super::measure::Measured;
use crate::batch::Asset;
use crate::commands::ci::{Case, Suite, Verdict};
use crate::exit::Outcome;

/// A suite for each pair, under the name of the mesh that was compared with: that one is the
/// author's. A pair that could not be compared has the name of the file that was to be judged.
pub(super) fn suites(assets: &[Asset], done: &[Outcome<Measured>]) -> Vec<Suite> {
    assets.iter().zip(done).map(|(asset, measured)| suite(asset, measured)).collect()
}

fn suite(asset: &Asset, measured: &Outcome<Measured>) -> Suite {
    let report = match measured {
        Ok(measured) => &measured.report,
        Err(failure) => {
            let verdict = Verdict::Error(failure.message.clone());
            let cases = vec![Case { name: "compare".to_owned(), verdict }];
            return Suite { name: asset.input.display().to_string(), cases };
        }
    };
    let cases = report.comparisons().into_iter().map(|(level, comparison)| Case {
        name: level.map_or_else(|| report.b.clone(), |level| format!("{} at {level}", report.b)),
        verdict: match comparison.exceeded.as_slice() {
            [] => Verdict::Passed,
            lines => Verdict::Failed(lines.join("; ")),
        },
    });
    Suite { name: report.a.clone(), cases: cases.collect() }
}
