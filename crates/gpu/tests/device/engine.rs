//! docs/ENGINE.md, followed to the letter by a host that has nothing but wgpu, the WGSL files and
//! what a `.lodc` holds.

/// The host that the page quotes.
#[path = "../../examples/host/gpu.rs"]
mod gpu;
use gpu::Gpu;
use lodc_fixtures as fixtures;
use lodc_lod::ModelKind;
use lodc_lod::interactive::view::{Point, Views};
use lodc_mesh::{Lod, Simplified};
use lodc_plan::VertexRecords;

/// Reads a buffer of words back.
fn read(engine: &Gpu, buffer: &wgpu::Buffer) -> Vec<u32> {
    bytemuck::pod_collect_to_vec(&engine.read(buffer))
}

/// Triangles by submesh as the bytes of their corners, turned so that the smallest is first,
/// sorted.
type Picture<'a> = Vec<(usize, [&'a [u32]; 3])>;

fn picture<'a>(
    triangles: impl Iterator<Item = (usize, [u32; 3])>,
    records: &'a [u32],
    stride: usize,
) -> Picture<'a> {
    let mut picture: Picture<'a> = triangles
        .map(|(submesh, t)| {
            let mut corners = t.map(|v| &records[v as usize * stride..][..stride]);
            let first = (0..3).min_by_key(|&i| corners[i]).expect("three corners");
            corners.rotate_left(first);
            (submesh, corners)
        })
        .collect();
    picture.sort_unstable();
    picture
}

/// Returns the triangles that indexed indirect draws show.
fn drawn<'a>(draws: &[u32], indices: &[u32], records: &'a [u32], stride: usize) -> Picture<'a> {
    let submeshes = draws.chunks_exact(5).enumerate();
    let triangles = submeshes.flat_map(|(submesh, draw)| {
        assert_eq!((draw[1], draw[3], draw[4]), (1, 0, 0));
        let corners = &indices[draw[2] as usize..][..draw[0] as usize];
        corners.chunks_exact(3).map(move |t| (submesh, [t[0], t[1], t[2]]))
    });
    picture(triangles, records, stride)
}

fn truth<'a>(simplified: &Simplified, lod: Lod, records: &'a VertexRecords) -> Picture<'a> {
    let triangles = simplified.triangles_at(lod);
    picture(
        triangles.iter().map(|t| (t.submesh as usize, t.corners)),
        &records.words,
        records.stride,
    )
}

fn sample() -> (Simplified, VertexRecords) {
    let simplified =
        fixtures::random_collapse(&fixtures::named("machine_part").expect("a named shape"), 1);
    let records = VertexRecords::whole(simplified.mesh()).expect("a small mesh");
    (simplified, records)
}

#[test]
fn the_guide_leads_to_every_lod() {
    if crate::support::device().is_none() {
        return;
    }
    let engine = Gpu::open().expect("a device");
    let (simplified, records) = sample();
    let (mesh, collapses, stride) =
        (simplified.mesh(), simplified.collapses(), records.stride as u32);
    let (v, last) = (mesh.vertex_count(), collapses.records());
    let longest = |v: u32| {
        (0..).scan(v, |v, _| (*v < last).then(|| *v = collapses.targets()[*v as usize])).count()
    };
    let lengths: Vec<usize> = (0..v as u32).map(|v| 1 + longest(v)).collect();

    let (source, vertices) = (engine.words(&records.words), engine.words(&records.words));
    let triangles = engine.words(mesh.triangles().as_flattened());
    let collapse_to = engine.words(collapses.targets());
    let (offsets, current, error_flag) = (engine.zeros(v + 1), engine.zeros(v), engine.zeros(1));
    let entries = engine.zeros(lengths.iter().sum());
    let ranges: Vec<u32> =
        mesh.submeshes().iter().flat_map(|s| [s.first_triangle, s.triangle_count]).collect();
    let (submeshes, draws) = (engine.words(&ranges), engine.zeros(5 * ranges.len() / 2));
    let count = ranges.len() as u32 / 2;

    let longest = *lengths.iter().max().expect("vertices") as u32;
    engine.run(
        "lists_length",
        &[],
        v + 1,
        &[v as u32, last, longest],
        &[&collapse_to, &offsets, &error_flag],
    );
    engine.scan(&offsets, v + 1);
    engine.run("lists_fill", &[], v, &[v as u32], &[&collapse_to, &offsets, &entries, &current]);

    let mut old = 0;
    for wanted in [last / 2, last / 4, last, 0, last * 9 / 10] {
        let new = collapses.floor(Lod(wanted)).0;
        let touched = old.max(new);
        let buffers = [&offsets, &entries, &source, &current, &vertices, &error_flag];
        engine.run("extract", &[], touched as usize, &[touched, new, stride], &buffers);
        engine.run(
            "live",
            &[],
            count as usize,
            &[count, stride],
            &[&submeshes, &triangles, &vertices, &draws],
        );
        old = new;
        let (records_drawn, draws) = (read(&engine, &vertices), read(&engine, &draws));
        let shown = drawn(&draws, mesh.triangles().as_flattened(), &records_drawn, records.stride);
        assert!(shown == truth(&simplified, Lod(new), &records), "LOD {new}");
        assert_eq!(read(&engine, &error_flag), [0]);
    }
}

