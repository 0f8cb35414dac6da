//! Running the real program in a fresh folder.

#![allow(dead_code, reason = "every test program uses a part of this")]

pub(crate) mod browser;

use serde_json::Value;
use std::ffi::OsStr;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::Duration;

/// The program under test.
pub(crate) const LODC: &str = env!("CARGO_BIN_EXE_lodc");

/// Missing on a server, where Mesa's Vulkan driver would write lines of its own to standard error
/// if the program did not see to it.
const MISSING: &str = "XDG_RUNTIME_DIR";

/// A folder that is gone when the test is.
pub(crate) struct Folder(PathBuf);

static FOLDERS: AtomicU32 = AtomicU32::new(0);

impl Folder {
    pub(crate) fn new() -> Self {
        let number = FOLDERS.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("lodc-test-{}-{number}", std::process::id()));
        fs::create_dir_all(&path).expect("a temporary folder can be made");
        Self(path)
    }
    pub(crate) fn path(&self) -> &Path {
        &self.0
    }
    pub(crate) fn join(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
    /// Writes a file and gives its path.
    pub(crate) fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.join(name);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).expect("a folder can be made");
        }
        fs::write(&path, bytes).expect("a file can be written");
        path
    }
    /// What a GLB file has after its JSON: what it states of its level does not count.
    pub(crate) fn read_binary(&self, glb: &str) -> Vec<u8> {
        let bytes = self.read(glb);
        let json = bytes[12..16].try_into().map(u32::from_le_bytes).expect("four bytes");
        bytes[20 + json as usize..].to_vec()
    }
    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }
    pub(crate) fn has(&self, name: &str) -> bool {
        self.join(name).exists()
    }
    /// Names of everything inside, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).expect("the folder is there");
        let mut names: Vec<_> = entries
            .map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }
    /// Runs the program here.
    pub(crate) fn lodc<S: AsRef<OsStr>>(&self, args: impl IntoIterator<Item = S>) -> Run {
        Run::of(
            Command::new(LODC)
                .args(args)
                .current_dir(&self.0)
                .stdin(Stdio::null())
                .env_remove(MISSING),
        )
    }
    /// Runs the program where there is no graphics adapter.
    pub(crate) fn without_gpu<S: AsRef<OsStr>>(&self, args: impl IntoIterator<Item = S>) -> Run {
        let mut command = Command::new(LODC);
        command.args(args).current_dir(&self.0).stdin(Stdio::null());
        Run::of(command.env("VK_DRIVER_FILES", "nothing").env("WGPU_BACKEND", "vulkan"))
    }
    /// Runs the program here with something on standard input.
    pub(crate) fn lodc_with<S: AsRef<OsStr>>(
        &self,
        args: impl IntoIterator<Item = S>,
        stdin: &[u8],
    ) -> Run {
        let mut command = Command::new(LODC);
        command.args(args).current_dir(&self.0).env_remove(MISSING);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("the program starts");
        let mut pipe = child.stdin.take().expect("a pipe was asked for");
        let bytes = stdin.to_owned();
        // A program that reads less than it is given closes the pipe; that is its right.
        let writer = thread::spawn(move || drop(pipe.write_all(&bytes)));
        let output = child.wait_with_output().expect("the program ends");
        writer.join().expect("the writer ends");
        Run::from(output)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Result of a run of the program.
#[derive(Debug)]
pub(crate) struct Run {
    /// The exit status; none if a signal ended it.
    pub(crate) status: Option<i32>,
    pub(crate) out: Vec<u8>,
    pub(crate) err: String,
}

impl From<Output> for Run {
    fn from(o: Output) -> Self {
        Self {
            status: o.status.code(),
            out: o.stdout,
            err: String::from_utf8_lossy(&o.stderr).into_owned(),
        }
    }
}

impl Run {
    pub(crate) fn of(command: &mut Command) -> Self {
        Self::from(command.output().expect("the program starts"))
    }
    /// Standard output as text.
    pub(crate) fn text(&self) -> String {
        String::from_utf8_lossy(&self.out).into_owned()
    }
    /// Standard output as one JSON document.
    pub(crate) fn json(&self) -> Value {
        serde_json::from_slice(&self.out).unwrap_or_else(|e| panic!("{e} in {}", self.text()))
    }
    /// Lines of standard error that are errors.
    pub(crate) fn errors(&self) -> usize {
        self.err.lines().filter(|l| l.starts_with("lodc: ") && !l.contains(": warning: ")).count()
    }
    #[track_caller]
    pub(crate) fn ends(self, status: i32) -> Self {
        assert_eq!(self.status, Some(status), "out: {}\nerr: {}", self.text(), self.err);
        self
    }
    /// Ended well. None, said aloud, if there is no graphics device to draw with; where all tests
    /// are asked for there must be one.
    #[track_caller]
    pub(crate) fn drawn(self) -> Option<Self> {
        if self.status == Some(6) && !lodc_fixtures::all_asked() {
            eprintln!("SKIPPED: no graphics adapter: {}", self.err);
            return None;
        }
        Some(self.ends(0))
    }
    /// Ended with this status and said why in one line.
    #[track_caller]
    pub(crate) fn fails(self, status: i32) -> Self {
        let run = self.ends(status);
        assert_eq!(run.errors(), 1, "{}", run.err);
        assert!(run.err.lines().all(|l| l.starts_with("lodc: ")), "{}", run.err);
        run
    }
}

/// Whether what needs something from outside is run: only where all tests are asked for. Says aloud
/// what is left out.
pub(crate) fn asked(needs: &str) -> bool {
    let asked = lodc_fixtures::all_asked();
    if !asked {
        eprintln!("SKIPPED: needs {needs} (tests/run --all)");
    }
    asked
}

/// A place that `tests/run --all` made and that a variable names. None if it is not asked for.
pub(crate) fn outside(variable: &str) -> Option<PathBuf> {
    let named = || std::env::var_os(variable).unwrap_or_else(|| panic!("{variable} is not set"));
    asked(variable).then(|| named().into())
}

/// The longest that a program from outside may take: far more than any needs, so that one that
/// hangs fails by itself.
pub(crate) const LONGEST: Duration = Duration::from_secs(600);

/// A program from outside that ends, with what it started, after [`LONGEST`].
pub(crate) fn bounded(program: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new("timeout");
    command.arg("--kill-after=5").arg(LONGEST.as_secs().to_string()).arg(program);
    command
}

/// What a script of `tests` prints as JSON, run by Node.js in a folder.
pub(crate) fn script<S: AsRef<OsStr>>(
    name: &str,
    folder: &Path,
    args: impl IntoIterator<Item = S>,
) -> Value {
    let output = bounded("node")
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests").join(name))
        .args(args)
        .current_dir(folder)
        .stderr(Stdio::inherit())
        .output()
        .expect("node is there if the packages are");
    assert!(output.status.success(), "{name} failed");
    serde_json::from_slice(&output.stdout).expect("the script prints JSON")
}

/// The folder of real meshes. None if it is not asked for, or if `LODC_CORPUS=none` leaves it out.
pub(crate) fn corpus() -> Option<PathBuf> {
    let folder = outside("LODC_CORPUS").filter(|folder| folder != Path::new("none"))?;
    assert!(folder.join("manifest.json").is_file(), "no corpus at {}", folder.display());
    Some(folder)
}

/// Files outside `ugly/invalid` that are refused all the same, and rightly.
pub(crate) const REFUSED: &[(&str, &str)] = &[
    ("gltf/asset-generator/Compatibility/Compatibility_04.gltf", "asset.minVersion"),
    ("gltf/asset-generator/Compatibility/Compatibility_05.gltf", "FAKE_materials_quantumRendering"),
    ("ugly/assimp/point_cloud.obj", "a point cloud, not a mesh"),
    ("ugly/assimp/testline.obj", "lines, not a mesh"),
    ("ugly/trimesh/face_in_group_name.obj", "a point cloud, not a mesh"),
    ("ugly/trimesh/obj_empty.obj", "no vertex and no face"),
    ("ugly/trimesh/obj_points.obj", "a point cloud, not a mesh"),
];

/// Every mesh of the corpus with what its manifest says, sorted by path.
pub(crate) fn manifest(corpus: &Path) -> Vec<(String, Value)> {
    let text = fs::read(corpus.join("manifest.json")).expect("the manifest can be read");
    let all: serde_json::Map<String, Value> =
        serde_json::from_slice(&text).expect("the manifest is JSON");
    let mut all: Vec<_> = all.into_iter().collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

/// An OBJ of a bumpy grid with `n` by `n` squares.
pub(crate) fn grid(n: usize) -> String {
    let mut obj = String::from("o grid\n");
    for y in 0..=n {
        for x in 0..=n {
            obj += &format!("v {x} {y} {}\n", (x * 7 + y * 13) % 5);
        }
    }
    for y in 0..n {
        for x in 0..n {
            let a = y * (n + 1) + x + 1;
            obj += &format!("f {a} {} {} {}\n", a + 1, a + n + 2, a + n + 1);
        }
    }
    obj
}

/// A glTF of as many grids as there are scales, each a mesh of its own shown at that scale.
pub(crate) fn scene(scales: &[f32], n: usize) -> String {
    let (mut bytes, mut indices) = (Vec::new(), Vec::new());
    for y in 0..=n {
        for x in 0..=n {
            for c in [x, y, (x * 7 + y * 13) % 5] {
                bytes.extend((c as f32).to_le_bytes());
            }
        }
    }
    let positions = bytes.len();
    for y in 0..n {
        for x in 0..n {
            let a = y * (n + 1) + x;
            indices.extend([a, a + 1, a + n + 2, a, a + n + 2, a + n + 1]);
        }
    }
    bytes.extend(indices.iter().flat_map(|&i| (i as u32).to_le_bytes()));
    let numbers: Vec<usize> = (0..scales.len()).collect();
    let nodes: Vec<_> = numbers
        .iter()
        .map(|&i| {
            let at = [20.0 * i as f32, 0.0, 0.0];
            serde_json::json!({"mesh": i, "scale": vec![scales[i]; 3], "translation": at})
        })
        .collect();
    let meshes: Vec<_> = numbers
        .iter()
        .map(|i| {
            let primitive = serde_json::json!({"attributes": {"POSITION": 0}, "indices": 1});
            serde_json::json!({"name": format!("grid{i}"), "primitives": [primitive]})
        })
        .collect();
    let uri = format!("data:application/octet-stream;base64,{}", base64(&bytes));
    serde_json::json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": numbers}],
        "nodes": nodes, "meshes": meshes,
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": (n + 1) * (n + 1), "type": "VEC3",
             "min": [0, 0, 0], "max": [n, n, 4]},
            {"bufferView": 1, "componentType": 5125, "count": indices.len(), "type": "SCALAR"}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": positions},
            {"buffer": 0, "byteOffset": positions, "byteLength": bytes.len() - positions}],
        "buffers": [{"byteLength": bytes.len(), "uri": uri}]
    })
    .to_string()
}

