//! The stages of the program, one after another, each beside what it can at best cost: `cargo bench
//! -p lodc-lab`.
//!
//! Import against a checksum of the text, reading against a checksum of the file, writing against
//! copying it, extraction against copying the triangles. Throughput is in triangles of the input
//! per second.

use criterion::{BenchmarkId, Criterion, Throughput};
use lodc::{LodFile, LodObject, read, write};
use lodc_formats::export::{ExportFormat, ExportObject, export};
use lodc_formats::import::{ImportOptions, import};
use lodc_formats::lodc::{Layout, sections};
use lodc_formats::{Document, ObjDocument, ObjectInfo, Source, SourceFormat, SubmeshInfo};
use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::{Lod, Mesh};
use lodc_model::Model;
use lodc_simplify::{Options, simplify};
use lodc_strip::{StripOptions, StripPool};
use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use xxhash_rust::xxh3::xxh3_128;

/// Closed without attributes, small and large; with seams, poles, normals and texture coordinates.
fn shapes() -> Vec<(&'static str, Mesh)> {
    vec![
        ("icosphere_20k", lodc_fixtures::icosphere(5)),
        ("uv_sphere_32k", lodc_fixtures::uv_sphere(180, 90)),
        ("icosphere_328k", lodc_fixtures::icosphere(7)),
    ]
}

fn info(mesh: &Mesh) -> ObjectInfo {
    let submeshes = (0..mesh.submeshes().len() as u32)
        .map(|i| SubmeshInfo { name: String::new(), material: None, document_primitive: i })
        .collect();
    ObjectInfo {
        name: "shape".to_owned(),
        submeshes,
        world_scale: 1.0,
        document_mesh: 0,
        poses: vec![],
    }
}

/// The shape as a file of that format.
fn file(mesh: &Mesh, format: ExportFormat) -> Vec<u8> {
    let document = Document::Obj(ObjDocument::default());
    let object = ExportObject { info: &info(mesh), mesh };
    let files =
        export(Path::new("shape"), format, &document, &[object]).expect("a shape can be exported");
    files.into_iter().next().expect("there is a main file").bytes
}

fn built(mesh: &Mesh) -> LodFile {
    let simplified = Arc::new(simplify(mesh, &Options::DEFAULT, &|_, _| ()));
    let models = vec![
        AnyModel::build(
            ModelKind::Interactive,
            &mut StripPool::new(&simplified, StripOptions::default()),
        )
        .expect("triangles are in order"),
    ];
    LodFile {
        source: Source { format: SourceFormat::Obj, content_hash: 0 },
        document: Document::Obj(ObjDocument::default()),
        objects: vec![LodObject { info: info(mesh), simplified, models }],
        made_from: None,
        layout: Layout::Packed,
        left_out: Vec::new(),
    }
}

fn imports(c: &mut Criterion) {
    let mut group = c.benchmark_group("import");
    let folder = std::env::temp_dir().join(format!("lodc-bench-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder can be made");
    for (name, mesh) in shapes() {
        group.throughput(Throughput::Elements(mesh.triangles().len() as u64));
        for (format, extension) in [(ExportFormat::Obj, "obj"), (ExportFormat::Glb, "glb")] {
            let bytes = file(&mesh, format);
            let path = folder.join(format!("{name}.{extension}"));
            std::fs::write(&path, &bytes).expect("the temporary folder can be written to");
            group.bench_function(BenchmarkId::new(extension, name), |b| {
                b.iter(|| import(black_box(&path), &ImportOptions::default()).expect("sound"));
            });
            group.bench_function(
                BenchmarkId::new(format!("floor_checksum_{extension}"), name),
                |b| {
                    b.iter(|| xxh3_128(black_box(&bytes)));
                },
            );
        }
    }
    group.finish();
    std::fs::remove_dir_all(&folder).expect("my own folder");
}

/// Simplification down to a single vertex, on one thread and on two. The largest mesh is cut into
/// regions.
fn simplification(c: &mut Criterion) {
    let mut group = c.benchmark_group("simplify");
    for (name, mesh) in shapes() {
        group.throughput(Throughput::Elements(mesh.triangles().len() as u64));
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let pool = pool.expect("two threads can be had");
            let id = BenchmarkId::new(format!("whole_sequence_threads_{threads}"), name);
            group.bench_function(id, |b| {
                b.iter(|| {
                    pool.install(|| simplify(black_box(&mesh), &Options::DEFAULT, &|_, _| ()))
                });
            });
        }
    }
    group.finish();
}

