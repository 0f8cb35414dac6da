//! The compute shaders in a browser: `crates/web/js/plan.js` runs the models' own plans, and every
//! word is that of the CPU.

use crate::support::browser::Browser;
use crate::support::{Folder, base64};
use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::Simplified;
use lodc_plan::{Contents, Expected, Pass, Plan, Program, Step, schedule};
use lodc_simplify::{Options, simplify};
use lodc_strip::{Effort, StripOptions, StripPool};
use lodc_verify::Reference;
use serde_json::{Value, json};
use std::sync::Arc;

const HOST: &str = include_str!("../../crates/web/js/plan.js");

/// Runs every plan and logs sums and the first difference.
const SCRIPT: &str = r"
setTimeout(() => console.log('done: no end'), 300000);
const plans = JSON.parse(document.getElementById('plans').textContent);
const typed = (entry) => ({ ...entry, words: entry.words && Uint32Array.from(entry.words) });
const device = await openDevice();
let [lods, words, difference] = [0, 0, device ? '' : 'no device'];
for (const { name, program, steps } of device ? plans : []) {
  program.buffers = program.buffers.map(typed);
  for (const step of steps) step.checks = step.checks.map(typed);
  const done = await replay(device, { program, steps });
  lods += done.lods;
  words += done.words;
  if (done.difference) difference ||= `${name}: ${done.difference}`;
}
console.log(`done: ${lods} ${words} ${difference}`);
";

fn program(program: &Program) -> Value {
    let buffer = |b: &lodc_plan::Buffer| {
        let words = match &b.contents {
            Contents::Words(words) => json!(&words[..]),
            Contents::Zeros(_) => Value::Null,
        };
        json!({ "name": b.name, "length": b.contents.len(), "words": words })
    };
    let kernel = |k: &lodc_plan::Kernel| {
        let constants: serde_json::Map<String, Value> =
            k.constants.iter().map(|&(name, value)| (name.to_owned(), value.into())).collect();
        json!({ "name": k.name, "wgsl": k.wgsl, "constants": constants })
    };
    let buffers: Vec<Value> = program.buffers.iter().map(buffer).collect();
    let kernels: Vec<Value> = program.kernels.iter().map(kernel).collect();
    json!({ "buffers": buffers, "kernels": kernels })
}

fn step(step: &Step) -> Value {
    assert_eq!(step.cpu_failure, None, "the CPU differs from the reference");
    let pass = |p: &Pass| {
        let buffers: Vec<usize> = p.buffers.iter().map(|b| b.0).collect();
        json!({
            "kernel": p.kernel.0, "buffers": buffers, "threads": p.threads,
            "parameters": p.parameters
        })
    };
    let check =
        |c: &Expected| json!({ "buffer": c.buffer.0, "first": c.first, "words": &c.words[..] });
    json!({
        "at": step.at, "counts": step.counts,
        "passes": step.passes.iter().map(pass).collect::<Vec<_>>(),
        "checks": step.checks.iter().map(check).collect::<Vec<_>>()
    })
}

fn plan(name: &str, plan: Plan<'_>) -> Value {
    let program = program(&plan.program);
    let steps: Vec<Value> = plan.steps.map(|s| step(&s)).collect();
    let name = format!("{name} {} {}", plan.model, plan.name);
    json!({ "name": name, "program": program, "steps": steps })
}

#[test]
fn kernels_in_a_browser_give_the_words_of_the_cpu() {
    let Some(browser) = Browser::find() else { return };
    let f = Folder::new();
    let mut plans = Vec::new();
    for name in ["machine_part", "striped_sphere"] {
        let mesh = lodc_fixtures::named(name).expect("a named shape");
        let simplified: Arc<Simplified> = Arc::new(simplify(&mesh, &Options::DEFAULT, &|_, _| {}));
        let stops = schedule(simplified.collapses(), 10, 6, 1);
        let options = StripOptions { kind: None, effort: Effort::Fast };
        let mut strips = StripPool::new(&simplified, options);
        let reference = Reference::new(&simplified).expect("a small sequence");
        for kind in ModelKind::ALL {
            let model = AnyModel::build(kind, &mut strips).expect("a model");
            let of_model = model.replays(&stops, &reference).expect("plans");
            plans.extend(of_model.into_iter().map(|p| plan(name, p)));
        }
    }
    let data = json!(plans).to_string();
    let page = f.file(
        "plans.html",
        format!(
            "<!doctype html><html><body><script id=plans type=application/json>{data}</script>\
             <script type=module>{}\n{SCRIPT}</script></body></html>",
            HOST.replace("\nexport ", "\n")
        ),
    );
    let result = browser.result(&page);
    let mut parts = result.splitn(3, ' ');
    let mut number = || parts.next().and_then(|n| n.parse::<u64>().ok()).unwrap_or(0);
    let (lods, words) = (number(), number());
    assert_eq!(parts.next(), Some(""), "a browser differs: {result}");
    assert!(lods > 100 && words > 100_000, "{result}");
}

