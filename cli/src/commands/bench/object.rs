//! All measurements of one object.

use super::measure::{Times, counts, stops, times};
use super::report::{
    BenchObject, Bits, DrawnReport, ExtractionReport, SubjectReport, TrafficReport,
};
use super::subject::{Subject, baselines, plain, subjects};
use super::{BenchArgs, Prepared, gpu, primitives, stream};
use crate::commands::build::counts as object_counts;
use crate::exit::Outcome;
use crate::gpu::Device;
use lodc_model::StorageCost;
use lodc_strip::StripKind;
use serde::Serialize;
use serde_json::{Map, Value};

/// Measures one object.
///
/// # Errors
/// If a baseline cannot be made of its sequence (a bug), or a graphics device fails.
pub(super) fn measure(
    args: &BenchArgs,
    device: Option<&Device>,
    prepared: &Prepared,
) -> Outcome<BenchObject> {
    let Prepared { object, stripe, cache } = prepared;
    let (mesh, collapses) = (object.simplified.mesh(), object.simplified.collapses());
    let stops = stops(collapses, args.steps);
    let far = collapses
        .lod_for_triangles(collapses.parts().triangles / 100)
        .min(collapses.last_visible());
    let baselines = baselines(object, stripe)?;
    let mut subjects = subjects(object, &baselines);

    let mut timed: Vec<(&'static str, Times)> = Vec::new();
    let mut rebuild = None;
    if !args.no_times && !stops.is_empty() {
        let continuous: Vec<&mut Subject<'_>> =
            subjects.iter_mut().filter(|s| s.continuous).collect();
        let names: Vec<_> = continuous.iter().map(|s| s.name).collect();
        let mut runners: Vec<_> = continuous.into_iter().map(|s| &mut s.runner).collect();
        let (best, scratch) =
            times(&mut runners, &object.simplified, &stops, far, args.rounds.get());
        timed = names.into_iter().zip(best).collect();
        rebuild = Some(scratch);
    }

    let triangles: u64 = stops.iter().map(|&lod| u64::from(collapses.triangles_at(lod))).sum();
    let mut models = Map::new();
    for subject in &mut subjects {
        let moved = counts(subject.runner.as_mut(), &stops);
        let per = |all: u64, each: u64| all as f64 / each.max(1) as f64;
        let (updates, sweeps) = (stops.len() as u64, 2 * stops.len() as u64);
        let row = SubjectReport {
            baseline: subject.baseline,
            bits_per_vertex: bits(subject),
            drawn: Some(DrawnReport {
                indices_per_lod: per(moved.drawn, updates),
                indices_per_triangle: per(moved.drawn, triangles),
                degenerates_removed: subject.degenerates_removed,
            }),
            traffic: subject.continuous.then(|| TrafficReport {
                bytes_per_update: per(moved.bytes, sweeps),
                rewritten_per_update: per(moved.rewritten, sweeps),
            }),
            extraction: rebuild.and_then(|scratch| extraction(subject.name, &timed, scratch)),
        };
        models.insert(subject.name.to_owned(), value(&row));
    }
    for (name, cost) in plain(&object.simplified, stripe) {
        let bits_per_vertex = of_cost([cost, cost], None, None);
        let row = SubjectReport {
            baseline: true,
            bits_per_vertex,
            drawn: None,
            traffic: None,
            extraction: None,
        };
        models.insert(name.to_owned(), value(&row));
    }

    let primitives = [
        ("triangles", primitives::triangles(mesh)),
        ("triangles_cache", primitives::cache_ordered(mesh)),
        (StripKind::Stripe.name(), primitives::strips(mesh, stripe)),
        (StripKind::Cache.name(), primitives::strips(mesh, cache)),
    ];
    let mut report = BenchObject {
        counts: object_counts(&object.info, &object.simplified),
        updates: stops.len() as u64,
        jump_lod: far.0,
        rebuild_us: rebuild,
        primitives: primitives
            .into_iter()
            .map(|(name, report)| (name.to_owned(), value(&report)))
            .collect(),
        models,
        gpu: None,
        stream: if args.streams { Some(stream::measure(args, prepared)?) } else { None },
    };
    if let (Some(device), false) = (device, args.no_times) {
        gpu::measure(device, object, args.rounds.get(), &mut report)?;
    }
    Ok(report)
}

fn bits(subject: &Subject<'_>) -> Bits {
    of_cost(subject.storage, subject.file_bytes, subject.tight_bytes)
}

fn of_cost([all, most]: [StorageCost; 2], file: Option<u64>, tight: Option<u64>) -> Bits {
    let per_vertex = |bytes: Option<u64>| bytes.map(|b| all.bits_per_vertex(b));
    Bits {
        thesis: all.thesis(),
        thesis_normals: all.thesis_normals(),
        thesis_95: most.thesis(),
        thesis_normals_95: most.thesis_normals(),
        file: per_vertex(file),
        tight: per_vertex(tight),
    }
}

fn extraction(
    name: &str,
    timed: &[(&'static str, Times)],
    scratch: f64,
) -> Option<ExtractionReport> {
    let of = |wanted: &str| timed.iter().find(|(name, _)| *name == wanted).map(|(_, times)| times);
    let own = of(name)?;
    let per = |baseline: &str| of(baseline).map(|other| own.mean() / other.mean());
    Some(ExtractionReport {
        coarser_us: own.coarser,
        finer_us: own.finer,
        mean_us: own.mean(),
        per_progressive_mesh: per("progressive_mesh"),
        per_lodstrips: per("lodstrips"),
        jump_us: own.jump,
        jump_per_rebuild: own.jump / scratch,
    })
}

pub(super) fn value(report: &impl Serialize) -> Value {
    serde_json::to_value(report).expect("a struct of numbers is JSON")
}