fn files_and_levels(c: &mut Criterion) {
    for (name, mesh) in shapes() {
        let triangles = mesh.triangles().len() as u64;
        let mut file = built(&mesh);
        let bytes = write(&file);

        let mut group = c.benchmark_group("write");
        group.throughput(Throughput::Elements(triangles));
        group
            .bench_function(BenchmarkId::new("lodc", name), |b| b.iter(|| write(black_box(&file))));
        group.bench_function(BenchmarkId::new("floor_copy", name), |b| {
            b.iter(|| black_box(&bytes).clone());
        });
        group.finish();

        let mut group = c.benchmark_group("read");
        group.throughput(Throughput::Elements(triangles));
        group.bench_function(BenchmarkId::new("lodc", name), |b| {
            b.iter(|| read(black_box(&bytes)).expect("sound"));
        });
        group.bench_function(BenchmarkId::new("floor_checksum", name), |b| {
            b.iter(|| xxh3_128(black_box(&bytes)));
        });
        file.layout = Layout::Gpu;
        let bytes = write(&file);
        group.bench_function(BenchmarkId::new("lodc_gpu_layout", name), |b| {
            b.iter(|| read(black_box(&bytes)).expect("sound"));
        });
        group.bench_function(BenchmarkId::new("sections_gpu_layout", name), |b| {
            b.iter(|| sections(black_box(&bytes)).expect("sound").len());
        });
        group.finish();
        levels(c, name, &file, &mesh);
    }
}

fn levels(c: &mut Criterion, name: &str, file: &LodFile, mesh: &Mesh) {
    let triangles = mesh.triangles().len() as u64;
    let object = &file.objects[0];
    let (model, collapses) = (&object.models[0], object.simplified.collapses());
    let mut group = c.benchmark_group("extract");
    for percent in [50, 5] {
        let lod = collapses.lod_for_triangles((triangles * percent / 100) as u32);
        let live = collapses.triangles_at(lod);
        group.throughput(Throughput::Elements(triangles));
        group.bench_function(BenchmarkId::new(format!("from_scratch_{percent}"), name), |b| {
            b.iter(|| model.triangles_at(black_box(lod)));
        });
        let copied = &mesh.triangles()[..live as usize];
        group.bench_function(BenchmarkId::new(format!("floor_copy_{percent}"), name), |b| {
            b.iter(|| black_box(copied).to_vec());
        });
    }
    // What a viewer does between two pictures: a hundredth of the records, there and back.
    let [near, far] = [25, 26].map(|share| collapses.floor(Lod(collapses.records() / 100 * share)));
    let mut cursor = model.cursor();
    model.seek(&mut cursor, near, &mut ());
    group.throughput(Throughput::Elements(2 * u64::from(far.0 - near.0)));
    group.bench_function(BenchmarkId::new("records_of_1_percent_there_and_back", name), |b| {
        b.iter(|| {
            model.seek(&mut cursor, far, &mut ());
            model.seek(&mut cursor, near, &mut ())
        });
    });
    group.finish();
}

fn main() {
    // Ten samples of each: all of it takes less than three minutes.
    let times = |c: Criterion| {
        c.sample_size(10)
            .warm_up_time(Duration::from_millis(200))
            .measurement_time(Duration::from_millis(800))
    };
    let mut criterion = times(Criterion::default()).configure_from_args();
    imports(&mut criterion);
    simplification(&mut criterion);
    files_and_levels(&mut criterion);
    criterion.final_summary();
}