#[test]
fn the_guide_leads_to_views() {
    if crate::support::device().is_none() {
        return;
    }
    let engine = Gpu::open().expect("a device");
    let (simplified, records) = sample();
    let (mesh, collapses, stride) = (simplified.mesh(), simplified.collapses(), records.stride);
    let (v, f) = (mesh.vertex_count(), mesh.triangles().len());
    let views = Views::new(&simplified, records.clone());
    let words: Vec<u32> = views.points().iter().flat_map(Point::words).collect();
    let (points, links) = (engine.words(&words), engine.words(views.links().as_flattened()));
    let (by_error, lowest) = views.by_error();
    let by_error = engine.words(by_error);
    let (source, vertices) = (engine.words(&records.words), engine.words(&records.words));
    let mut padded = mesh.triangles().as_flattened().to_vec();
    padded.resize(padded.len().next_multiple_of(24), 0);
    let eights = f.div_ceil(8);
    let triangles = engine.words(&padded);
    let (live, places, indices) =
        (engine.zeros(eights), engine.zeros(eights + 1), engine.zeros(3 * f));
    let ranges: Vec<u32> =
        mesh.submeshes().iter().flat_map(|s| [s.first_triangle, s.triangle_count]).collect();
    let (submeshes, draws) = (engine.words(&ranges), engine.zeros(5 * ranges.len() / 2));
    let count = ranges.len() / 2;

    // A box around everything: one LOD, whose triangles are known.
    for part in [0, 2, 5, 9, 10] {
        let lod = collapses.floor(Lod(collapses.records() * part / 10));
        let [low, high, one] = [f32::MIN, f32::MAX, 1.0].map(f32::to_bits);
        let parameters = [v as u32, lowest, lod.0, 0, low, low, low, one, high, high, high, 0];
        let constants = [("criterion", 3.0), ("stride", stride as f64)];
        let buffers = [&points, &links, &by_error, &source, &vertices];
        engine.run("view", &constants, v, &parameters, &buffers);
        let (eight, constants) = ([eights as u32], [("stride", stride as f64)]);
        engine.run(
            "filter_count",
            &constants,
            eights + 1,
            &eight,
            &[&triangles, &vertices, &live, &places],
        );
        engine.scan(&places, eights + 1);
        engine.run("filter_write", &[], eights, &eight, &[&triangles, &live, &places, &indices]);
        engine.run(
            "filter_draws",
            &[],
            count,
            &[count as u32],
            &[&submeshes, &live, &places, &draws],
        );
        let (records_drawn, indices) = (read(&engine, &vertices), read(&engine, &indices));
        let shown = drawn(&read(&engine, &draws), &indices, &records_drawn, stride);
        assert!(shown == truth(&simplified, lod, &records), "LOD {}", lod.0);
    }
}

#[test]
fn every_file_is_a_shader_by_itself() {
    if crate::support::device().is_none() {
        return;
    }
    let engine = Gpu::open().expect("a device");
    let refused = engine.device.push_error_scope(wgpu::ErrorFilter::Validation);
    for shader in ModelKind::ALL.into_iter().flat_map(ModelKind::shaders) {
        let source = wgpu::ShaderSource::Wgsl(shader.text().into());
        let label = Some(shader.name);
        let _ = engine.device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
    }
    assert!(pollster::block_on(refused.pop()).is_none());
}
