//! Strips and models, each beside a baseline of the same run: `cargo bench -p lodc-lab --bench
//! models`.
//!
//! Strips against sorting the triangles for a cache; making a model against simplifying the mesh; a
//! step of 0.1 % of the LODs, there and back, against Progressive Meshes; a jump from LOD 0 to 1 %
//! against making the index list from scratch. Throughput is in triangles of the input, or in
//! records passed, per second.

use criterion::{BenchmarkGroup, BenchmarkId, Criterion, Throughput, measurement::WallTime};
use lodc_lab::{Baseline, Rebuild};
use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::{Lod, Mesh, Simplified};
use lodc_model::Model;
use lodc_simplify::{Options, simplify};
use lodc_strip::{Effort, order};
use lodc_strip::{StripKind, StripOptions, StripPool, Strips};
use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

/// Closed without attributes; with seams, poles, normals and texture coordinates.
fn shapes() -> Vec<(&'static str, Mesh)> {
    vec![
        ("icosphere_20k", lodc_fixtures::icosphere(5)),
        ("uv_sphere_32k", lodc_fixtures::uv_sphere(180, 90)),
    ]
}

fn simplified(mesh: &Mesh) -> Arc<Simplified> {
    Arc::new(simplify(mesh, &Options::DEFAULT, &|_, _| ()))
}

fn kinds() -> impl Iterator<Item = ModelKind> {
    ModelKind::ALL.into_iter()
}

fn built(kind: ModelKind, strips: &mut StripPool<'_>) -> AnyModel {
    AnyModel::build(kind, strips).expect("every sequence of a simplifier can be modelled")
}

/// Quickly made strips: what is measured is what comes after them.
fn pool(simplified: &Arc<Simplified>) -> StripPool<'_> {
    StripPool::new(simplified, StripOptions { kind: None, effort: Effort::Fast })
}

fn strips(c: &mut Criterion) {
    let mut group = c.benchmark_group("strips");
    for (name, mesh) in shapes() {
        let simplified = simplified(&mesh);
        group.throughput(Throughput::Elements(mesh.triangles().len() as u64));
        group.bench_function(BenchmarkId::new("baseline_triangle_order", name), |b| {
            b.iter(|| order(black_box(simplified.mesh()), 16));
        });
        for kind in [StripKind::Stripe, StripKind::Cache] {
            group.bench_function(BenchmarkId::new(format!("{}_fast", kind.name()), name), |b| {
                b.iter(|| Strips::generate(black_box(&simplified), kind, Effort::Fast));
            });
        }
    }
    group.finish();
}

fn construction(c: &mut Criterion) {
    let mut group = c.benchmark_group("construction");
    for (name, mesh) in shapes() {
        let simplified = simplified(&mesh);
        group.throughput(Throughput::Elements(mesh.triangles().len() as u64));
        group.bench_function(BenchmarkId::new("baseline_simplify", name), |b| {
            b.iter(|| simplify(black_box(&mesh), &Options::DEFAULT, &|_, _| ()));
        });
        let mut pool = pool(&simplified);
        for kind in kinds() {
            // Strips are made before: only the model is timed.
            if let Some(strips) = kind.strips() {
                pool.get(strips);
            }
            group.bench_function(BenchmarkId::new(kind.name(), name), |b| {
                b.iter(|| built(kind, black_box(&mut pool)));
            });
        }
    }
    group.finish();
}

/// From halfway down the LODs 0.1 % further and back.
fn steps(group: &mut BenchmarkGroup<'_, WallTime>, shape: &str, model: &impl Model) {
    let collapses = model.simplified().collapses();
    let records = collapses.records();
    let [near, far] =
        [records / 2, records / 2 + records / 1000].map(|lod| collapses.floor(Lod(lod)));
    let mut cursor = model.cursor();
    model.seek(&mut cursor, near, &mut ());
    group.throughput(Throughput::Elements(2 * u64::from(far.0 - near.0)));
    group.bench_function(BenchmarkId::new(model.name(), shape), |b| {
        b.iter(|| {
            model.seek(&mut cursor, far, &mut ());
            model.seek(&mut cursor, near, &mut ())
        });
    });
}

/// From LOD 0 to 1 % of the triangles, and back, which is not timed.
fn jump(group: &mut BenchmarkGroup<'_, WallTime>, shape: &str, model: &impl Model) {
    let collapses = model.simplified().collapses();
    let far = collapses.lod_for_triangles(collapses.parts().triangles / 100);
    let mut cursor = model.cursor();
    group.bench_function(BenchmarkId::new(model.name(), shape), |b| {
        b.iter_custom(|times| {
            let once = |_| {
                model.seek(&mut cursor, Lod(0), &mut ());
                let start = std::time::Instant::now();
                black_box(model.seek(&mut cursor, far, &mut ()));
                start.elapsed()
            };
            (0..times).map(once).sum()
        });
    });
}

fn extraction(c: &mut Criterion) {
    for (name, mesh) in shapes() {
        let simplified = simplified(&mesh);
        let baselines = Baseline::all(&simplified, &pool(&simplified).get(StripKind::Stripe))
            .expect("every sequence of a simplifier can be modelled");
        let models: Vec<AnyModel> =
            kinds().map(|kind| built(kind, &mut pool(&simplified))).collect();

        let mut group = c.benchmark_group("step_of_a_thousandth");
        baselines.iter().filter(|b| b.continuous()).for_each(|b| steps(&mut group, name, b));
        models.iter().for_each(|m| steps(&mut group, name, m));
        group.finish();

        let mut group = c.benchmark_group("jump_to_1_percent");
        group.throughput(Throughput::Elements(mesh.triangles().len() as u64));
        let mut rebuild = Rebuild::new(&simplified);
        let far = simplified.collapses().lod_for_triangles(mesh.triangles().len() as u32 / 100);
        group.bench_function(BenchmarkId::new("baseline_rebuild", name), |b| {
            b.iter(|| rebuild.indices_at(far).len());
        });
        baselines.iter().filter(|b| b.continuous()).for_each(|b| jump(&mut group, name, b));
        models.iter().for_each(|m| jump(&mut group, name, m));
        group.finish();
    }
}

fn main() {
    // Ten samples of each: all of it takes less than a minute.
    let times = |c: Criterion| {
        c.sample_size(10)
            .warm_up_time(Duration::from_millis(200))
            .measurement_time(Duration::from_millis(800))
    };
    let mut criterion = times(Criterion::default()).configure_from_args();
    strips(&mut criterion);
    construction(&mut criterion);
    extraction(&mut criterion);
    criterion.final_summary();
}
