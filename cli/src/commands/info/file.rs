//! `lodc info` of a `.lodc`: counts, levels, strips, and the bytes of every section.

use crate::commands::building::counts;
use crate::commands::read::parse_lodc;
use crate::exit::Outcome;
use indexmap::IndexMap;
use lodc::{LodFile, LodObject, levels, scene_levels};
use lodc_formats::lodc::{self as container, Layout};
use lodc_formats::{Limits, ObjectInfo, scene_graph};
use lodc_lod::AnyModel;
use lodc_lod::interactive::CollapseLists;
use lodc_mesh::{CollapseSequence, Lod};
use lodc_model::{Model, StorageCost};
use lodc_report::documents::{
    BitsPerVertex, ErrorOrigin, InfoReport, ListsReport, ListsToReport, LodReport, ModelReport,
    ObjectCounts, ObjectReport, SceneLevelReport, SourceReport, StripsReport,
};
use lodc_report::text::{count, distance, grouped, size};
use lodc_report::{ErrorsOver, SCHEMA_VERSION};
use lodc_scene::{Arrangement, posed_positions};
use lodc_select::{Target, decimal};
use lodc_strip::Effort;
use lodc_strip::{StripKind, Strips};
use std::fmt::Write;
use std::sync::Arc;

/// Shares of the LODs, in percent, to which the lengths of collapse lists are reported.
const LIST_SHARES: [u32; 5] = [50, 75, 90, 95, 100];

/// Shares of the triangles in the table of a scene's levels.
const TABLE_SHARES: [f64; 6] = [1.0, 0.5, 0.25, 0.1, 0.05, 0.01];

/// Returns what is inside a file. `name` is the file's, for messages. `scene_limits`: `None` for
/// text, which prints nothing of the whole scene.
///
/// # Errors
/// If it is damaged, a baseline cannot be made, or the scene is beyond the limits.
pub(super) fn report(
    name: &str,
    bytes: &[u8],
    baselines: bool,
    scene_limits: Option<&Limits>,
) -> Outcome<InfoReport> {
    let file = parse_lodc(bytes, name)?;
    let (bounds, levels_table) = match scene_limits {
        Some(limits) => (bounds(&file, limits)?, levels_table(&file, limits)?),
        None => (None, Vec::new()),
    };
    Ok(InfoReport {
        schema_version: SCHEMA_VERSION,
        format: "lodc",
        format_version: container::VERSION,
        key: format!("{:032x}", container::key(bytes)),
        bytes: bytes.len() as u64,
        source: SourceReport {
            format: file.source.format.name(),
            content_hash: format!("{:032x}", file.source.content_hash),
        },
        layout: file.layout.name(),
        bounds,
        levels_table,
        objects: file
            .objects
            .iter()
            .map(|o| object_report(o, file.layout, baselines))
            .collect::<Outcome<_>>()?,
    })
}

/// The lowest and the highest corner of what the scene shows at rest.
fn bounds(file: &LodFile, limits: &Limits) -> Outcome<Option<[[f64; 3]; 2]>> {
    let infos: Vec<&ObjectInfo> = file.objects.iter().map(|o| &o.info).collect();
    let graph = scene_graph(&file.document, &infos, limits)?;
    let scene = Arrangement::new(&graph, &graph.rest_pose(), infos.len());
    let mut bounds: Option<[[f64; 3]; 2]> = None;
    for placement in scene.placements() {
        for p in posed_positions(file.objects[placement.object].simplified.mesh(), placement) {
            let p = p.to_array();
            let [low, high] = bounds.unwrap_or([p, p]);
            let low = std::array::from_fn(|k| low[k].min(p[k]));
            let high = std::array::from_fn(|k| high[k].max(p[k]));
            bounds = Some([low, high]);
        }
    }
    Ok(bounds)
}

