//! The compute shaders in a browser: `crates/web/js/plan.js` runs the models' own plans, and every
//! word is that of the CPU.

use crate::support::Folder;
use crate::support::browser::Browser;
use lodc_lod::{AnyModel, ModelKind};
use lodc_mesh::Simplified;
use lodc_plan::{Contents, Expected, Pass, Plan, Program, Step, schedule};
use lodc_simplify::{Options, simplify};
use lodc_strip::{Effort, StripOptions, StripPool};
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
    assert_eq!(step.twin, None, "the CPU differs from the reference");
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
        for kind in ModelKind::ALL {
            let model = AnyModel::build(kind, &mut strips).expect("a model");
            let of_model = model.replays(&stops).expect("plans");
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
