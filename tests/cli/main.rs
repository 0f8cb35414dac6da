//! The command line as scripts and people meet it: one module per promise of docs/CLI.md.

#![expect(clippy::print_stderr, reason = "a test that is left out says so aloud")]

mod batch;
mod bench;
mod bombs;
mod build;
mod chain;
mod ci;
mod colours;
mod compare;
mod compress;
mod corpus;
mod criterion;
mod crowd;
mod determinism;
mod engines;
mod errors;
mod extensions;
mod extract;
mod far;
mod fixtures;
mod folders;
mod geomorph;
mod importance;
mod inputs;
mod irregular;
mod limits;
mod locks;
mod loose;
mod motion;
mod names;
mod output;
mod parts;
mod paths;
mod placements;
mod pose;
mod poses;
mod readme;
mod refused;
#[cfg(feature = "gpu")]
mod render;
mod report;
mod second_reader;
mod select;
mod shaders;
mod shipped;
mod stream;
mod strips;
mod support;
mod textures;
mod usage;
mod validator;
mod verify;
mod view;
mod web;
mod webgpu;