/// Levels of the whole scene; none if it has no triangles.
fn levels_table(file: &LodFile, limits: &Limits) -> Outcome<Vec<SceneLevelReport>> {
    let levels = scene_levels(&file.objects, &file.document, limits)?;
    let is_empty = levels.objects().iter().all(|o| o.simplified.mesh().triangles().is_empty());
    let level = |&ratio: &f64| {
        let chosen = levels.select(Target::Ratio(ratio))?;
        let (mut triangles, mut error) = (0, 0.0f64);
        for (o, &lod) in levels.objects().iter().zip(&chosen.lods) {
            let collapses = o.simplified.collapses();
            triangles += u64::from(collapses.triangles_at(lod));
            error = error.max(o.scale * decimal(collapses.error_at(lod)));
        }
        let error = error.is_finite().then_some(error);
        Ok(SceneLevelReport { ratio, triangles, error })
    };
    let shares: &[f64] = if is_empty { &[] } else { &TABLE_SHARES };
    shares.iter().map(level).collect()
}

fn object_report(o: &LodObject, layout: Layout, baselines: bool) -> Outcome<ObjectReport> {
    let (collapses, scale) = (o.simplified.collapses(), o.info.world_scale);
    let lods = levels::table_lods(collapses).into_iter().map(|lod| {
        let (error, rms) = (collapses.error_at(lod), collapses.rms_at(lod).map(decimal));
        let error = decimal(error);
        LodReport {
            lod: lod.0,
            triangles: collapses.triangles_at(lod),
            error,
            rms,
            world_error: scale * error,
            world_rms: rms.map(|rms| scale * rms),
        }
    });
    let mut models: IndexMap<_, _> =
        o.models.iter().map(|m| (m.name(), stored_model(m, layout))).collect();
    if baselines {
        let strips = Arc::new(plain_strips(o));
        for baseline in lodc_lab::baselines(o, &strips)? {
            models.insert(baseline.name(), storage_bits(&baseline.storage(), None));
        }
        for (name, cost) in lodc_lab::plain(&o.simplified, &strips) {
            models.insert(name, storage_bits(&cost, None));
        }
    }
    Ok(ObjectReport {
        counts: counts(&o.info, &o.simplified),
        world_scale: o.info.world_scale,
        diagonal: o.simplified.mesh().diagonal(),
        errors_over: ErrorsOver::of([&o.info]),
        errors: match collapses.is_measured() {
            true => ErrorOrigin::Measured,
            false => ErrorOrigin::Estimate,
        },
        collapse_lists: collapse_lists_report(collapses),
        lods: lods.collect(),
        strips: strips(o),
        models,
    })
}

/// Lengths of the collapse lists: to the last level, and to shares of the LODs.
fn collapse_lists_report(collapses: &CollapseSequence) -> ListsReport {
    let to = |percent: u32| {
        let share = u64::from(collapses.records()) * u64::from(percent) / 100;
        let lod = collapses.floor(Lod(share as u32));
        let lengths = CollapseLists::lengths(collapses.targets(), lod);
        let entries: u64 = lengths.iter().map(|&l| u64::from(l)).sum();
        ListsToReport {
            percent,
            lod: lod.0,
            mean: entries as f64 / lengths.len() as f64,
            longest: lengths.into_iter().max().unwrap_or(0),
        }
    };
    let down_to = LIST_SHARES.map(to);
    let whole = down_to[LIST_SHARES.len() - 1];
    ListsReport { mean: whole.mean, longest: whole.longest, down_to: down_to.to_vec() }
}

/// Long strips: those of a model that is made for long ones and has some, or new ones. (Others may
/// cut them.)
fn plain_strips(o: &LodObject) -> Strips {
    let long = o.models.iter().filter(|m| m.kind().strips() == Some(StripKind::LONGEST));
    let stored = long.filter_map(AnyModel::strips).find(|s| s.kind == StripKind::LONGEST);
    stored
        .cloned()
        .unwrap_or_else(|| Strips::generate(&o.simplified, StripKind::LONGEST, Effort::Default))
}

