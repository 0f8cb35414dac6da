//! Meshes from other projects: valid ones build, verify and extract; damaged ones end with the
//! promised error.

use crate::support::{Folder, REFUSED, Run, corpus, manifest};
use lodc_formats::Limits;
use lodc_formats::lods::Unpacker;
use std::collections::VecDeque;
use std::ops::RangeInclusive;
use std::path::Path;
use std::sync::Mutex;
use std::thread;
use std::time::Instant;

/// Above this many triangles a mesh is verified at every thousandth step and extracted once: the
/// test has to end.
const LARGE: u64 = 20_000;

/// Above this many triangles a mesh is left to `just corpus`: a dozen meshes would take longer than
/// all others.
const MOST_TRIANGLES: u64 = 50_000;

/// Files of more bytes are left to benchmarks.
const MOST_BYTES: u64 = 4_000_000;

/// The level that is refitted, as it is by default; the others are as the file has them.
const REFITTED: f64 = 0.1;

/// Does something with every mesh of the corpus that has so many triangles, on all cores, largest
/// first.
fn for_each(
    corpus: &Path,
    triangles: RangeInclusive<u64>,
    check: impl Fn(&Folder, &str) -> Result<(), String> + Sync,
) {
    let mut all = manifest(corpus);
    all.retain(|(_, facts)| {
        facts["bytes"].as_u64() <= Some(MOST_BYTES)
            && triangles.contains(&facts["triangles"].as_u64().unwrap_or(0))
    });
    all.sort_by_key(|(_, facts)| std::cmp::Reverse(facts["bytes"].as_u64()));
    let queue = Mutex::new(VecDeque::from(all));
    let failures = Mutex::new(Vec::new());
    let workers = thread::available_parallelism().map_or(2, usize::from);
    thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                let folder = Folder::new();
                loop {
                    let next = queue.lock().expect("no worker panics with the queue").pop_front();
                    let Some((path, _)) = next else { break };
                    let start = Instant::now();
                    if let Err(what) = check(&folder, &path) {
                        failures
                            .lock()
                            .expect("no worker panics with the list")
                            .push(format!("{path}: {what}"));
                    }
                    if start.elapsed().as_secs() >= 20 {
                        eprintln!("{path}: {:.0} s", start.elapsed().as_secs_f64());
                    }
                }
            });
        }
    });
    let mut failures = failures.into_inner().expect("no worker panics with the list");
    failures.sort();
    assert!(failures.is_empty(), "{} failures:\n{}", failures.len(), failures.join("\n"));
}

fn ended(run: &Run, wanted: &[i32], doing: &str) -> Result<(), String> {
    if run.status.is_some_and(|s| wanted.contains(&s)) {
        return Ok(());
    }
    Err(format!("{doing} ended with {:?}: {}", run.status, run.err.trim()))
}

fn check(folder: &Folder, corpus: &Path, path: &str) -> Result<(), String> {
    let input = corpus.join(path);
    let input = input.to_str().ok_or("a path that is not text")?;
    let run = folder.lodc(["build", input, "-o", "m.lodc", "-q", "--report", "json"]);
    let refused = REFUSED.iter().find(|(name, _)| *name == path);
    let wanted: &[i32] = match refused {
        Some((_, why)) if run.err.contains(why) => &[3],
        _ if path.contains("/invalid/") => &[0, 3, 5],
        _ => &[0],
    };
    ended(&run, wanted, "build")?;
    if run.status != Some(0) {
        let errors = run.err.lines().count();
        return if errors == 1 {
            Ok(())
        } else {
            Err(format!("{errors} lines of error: {}", run.err))
        };
    }
    let report = run.json();
    let triangles = report["inputs"][0]["triangles"].as_u64().ok_or("no count of triangles")?;
    let large = triangles > LARGE;
    let mut verify = vec!["verify", "m.lodc", "-q"];
    verify.extend(if large { vec!["--stride", "1000"] } else { vec!["--source", input] });
    let run = folder.lodc(verify);
    let text = run.text();
    ended(&run, &[0], "verify").map_err(|e| format!("{e}{text}"))?;
    for ratio in [REFITTED, 0.5, 0.25, 0.05, 0.01].into_iter().take(if large { 1 } else { 5 }) {
        let text = ratio.to_string();
        let options = ["extract", "m.lodc", "--ratio", &text, "-o", "m.glb", "--json", "-q"];
        let plain = (ratio != REFITTED).then_some("--no-refit");
        let run = folder.lodc(options.into_iter().chain(plain));
        ended(&run, &[0], &format!("extract at {ratio}"))?;
        let report = run.json();
        let (got, most) =
            (report["triangles"].as_u64().unwrap_or(u64::MAX), (ratio * triangles as f64) as u64);
        let stopped = report["warnings"].as_array().is_some_and(|w| !w.is_empty());
        if got > most && !stopped {
            return Err(format!("{got} triangles at {ratio}, more than {most}, without a warning"));
        }
        if got == 0 && triangles > 0 {
            return Err(format!("nothing left at {ratio}"));
        }
    }
    if triangles > 1000 && (path.ends_with(".glb") || path.ends_with(".gltf")) {
        let options = ["--ratio", "10%", "--textures", "keep", "-o", "m.glb", "-q"];
        let run = folder.lodc(["extract", input].iter().chain(&options));
        ended(&run, &[0], "extract of the input")?;
        let (level, whole) = (folder.read("m.glb").len() as u64, size(Path::new(input))?);
        if level >= whole {
            return Err(format!("{level} bytes at 10 %, the input has {whole}"));
        }
    }
    check_stream(folder, path, triangles)
}

