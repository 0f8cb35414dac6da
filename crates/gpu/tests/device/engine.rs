//! docs/ENGINE.md, followed to the letter by a host that has nothing but wgpu, the WGSL files and
//! what a `.lodc` holds; the page quotes it.

use crate::by_hand::Gpu;
use lodc_fixtures as fixtures;
use lodc_formats::lodc::{Layout, LodFile, LodObject, Section, sections, write};
use lodc_formats::{Document, ObjDocument, ObjectInfo, Source, SourceFormat, SubmeshInfo};
use lodc_lod::ModelKind;
use lodc_lod::interactive::view::{Point, Views};
use lodc_mesh::{Lod, Mesh, Simplified};
use lodc_plan::VertexRecords;
use std::sync::Arc;

/// Reads a buffer of words back.
fn read(gpu: &Gpu, buffer: &wgpu::Buffer) -> Vec<u32> {
    bytemuck::pod_collect_to_vec(&gpu.read(buffer))
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

/// A file of the gpu layout.
fn file(simplified: &Simplified) -> Vec<u8> {
    let submesh = |i| SubmeshInfo { name: String::new(), material: None, document_primitive: i };
    let info = ObjectInfo {
        name: "part".to_owned(),
        submeshes: (0..simplified.mesh().submeshes().len() as u32).map(submesh).collect(),
        world_scale: 1.0,
        document_mesh: 0,
        poses: vec![],
    };
    let file: LodFile = LodFile {
        source: Source { format: SourceFormat::Obj, content_hash: 0 },
        document: Document::Obj(ObjDocument::default()),
        objects: vec![LodObject { info, simplified: Arc::new(simplified.clone()), models: vec![] }],
        layout: Layout::Gpu,
        made_from: None,
        left_out: vec![],
    };
    write(&file, |model, _| model.clone())
}

/// The sections of a file.
struct Sections<'a>(Vec<Section<'a>>);

impl<'a> Sections<'a> {
    /// The bytes of a section of the first object.
    fn bytes(&self, tag: &[u8; 4]) -> &'a [u8] {
        let is = |s: &&Section<'_>| (s.tag, s.object, s.index) == (*tag, Some(0), 0);
        self.0.iter().find(is).expect("a file has it").bytes
    }
}

#[test]
fn the_guide_leads_to_every_lod() {
    const STRIDE: u32 = 3;
    if crate::support::device().is_none() {
        return;
    }
    let gpu = Gpu::open().expect("a device");
    let (simplified, _) = sample();
    let whole = file(&simplified);
    let file = Sections(sections(&whole).expect("a sound file"));
    let (mesh, collapses) = (simplified.mesh(), simplified.collapses());
    let (v, records, targets) = (mesh.vertex_count(), collapses.records(), collapses.targets());
    // Lengths of the lists: an entry, and one more than its target's list has.
    let mut lengths = vec![1u32; v];
    for i in (0..records as usize).rev() {
        lengths[i] = 1 + lengths[targets[i] as usize];
    }
    let longest = lengths.iter().copied().max().expect("vertices");

    let source = &gpu.buffer(file.bytes(b"POSI"));
    let triangles = &gpu.buffer(file.bytes(b"TRIS"));
    let collapse_to = &gpu.buffer(file.bytes(b"TARG"));
    let vertices = &gpu.buffer(file.bytes(b"POSI"));
    let (offsets, current, error_flag) = (&gpu.zeros(v + 1), &gpu.zeros(v), &gpu.zeros(1));
    let entries = &gpu.zeros(lengths.iter().map(|&l| l as usize).sum());
    let ranges = ranges(mesh);
    let count = ranges.len() as u32 / 2;
    let (submeshes, draws) = (&gpu.words(&ranges), &gpu.zeros(5 * count as usize));

    let parameters = [v as u32, records, longest];
    gpu.run("lists_length", &[], v + 1, &parameters, &[collapse_to, offsets, error_flag]);
    gpu.scan(offsets, v + 1);
    gpu.run("lists_fill", &[], v, &[v as u32], &[collapse_to, offsets, entries, current]);

    let positions = VertexRecords::positions(mesh);
    let mut old = 0;
    for wanted in [records / 2, records / 4, records, 0, records * 9 / 10] {
        let lod = collapses.floor(Lod(wanted)).0;
        let touched = old.max(lod);
        let buffers = [offsets, entries, source, current, vertices, error_flag];
        gpu.run("extract", &[], touched as usize, &[touched, lod, STRIDE], &buffers);
        let buffers = [submeshes, triangles, vertices, draws];
        gpu.run("live", &[], count as usize, &[count, STRIDE], &buffers);
        old = lod;
        let (records_drawn, draws) = (read(&gpu, vertices), read(&gpu, draws));
        let shown = drawn(&draws, mesh.triangles().as_flattened(), &records_drawn, 3);
        assert!(shown == truth(&simplified, Lod(lod), &positions), "LOD {lod}");
        assert_eq!(read(&gpu, error_flag)[0], 0);
    }
}