/// Strips that are stored, by their generator.
fn strips(o: &LodObject) -> IndexMap<&'static str, StripsReport> {
    let mut all = IndexMap::new();
    for strips in o.models.iter().filter_map(AnyModel::strips) {
        let report = lodc_lab::strip_primitives(o.simplified.mesh(), strips);
        all.entry(strips.kind.name()).or_insert(StripsReport {
            strips: report.strips,
            indices: report.indices,
            acmr_fifo16: report.acmr_fifo16,
        });
    }
    all
}

fn stored_model(model: &AnyModel, layout: Layout) -> ModelReport {
    storage_bits(&model.storage(), Some(lodc::stored_bytes(model, layout)))
}

fn storage_bits(cost: &StorageCost, file: Option<u64>) -> ModelReport {
    ModelReport {
        bits_per_vertex: BitsPerVertex {
            thesis: cost.thesis(),
            thesis_normals: cost.thesis_normals(),
            file: file.map(|bytes| cost.bits_per_vertex(bytes)),
        },
    }
}

/// The report for people.
pub(super) fn text(name: &str, report: &InfoReport) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{name}: format version {}, {} layout, {}, from {}, {}",
        report.format_version,
        report.layout,
        size(report.bytes),
        report.source.format,
        count(report.objects.len() as u64, "object")
    );
    let _ = writeln!(text, "  key {}, source {}", report.key, report.source.content_hash);
    for o in &report.objects {
        let _ = writeln!(text, "\n{}", crate::exit::one_line(&o.counts.name));
        write_counts(&mut text, &o.counts);
        let _ = writeln!(
            text,
            "  collapse lists: {:.1} entries on average, {} at most",
            o.collapse_lists.mean,
            grouped(u64::from(o.collapse_lists.longest))
        );
        write_levels(&mut text, o);
        if o.models.is_empty() {
            let _ = writeln!(text, "  no models, only the collapse sequence");
        }
        for (model, cost) in &o.models {
            let bits = &cost.bits_per_vertex;
            let file = bits.file.map_or("-".to_owned(), |file| format!("{file:.1}"));
            let _ = writeln!(
                text,
                "  {model}: bits per vertex {:.1} (thesis), {:.1} (with normals), {file} (in this \
                 file)",
                bits.thesis, bits.thesis_normals
            );
        }
    }
    text
}

fn write_levels(text: &mut String, o: &ObjectReport) {
    let scaled = o.world_scale != 1.0;
    let own = if scaled { "       in its own units" } else { "" };
    let _ =
        writeln!(text, "         LOD   triangles       error   of the diagonal         rms{own}");
    for lod in &o.lods {
        let share = if o.diagonal > 0.0 { lod.error / o.diagonal * 100.0 } else { 0.0 };
        let rms = |rms: Option<f64>| rms.map_or("-".to_owned(), distance);
        let own = match scaled {
            true => format!("{:>12}{:>11}", distance(lod.error), rms(lod.rms)),
            false => String::new(),
        };
        let _ = writeln!(
            text,
            "  {:>10}{:>12}{:>12}{share:16.3} %{:>12}{own}",
            grouped(u64::from(lod.lod)),
            grouped(u64::from(lod.triangles)),
            distance(lod.world_error),
            rms(lod.world_rms),
        );
    }
    if o.errors_over != ErrorsOver::REST {
        let _ = writeln!(text, "  {}", o.errors_over);
    }
    if o.errors == ErrorOrigin::Estimate {
        let _ = writeln!(text, "  error: estimate (build the file again to have it measured)");
    }
}

fn write_counts(text: &mut String, c: &ObjectCounts) {
    let _ = writeln!(
        text,
        "  {}, {}, {}, {} duplicated at seams",
        count(c.triangles, "triangle"),
        count(c.referenced_vertices, "vertex"),
        count(c.submeshes, "submesh"),
        if c.fakes == 0 { "no vertices".to_owned() } else { grouped(c.fakes) }
    );
    let _ = writeln!(
        text,
        "  {} in {}, valid down to LOD {}, {} of topology before it",
        count(c.records, "record"),
        count(c.steps, "step"),
        grouped(u64::from(c.last_legal_lod)),
        count(u64::from(c.topology_changes), "change")
    );
}
