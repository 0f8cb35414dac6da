//! The command line as scripts and people meet it: one module per promise of docs/CLI.md.

#![expect(clippy::print_stderr, reason = "a test that is left out says so aloud")]

#[path = "cli/batch.rs"]
mod batch;
#[path = "cli/bench.rs"]
mod bench;
#[path = "cli/build.rs"]
mod build;
#[path = "cli/chain.rs"]
mod chain;
#[path = "cli/ci.rs"]
mod ci;
#[path = "cli/compare.rs"]
mod compare;
#[path = "cli/compress.rs"]
mod compress;
#[path = "cli/criterion.rs"]
mod criterion;
#[path = "cli/crowd.rs"]
mod crowd;
#[path = "cli/determinism.rs"]
mod determinism;
#[path = "cli/errors.rs"]
mod errors;
#[path = "cli/extract.rs"]
mod extract;
#[path = "cli/folders.rs"]
mod folders;
#[path = "cli/importance.rs"]
mod importance;
#[path = "cli/inputs.rs"]
mod inputs;
#[path = "cli/output.rs"]
mod output;
#[path = "cli/parts.rs"]
mod parts;
#[path = "cli/paths.rs"]
mod paths;
#[path = "cli/pose.rs"]
mod pose;
#[path = "cli/readme.rs"]
mod readme;
#[path = "cli/refused.rs"]
mod refused;
#[cfg(feature = "gpu")]
#[path = "cli/render.rs"]
mod render;
#[path = "cli/report.rs"]
mod report;
#[path = "cli/select.rs"]
mod select;
#[path = "cli/shaders.rs"]
mod shaders;
#[path = "cli/stream.rs"]
mod stream;
#[path = "cli/strips.rs"]
mod strips;
mod support;
#[path = "cli/textures.rs"]
mod textures;
#[path = "cli/usage.rs"]
mod usage;
#[path = "cli/verify.rs"]
mod verify;
#[path = "cli/view.rs"]
mod view;
#[path = "cli/web.rs"]
mod web;
#[path = "cli/webgpu.rs"]
mod webgpu;