/// Bytes of a glTF or GLB and of the buffers that it names.
fn size(path: &Path) -> Result<u64, String> {
    let bytes = std::fs::read(path).map_err(|e| e.to_string())?;
    let root: serde_json::Value = serde_json::from_slice(&bytes).unwrap_or_default();
    let buffers = root["buffers"].as_array().into_iter().flatten();
    let named = buffers.filter(|b| b["uri"].as_str().is_some_and(|uri| !uri.starts_with("data:")));
    let sizes = named.filter_map(|b| b["byteLength"].as_u64());
    Ok(bytes.len() as u64 + sizes.sum::<u64>())
}

/// Bytes of a stream behind its head that are to show triangles.
const FIRST_TRIANGLES: usize = 600;
/// Streams whose first step alone takes more: the vertices of one position come in one step, and
/// these have many, with many attributes.
const RICH_FIRST_STEPS: &[(&str, usize)] =
    &[("gltf/misc/vintageDeskFan/vintageFan_animated.gltf", 900)];

/// Bytes up to which pieces of the document come without a vertex between them.
fn head(stream: &[u8]) -> Result<usize, String> {
    let mut unpacker = Unpacker::new(Limits::DEFAULT);
    let (mut head, mut come) = (0, 0);
    for (at, byte) in stream.iter().enumerate() {
        unpacker.feed(&[*byte]).map_err(|e| format!("at byte {at}: {e}"))?;
        if (0..unpacker.objects()).any(|o| unpacker.progress(o).vertices[0] > 0) {
            break;
        }
        let document = unpacker.document_bytes()[0];
        if document > come {
            (head, come) = (at + 1, document);
        }
    }
    Ok(head)
}

/// Packs `m.lodc` and asserts that few bytes of the stream show triangles, and all of it the mesh.
fn check_stream(folder: &Folder, path: &str, triangles: u64) -> Result<(), String> {
    let run = folder.lodc(["pack", "m.lodc", "-o", "m.lods", "-q"]);
    ended(&run, &[0], "pack")?;
    let stream = std::fs::read(folder.path().join("m.lods")).map_err(|e| e.to_string())?;
    let shown = |bytes: usize| -> Result<u64, String> {
        let mut unpacker = Unpacker::new(Limits::DEFAULT);
        let prefix = &stream[..bytes.min(stream.len())];
        unpacker.feed(prefix).map_err(|e| format!("{bytes} bytes of the stream: {e}"))?;
        let triangles = |o| u64::from(unpacker.progress(o).triangles[0]);
        Ok((0..unpacker.objects()).map(triangles).sum())
    };
    let rich = RICH_FIRST_STEPS.iter().find(|(name, _)| *name == path);
    let first = rich.map_or(FIRST_TRIANGLES, |(_, bytes)| *bytes);
    let head = head(&stream)?;
    if triangles > 0 && shown(head + first)? == 0 {
        return Err(format!("no triangles in {first} bytes behind a head of {head}"));
    }
    let twentieth = stream.len() / 20;
    let is_small = stream.len() <= 20_000;
    if !is_small && head > twentieth {
        return Err(format!("a head of {head} bytes in a stream of {}", stream.len()));
    }
    if triangles > 0 && !is_small && shown(twentieth)? == 0 {
        return Err(format!("no triangles in 5 % of {} bytes of the stream", stream.len()));
    }
    let all = shown(stream.len())?;
    if all == triangles { Ok(()) } else { Err(format!("the stream has {all} triangles")) }
}

#[test]
fn every_sound_mesh_builds_verifies_extracts_and_streams_and_every_broken_one_ends_in_one_line() {
    let Some(corpus) = corpus() else { return };
    for_each(&corpus, 0..=MOST_TRIANGLES, |folder, path| check(folder, &corpus, path));
}

#[test]
#[ignore = "takes minutes: `just corpus`"]
fn every_large_mesh_builds_verifies_extracts_and_streams() {
    let Some(corpus) = corpus() else { return };
    for_each(&corpus, MOST_TRIANGLES + 1..=u64::MAX, |folder, path| check(folder, &corpus, path));
}