/// First triangle and number of triangles of each submesh.
fn ranges(mesh: &Mesh) -> Vec<u32> {
    mesh.submeshes().iter().flat_map(|s| [s.first_triangle, s.triangle_count]).collect()
}

#[test]
fn the_guide_leads_to_views() {
    if crate::support::device().is_none() {
        return;
    }
    let gpu = Gpu::open().expect("a device");
    let (simplified, records) = sample();
    let (mesh, collapses, stride) = (simplified.mesh(), simplified.collapses(), records.stride);
    let (v, f) = (mesh.vertex_count(), mesh.triangles().len());
    let views = Views::new(&simplified, records.clone());
    let words: Vec<u32> = views.points().iter().flat_map(Point::words).collect();
    let (points, links) = (&gpu.words(&words), &gpu.words(views.links().as_flattened()));
    let (by_error, lowest) = views.by_error();
    let by_error = &gpu.words(by_error);
    let (source, vertices) = (&gpu.words(&records.words), &gpu.words(&records.words));
    let mut padded = mesh.triangles().as_flattened().to_vec();
    padded.resize(padded.len().next_multiple_of(24), 0);
    let eights = f.div_ceil(8);
    let triangles = &gpu.words(&padded);
    let (live, drawn_before, indices) =
        (&gpu.zeros(eights), &gpu.zeros(eights + 1), &gpu.zeros(3 * f));
    let ranges = ranges(mesh);
    let count = ranges.len() / 2;
    let (submeshes, draws) = (&gpu.words(&ranges), &gpu.zeros(5 * count));

    // A box around everything: one LOD, whose triangles are known.
    for part in [0, 2, 5, 9, 10] {
        let lod = collapses.floor(Lod(collapses.records() * part / 10));
        let criterion = ("criterion", 3.0);
        let stride = ("stride", stride as f64);
        let [low, high, one] = [f32::MIN, f32::MAX, 1.0].map(f32::to_bits);
        let parameters = [v as u32, lowest, lod.0, 0, low, low, low, one, high, high, high, 0];
        let buffers = [points, links, by_error, source, vertices];
        gpu.run("view", &[criterion, stride], v, &parameters, &buffers);
        let eight = [eights as u32];
        let buffers = [triangles, vertices, live, drawn_before];
        gpu.run("filter_count", &[stride], eights + 1, &eight, &buffers);
        gpu.scan(drawn_before, eights + 1);
        gpu.run("filter_write", &[], eights, &eight, &[triangles, live, drawn_before, indices]);
        let buffers = [submeshes, live, drawn_before, draws];
        gpu.run("filter_draws", &[], count, &[count as u32], &buffers);
        let (records_drawn, indices) = (read(&gpu, vertices), read(&gpu, indices));
        let shown = drawn(&read(&gpu, draws), &indices, &records_drawn, records.stride);
        assert!(shown == truth(&simplified, lod, &records), "LOD {}", lod.0);
    }
}

#[test]
fn every_file_is_a_shader_by_itself() {
    if crate::support::device().is_none() {
        return;
    }
    let gpu = Gpu::open().expect("a device");
    let refused = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    for shader in ModelKind::ALL.into_iter().flat_map(ModelKind::shaders) {
        let source = wgpu::ShaderSource::Wgsl(shader.text().into());
        let label = Some(shader.name);
        let _ = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
    }
    assert!(pollster::block_on(refused.pop()).is_none());
}

/// The page, and what it may quote.
const PAGE: &str = include_str!("../../../../docs/ENGINE.md");
const SOURCES: [&str; 4] = [
    include_str!("engine.rs"),
    include_str!("../../../lodc/examples/host/main.rs"),
    include_str!("../../../lodc/src/gpu.rs"),
    include_str!("../../../web/example/webgpu.js"),
];

/// The lines of a text that are not empty, without what stands before and behind them; of examples
/// in comments those that are shown.
fn lines(text: &str) -> Vec<&str> {
    let shown = |line: &&str| !line.is_empty() && !line.starts_with("# ");
    text.lines().map(|line| line.trim().trim_start_matches("//!").trim()).filter(shown).collect()
}

#[test]
fn the_page_quotes_hosts_as_they_are() {
    let (page, _) = PAGE.split_once("### Levels in a GLB").expect("the last section has no host");
    let sources = SOURCES.map(lines);
    let fenced = page.split("```").skip(1).step_by(2);
    let code = fenced.filter_map(|b| b.strip_prefix("rust\n").or(b.strip_prefix("js\n")));
    let quotes: Vec<Vec<&str>> = code.map(lines).collect();
    for quote in &quotes {
        let found = sources.iter().any(|s| s.windows(quote.len()).any(|w| w == quote));
        assert!(found, "no host has these lines: {quote:#?}");
    }
    assert!(quotes.len() >= 8, "{}", quotes.len());
}
