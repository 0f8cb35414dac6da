//! Small files that ask for much: refused soon, and without taking the memory they ask for.
//!
//! Promised are 64 MiB plus twice the file; memory is the system's high-water mark of the process.
//! Times differ with the machine: what a run took is printed when something else fails.

use crate::support::{Folder, LODC, Run, grid};
use lodc_formats::lodc::with_valid_checksums;
use std::fmt::Write;
use std::io::Write as _;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A bomb's file, and what a run of the program on it took.
struct Range(Folder);

/// Cost of a run, as far as the system says.
#[derive(Debug, Default)]
struct ProcessCost {
    /// Largest resident size in bytes.
    memory: u64,
    /// Seconds of processor time.
    processor: f64,
}

impl ProcessCost {
    /// Looks at a running process; what can be read of one that has just ended is kept from before.
    fn look(&mut self, process: u32) {
        let read = |file: &str| {
            std::fs::read_to_string(format!("/proc/{process}/{file}")).unwrap_or_default()
        };
        if let Some(line) =
            read("status").lines().find_map(|l| l.strip_prefix("VmHWM:").map(str::to_owned))
        {
            let kibibytes: u64 =
                line.trim().trim_end_matches("kB").trim().parse().expect("a number");
            self.memory = self.memory.max(kibibytes << 10);
        }
        // After the name in brackets: state is the first field, user and system time the 12th and
        // 13th, in 1/100 s.
        let stat = read("stat");
        if let Some((_, fields)) = stat.rsplit_once(')') {
            let ticks: u32 = fields
                .split_whitespace()
                .skip(11)
                .take(2)
                .filter_map(|t| t.parse::<u32>().ok())
                .sum();
            self.processor = self.processor.max(f64::from(ticks) / 100.0);
        }
    }
}

impl Range {
    /// Runs a command on a file that is there; it must be refused, soon and modestly.
    fn defused(&self, name: &str, args: &[&str]) {
        let size = self.0.join(name).metadata().expect("the bomb is there").len();
        let mut command = Command::new(LODC);
        command.args(args).current_dir(self.0.path()).stdin(Stdio::null());
        let mut child = command
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let (start, mut taken) = (Instant::now(), ProcessCost::default());
        while child.try_wait().expect("it can be asked").is_none() {
            taken.look(child.id());
            // A thousand times what it takes: only what hangs gets here.
            if start.elapsed() > Duration::from_secs(600) {
                child.kill().expect("it can be ended");
                panic!("{name} {args:?}: still at it after ten minutes, {taken:?}");
            }
            std::thread::sleep(Duration::from_micros(300));
        }
        let run = Run::from(child.wait_with_output().expect("it has ended"));
        assert!(matches!(run.status, Some(3 | 5)), "{name}: {run:?}");
        assert_eq!(run.err.lines().count(), 1, "{name}: {}", run.err);
        assert!(run.err.contains(name) && run.err.len() < 500, "{name}: {}", run.err);
        assert!(taken.memory <= (64 << 20) + 2 * size, "{name}, {size} bytes: {taken:?}");
        assert!(!self.0.has("x.lodc"), "{name}");
    }

    fn build(&self, name: &str, bytes: impl AsRef<[u8]>) {
        self.0.file(name, bytes);
        self.defused(name, &["build", name, "-o", "x.lodc"]);
        std::fs::remove_file(self.0.join(name)).expect("my own file");
    }
}

/// A GLB header and a first chunk.
fn glb(length: u32, chunk: Option<u32>) -> Vec<u8> {
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend(length.to_le_bytes());
    if let Some(chunk) = chunk {
        bytes.extend(chunk.to_le_bytes());
        bytes.extend(b"JSON");
    }
    bytes
}

/// A glTF of one mesh: its accessors, its buffer views, and how many zeros its buffer has.
fn gltf(accessors: &str, views: &str, zeros: usize) -> String {
    let data = "A".repeat(zeros.div_ceil(3) * 4);
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"accessors":[{accessors}],
        "bufferViews":[{views}],"buffers":[{{"byteLength":{zeros},
        "uri":"data:application/octet-stream;base64,{data}"}}]}}"#
    )
}

#[test]
fn glb_sizes_are_compared_with_the_file() {
    let range = Range(Folder::new());
    for (name, bytes) in [
        ("claims_4_gib.glb", glb(u32::MAX, None)),
        ("claims_chunk.glb", glb(20, Some(u32::MAX - 3))),
        ("claims_both.glb", glb(u32::MAX, Some(u32::MAX - 19))),
    ] {
        range.build(name, bytes);
    }
}

