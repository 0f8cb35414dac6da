//! `lodc --version --json`: versions of program and formats, and what this program was built with.

use crate::console;
use crate::exit::Outcome;
use lodc_formats::{lodc, lods};
use serde_json::json;

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
    console::json(&json!({
        "schema_version": crate::report::SCHEMA_VERSION,
        "name": "lodc",
        "version": env!("CARGO_PKG_VERSION"),
        "formats": { "lodc": lodc::VERSION, "lods": lods::VERSION },
        "features": if gpu { vec!["gpu"] } else { vec![] },
        "graphics_apis": if gpu { vec!["vulkan"] } else { vec![] },
    }))
}