pub(crate) fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for chunk in bytes.chunks(3) {
        let word = chunk.iter().fold(0, |w, &b| w << 8 | u32::from(b)) << (8 * (3 - chunk.len()));
        for i in 0..4 {
            let letter = LETTERS[(word >> (18 - 6 * i) & 63) as usize];
            text.push(if i <= chunk.len() { char::from(letter) } else { '=' });
        }
    }
    text
}

/// The bytes of text in base 64.
pub(crate) fn unbase64(text: &str) -> Vec<u8> {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let sextets = text.bytes().filter_map(|b| LETTERS.iter().position(|&l| l == b));
    let (mut bytes, mut word, mut bits) = (Vec::new(), 0usize, 0);
    for sextet in sextets {
        (word, bits) = (word << 6 | sextet, bits + 6);
        if bits >= 8 {
            bits -= 8;
            bytes.push((word >> bits) as u8);
            word &= (1 << bits) - 1;
        }
    }
    bytes
}

/// The document and the binary chunk of a GLB.
pub(crate) fn glb_document(bytes: &[u8]) -> (Value, Vec<u8>) {
    let length =
        |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize;
    let end = 20 + length(12);
    let root = serde_json::from_slice(&bytes[20..end]).expect("JSON");
    (root, bytes.get(end + 8..).unwrap_or_default().to_vec())
}
