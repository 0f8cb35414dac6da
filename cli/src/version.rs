//! `lodc --version --json`: versions of program and formats, and what this program was built with.

use crate::console;
use crate::exit::Outcome;
use lodc_formats::{lodc, lods};
use serde::Serialize;

#[derive(Serialize)]
struct Versions {
    schema_version: u32,
    name: &'static str,
    version: &'static str,
    formats: Formats,
    features: &'static [&'static str],
    graphics_apis: &'static [&'static str],
}

#[derive(Serialize)]
struct Formats {
    lodc: u16,
    lods: u16,
}

/// Returns whether the arguments are `--version` (or `-V`) and `--json`, in either order. Without
/// `--json`, and with anything else, the command line answers by itself.
pub(crate) fn is_asked_for_as_json() -> bool {
    let args: Vec<_> = std::env::args_os().skip(1).collect();
    let version = |arg: &std::ffi::OsString| arg == "--version" || arg == "-V";
    args.len() == 2 && args.iter().any(version) && args.iter().any(|arg| arg == "--json")
}

/// Prints the document.
///
/// # Errors
/// If standard output cannot be written.
pub(crate) fn print() -> Outcome<()> {
    let gpu = cfg!(feature = "gpu");
    console::json(&Versions {
        schema_version: lodc_report::SCHEMA_VERSION,
        name: "lodc",
        version: env!("CARGO_PKG_VERSION"),
        formats: Formats { lodc: lodc::VERSION, lods: lods::VERSION },
        features: if gpu { &["gpu"] } else { &[] },
        graphics_apis: if gpu { &["vulkan"] } else { &[] },
    })
}
