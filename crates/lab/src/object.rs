//! Runs all measurements of `lodc bench` on one object.

use crate::device::{self, Device};
use crate::error::LabError;
use crate::prepared::Prepared;
use crate::primitives;
use crate::report::{
    BenchObject, Bits, CurveReport, DrawnReport, ExtractionReport, ExtractionSpread, Settings,
    StructureReport, TrafficReport,
};
use crate::stream;
use crate::structures::{Measured, all_measured, baselines, plain};
use crate::sweep::{Counts, Times, counts, points, stops, times};
use crate::timings::Timings;
use indexmap::IndexMap;
use lodc_mesh::{CollapseSequence, Lod, Simplified};
use lodc_model::StorageCost;
use lodc_strip::StripKind;

/// Measures one object; on a graphics device too, if there is one and times are wanted.
///
/// # Errors
/// If a baseline or a stream cannot be made of its sequence (a bug), or the device fails.
pub fn measure(
    prepared: &Prepared,
    settings: &Settings,
    device: Option<&Device>,
) -> Result<BenchObject, LabError> {
    let (object, long) = (&prepared.object, prepared.strips(StripKind::LONGEST));
    let collapses = object.simplified.collapses();
    let sweep = Sweep::new(collapses, settings.steps);
    let baselines = baselines(object, long)?;
    let mut structures = all_measured(object, &baselines);
    // Before anything is timed: a jump leaves work for later moves.
    let moved: Vec<Counts> =
        structures.iter_mut().map(|s| counts(s.runner.as_mut(), &sweep.stops)).collect();
    let times = settings
        .rounds
        .filter(|_| !sweep.stops.is_empty())
        .map(|rounds| ObjectTimes::new(&mut structures, &object.simplified, &sweep, rounds));
    let mut models = IndexMap::new();
    for (structure, moved) in structures.iter().zip(&moved) {
        let row = structure_report(structure, moved, &sweep, times.as_ref());
        models.insert(structure.name, row);
    }
    for (name, cost) in plain(&object.simplified, long) {
        models.insert(name, plain_report(cost));
    }
    let lods = primitives::lods(&object.simplified);
    let [whole, fifth] = [primitives::all(prepared, lods[0])?, primitives::all(prepared, lods[1])?];
    let mut report = BenchObject {
        records: collapses.records(),
        updates: sweep.stops.len() as u64,
        jump_lod: sweep.far.0,
        curve: curve(collapses, &sweep.stops),
        rebuild_us: times.as_ref().map(|t| t.rebuild.best()),
        rebuild_spread: times.as_ref().map(|t| t.rebuild.spread()),
        primitives: primitives::reports(&object.simplified, lods[0], &whole),
        primitives_20: primitives::reports(&object.simplified, lods[1], &fifth),
        models,
        gpu: None,
        stream: None,
    };
    if settings.streams {
        report.stream = Some(stream::measure(prepared, settings.rounds)?);
    }
    if let (Some(device), Some(rounds)) = (device, settings.rounds) {
        report.gpu =
            device::measure(device, object, [whole, fifth], &mut structures, &sweep.stops, rounds)?;
    }
    Ok(report)
}

/// LODs and their triangles for curves.
fn curve(collapses: &CollapseSequence, stops: &[Lod]) -> CurveReport {
    let lods = points(stops);
    CurveReport {
        triangles: lods.iter().map(|&lod| collapses.triangles_at(lod)).collect(),
        lods: lods.into_iter().map(|lod| lod.0).collect(),
    }
}

/// The LODs that models are moved to.
struct Sweep {
    /// On the way down; the way up is the same.
    stops: Vec<Lod>,
    /// Triangles at all stops together.
    triangles: u64,
    /// The target of the jump from LOD 0.
    far: Lod,
}

impl Sweep {
    fn new(collapses: &CollapseSequence, share: f64) -> Self {
        let stops = stops(collapses, share);
        let triangles = stops.iter().map(|&lod| u64::from(collapses.triangles_at(lod))).sum();
        let far = collapses.lod_for_triangles(collapses.parts().triangles / 100);
        Self { stops, triangles, far: far.min(collapses.last_visible()) }
    }
}