/// Modules of the example's host, each after those that it imports.
const EXAMPLE: [&str; 4] = [
    include_str!("../../crates/web/js/math.js"),
    HOST,
    include_str!("../../crates/web/js/sections.js"),
    include_str!("../../crates/web/example/webgpu.js"),
];

/// Shows levels; logs triangles, LOD and pixels that are not black of each, or a message.
const SHOW: &str = r"
const data = JSON.parse(document.getElementById('data').textContent);
const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;

async function pixels(host) {
  const { device, canvas: { width, height } } = host;
  const { COPY_DST, MAP_READ } = GPUBufferUsage;
  // Headless browsers without a graphics card have no canvas for WebGPU: a texture stands for it.
  const format = navigator.gpu.getPreferredCanvasFormat();
  const { RENDER_ATTACHMENT, COPY_SRC } = GPUTextureUsage;
  const usage = RENDER_ATTACHMENT | COPY_SRC;
  const texture = device.createTexture({ size: [width, height], format, usage });
  host.encode(texture.createView(), host.matrix());
  const buffer = device.createBuffer({ size: 4 * width * height, usage: COPY_DST | MAP_READ });
  const encoder = device.createCommandEncoder();
  encoder.copyTextureToBuffer({ texture }, { buffer, bytesPerRow: 4 * width }, [width, height]);
  device.queue.submit([encoder.finish()]);
  await buffer.mapAsync(GPUMapMode.READ);
  const words = new Uint32Array(buffer.getMappedRange());
  return words.filter((word) => (word & 0xffffff) !== 0).length;
}

async function run() {
  const canvas = Object.assign(document.createElement('canvas'), { width: 256, height: 256 });
  const host = await Host.create(canvas, bytes(data.file), data.shaders);
  if (!host) return 'no device';
  const refused = await Host.create(canvas, bytes(data.packed), data.shaders).catch((e) => e);
  const all = [];
  for (const wanted of data.lods) {
    const lod = host.show(wanted);
    all.push([lod, await host.triangles(), await pixels(host)]);
  }
  return JSON.stringify({ all, refused: refused.message });
}

console.log(`done: ${await run().catch((e) => `failed: ${e.message}`)}`);
";

#[test]
fn the_example_host_shows_the_levels_of_extract() {
    let Some(browser) = Browser::find() else { return };
    let f = Folder::new();
    let part = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/machine_part.glb");
    f.lodc(["build", part, "-o", "m.lodc", "--layout", "gpu", "-q"]).ends(0);
    f.lodc(["build", part, "-o", "packed.lodc", "-q"]).ends(0);
    f.lodc(["shaders", "-o", "shaders", "-q"]).ends(0);
    let names = ["lists_length", "scan", "scan_add", "lists_fill", "extract", "live"];
    let text = |name: &str| String::from_utf8(f.read(&format!("shaders/{name}.wgsl")));
    let shaders: serde_json::Map<String, Value> =
        names.iter().map(|n| ((*n).to_owned(), text(n).expect("text").into())).collect();
    let lods = [0, 200, 40, 350, 999_999, 7];
    let data = json!({
        "file": base64(&f.read("m.lodc")), "packed": base64(&f.read("packed.lodc")),
        "shaders": shaders, "lods": lods
    });
    let script: String = EXAMPLE.iter().map(|text| without_imports(text)).collect();
    let page = f.file(
        "host.html",
        format!(
            "<!doctype html><html><body><script id=data type=application/json>{data}</script>\
             <script type=module>{script}\n{SHOW}</script></body></html>"
        ),
    );
    let result = browser.result(&page);
    let result: Value = serde_json::from_str(&result).unwrap_or_else(|_| panic!("{result}"));
    assert!(result["refused"].as_str().is_some_and(|m| m.contains("--layout gpu")), "{result}");
    for (wanted, shown) in lods.iter().zip(result["all"].as_array().expect("levels")) {
        let wanted = wanted.to_string();
        let args = ["extract", "m.lodc", "--lod", &wanted, "-o", "l.glb", "--json", "-q"];
        let report = f.lodc(args).ends(0).json();
        assert_eq!(shown[0], report["lod"], "{wanted}: {shown}");
        assert_eq!(shown[1], report["triangles"], "{wanted}: {shown}");
        let (triangles, pixels) = (&shown[1], shown[2].as_u64().expect("a number"));
        assert!(pixels > 1_000 || triangles.as_u64() < Some(20), "{wanted}: {shown}");
    }
}

/// A module as a part of one script.
fn without_imports(text: &str) -> String {
    let lines = text.lines().filter(|line| !line.starts_with("import "));
    lines.map(|line| format!("{}\n", line.strip_prefix("export ").unwrap_or(line))).collect()
}