#[test]
fn gltf_counts_strides_and_sparse_data_are_compared_with_the_bytes() {
    let range = Range(Folder::new());
    let view = r#"{"buffer":0,"byteLength":96}"#;
    for count in [1u64 << 62, u64::MAX, 1 << 31, 1 << 28, 1 << 24] {
        let accessor = format!(r#"{{"componentType":5126,"count":{count},"type":"VEC3"}}"#);
        range.build("zeros.gltf", gltf(&accessor, "", 3));
        let accessor =
            format!(r#"{{"bufferView":0,"componentType":5126,"count":{count},"type":"VEC3"}}"#);
        range.build("count.gltf", gltf(&accessor, view, 96));
        let sparse = r#""indices":{"bufferView":0,"componentType":5125},"values":{"bufferView":0}"#;
        let accessor = format!(
            r#"{{"componentType":5126,"count":9,"type":"VEC3",
            "sparse":{{"count":{count},{sparse}}}}}"#
        );
        range.build("sparse.gltf", gltf(&accessor, view, 96));
    }
    for (stride, count) in
        [(1u64 << 40, 3u64), (4, 24), (0, 3), (1, 96), (u64::MAX, 2), (252, 1 << 40)]
    {
        let view = format!(r#"{{"buffer":0,"byteLength":96,"byteStride":{stride}}}"#);
        let accessor =
            format!(r#"{{"bufferView":0,"componentType":5126,"count":{count},"type":"VEC3"}}"#);
        range.build("stride.gltf", gltf(&accessor, &view, 96));
    }
    // Each accessor by itself is within bounds.
    let many = vec![r#"{"componentType":5126,"count":1000000,"type":"VEC3"}"#; 1000].join(",");
    let primitives: Vec<String> =
        (0..1000).map(|i| format!(r#"{{"attributes":{{"POSITION":{i}}}}}"#)).collect();
    let text =
        gltf(&many, "", 3).replace(r#"{"attributes":{"POSITION":0}}"#, &primitives.join(","));
    range.build("many_zeros.gltf", text);
}

#[test]
fn json_is_not_followed_into_the_deep_or_round_in_circles() {
    let range = Range(Folder::new());
    for (name, open, close) in [("arrays.gltf", "[", "]"), ("objects.gltf", "{\"a\":", "}")] {
        let nested = format!("{}1{}", open.repeat(100_000), close.repeat(100_000));
        range.build(name, format!(r#"{{"asset":{{"version":"2.0"}},"extras":{nested}}}"#));
    }
    range.build("open.gltf", "{\"a\":".repeat(4 << 20));
    range.build(
        "wide.gltf",
        format!(r#"{{"asset":{{"version":"2.0"}},"extras":[{}1]}}"#, "1,".repeat(6 << 20)),
    );
    for (name, nodes) in [
        ("itself.gltf", r#"{"children":[0]}"#.to_owned()),
        ("two.gltf", r#"{"children":[1]},{"children":[0]}"#.to_owned()),
        // Each shown twice by the one before: a billion billion instances, if that were a tree.
        (
            "doubling.gltf",
            (1..60).map(|i| format!(r#"{{"children":[{i},{i}]}},"#)).collect::<String>() + "{}",
        ),
        (
            "long.gltf",
            (1..=50_000)
                .map(|i| format!(r#"{{"children":[{}]}}"#, i % 50_000))
                .collect::<Vec<_>>()
                .join(","),
        ),
    ] {
        let scene = r#""asset":{"version":"2.0"},"scenes":[{"nodes":[0]}]"#;
        range.build(name, format!(r#"{{{scene},"nodes":[{nodes}]}}"#));
    }
}

#[test]
fn a_line_without_end_is_given_up() {
    let range = Range(Folder::new());
    // A quarter of a GiB that takes no place on the disk: a hole, which reads as zeros.
    let file = std::fs::File::create(range.0.join("line.obj")).expect("a file can be made");
    file.set_len(256 << 20).expect("it can be long");
    range.defused("line.obj", &["build", "line.obj", "-o", "x.lodc"]);
    let start = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let mut file = std::fs::File::create(range.0.join("spaces.obj")).expect("a file can be made");
    file.write_all(start).and_then(|()| file.write_all(&vec![b' '; 80 << 20])).expect("written");
    range.defused("spaces.obj", &["build", "spaces.obj", "-o", "x.lodc"]);
    range.build("continued.obj", "v 1 \\\n".repeat(16 << 20));
}

#[test]
fn counts_in_a_lodc_file_are_compared_with_its_bytes() {
    let range = Range(Folder::new());
    range.0.file("good.obj", grid(4));
    range.0.lodc(["build", "good.obj", "-o", "good.lodc", "-q"]).ends(0);
    let good = range.0.read("good.lodc");
    assert_eq!(with_valid_checksums(&good), good, "the checksums are understood");
    let number = |at: usize| u64::from_le_bytes(std::array::from_fn(|i| good[at + i])) as usize;
    let [manifest, length] = [40 + 16, 40 + 24].map(number);
    let manifest_end = manifest + length;
    let mut places: Vec<usize> = vec![12, 16, 40 + 16, 40 + 24, 80 + 16, 80 + 24];
    places.extend((manifest..manifest_end - 8).step_by(5));
    let mut refused = String::new();
    for at in places {
        for value in [1u64 << 40, u64::MAX] {
            let mut bytes = good.clone();
            let width = if at == 12 { 4 } else { 8 };
            bytes[at..at + width].copy_from_slice(&value.to_le_bytes()[8 - width..]);
            range.0.file("bomb.lodc", with_valid_checksums(&bytes));
            // Some numbers only describe: a name's hash, a scale. Those files are sound.
            if range.0.lodc(["info", "bomb.lodc"]).status == Some(0) {
                continue;
            }
            for args in [&["info", "bomb.lodc"][..], &["verify", "bomb.lodc"]] {
                range.defused("bomb.lodc", args);
            }
            write!(refused, "{at} ").expect("memory is there");
        }
    }
    assert!(refused.split(' ').count() > 20, "only {refused}");
}