/// Times of all structures that show every LOD.
struct ObjectTimes {
    by_name: Vec<(&'static str, Times)>,
    /// Microseconds to make the far LOD's index list from scratch.
    rebuild: Timings,
}

impl ObjectTimes {
    fn new(
        structures: &mut [Measured<'_>],
        simplified: &Simplified,
        sweep: &Sweep,
        rounds: u32,
    ) -> Self {
        let continuous = structures.iter_mut().filter(|s| s.continuous);
        let (names, mut runners): (Vec<_>, Vec<_>) =
            continuous.map(|s| (s.name, &mut s.runner)).unzip();
        let (all, rebuild) = times(&mut runners, simplified, &sweep.stops, sweep.far, rounds);
        Self { by_name: names.into_iter().zip(all).collect(), rebuild }
    }

    /// The times of a structure.
    fn times(&self, name: &str) -> Option<&Times> {
        self.by_name.iter().find(|(other, _)| *other == name).map(|(_, times)| times)
    }

    /// The times of a structure as the report has them.
    fn extraction(&self, name: &str) -> Option<ExtractionReport> {
        let times = self.times(name)?;
        let per = |baseline: &str| self.times(baseline).map(|b| times.both_ways() / b.both_ways());
        Some(ExtractionReport {
            coarser_us: times.coarser.best(),
            finer_us: times.finer.best(),
            mean_us: times.both_ways(),
            per_progressive_mesh: per("progressive_mesh"),
            per_lodstrips: per("lodstrips"),
            jump_us: times.jump.best(),
            jump_per_rebuild: times.jump.best() / self.rebuild.best(),
            curve_us: times.curve.clone(),
            spread: ExtractionSpread {
                coarser: times.coarser.spread(),
                finer: times.finer.spread(),
                jump: times.jump.spread(),
            },
        })
    }
}

/// The row of a model or baseline that has levels of detail. `moved` are the counts of its sweep.
fn structure_report(
    structure: &Measured<'_>,
    moved: &Counts,
    sweep: &Sweep,
    times: Option<&ObjectTimes>,
) -> StructureReport {
    let per = |all: u64, each: u64| all as f64 / each.max(1) as f64;
    let (updates, drawn) = (sweep.stops.len() as u64, moved.drawn.iter().sum());
    StructureReport {
        baseline: structure.baseline,
        bits_per_vertex: bits(structure.storage, structure.file_bytes, structure.tight_bytes),
        drawn: Some(DrawnReport {
            indices_per_lod: per(drawn, updates),
            indices_per_triangle: per(drawn, sweep.triangles),
            curve: points(&moved.drawn),
            degenerates_removed: structure.degenerates_removed,
        }),
        traffic: structure.continuous.then(|| TrafficReport {
            bytes_per_update: per(moved.bytes, 2 * updates),
            upload_bytes_per_update: per(
                if structure.sends_strips() { moved.one_by_one } else { moved.bytes },
                2 * updates,
            ),
            rewritten_per_update: per(moved.rewritten, 2 * updates),
            length_changes: structure.length_changes,
        }),
        extraction: times.and_then(|times| times.extraction(structure.name)),
    }
}

/// The row of what has no levels of detail: its storage.
fn plain_report(cost: StorageCost) -> StructureReport {
    StructureReport {
        baseline: true,
        bits_per_vertex: bits([cost, cost], None, None),
        drawn: None,
        traffic: None,
        extraction: None,
    }
}

/// Bits per vertex: of the storage of all LODs and down to 95 % of them, and of bytes in a file and
/// really held.
fn bits([all, to_95_percent]: [StorageCost; 2], file: Option<u64>, tight: Option<u64>) -> Bits {
    let per_vertex = |bytes: Option<u64>| bytes.map(|b| all.bits_per_vertex(b));
    Bits {
        thesis: all.thesis(),
        thesis_normals: all.thesis_normals(),
        thesis_95: to_95_percent.thesis(),
        thesis_normals_95: to_95_percent.thesis_normals(),
        file: per_vertex(file),
        tight: per_vertex(tight),
    }
}
