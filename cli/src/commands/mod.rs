//! One module per command: its options and what it does.

mod asset;
pub(crate) mod bench;
pub(crate) mod build;
pub(crate) mod chain;
mod ci;
pub(crate) mod compare;
pub(crate) mod completions;
pub(crate) mod config;
mod each;
mod export;
pub(crate) mod extract;
pub(crate) mod info;
mod input;
pub(crate) mod man;
pub(crate) mod pack;
mod read;
pub(crate) mod render;
pub(crate) mod report;
pub(crate) mod select;
pub(crate) mod shaders;
mod stream_objects;
pub(crate) mod strips;
pub(crate) mod unpack;
pub(crate) mod verify;
pub(crate) mod view;
