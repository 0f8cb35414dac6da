//! Environment variables that libraries read as the program starts. They can be set without
//! `unsafe` for a new program only, so the program starts again with them.

use std::path::Path;

/// A variable that a run needs.
#[cfg_attr(not(unix), expect(dead_code, reason = "only Unix starts a program in its own place"))]
#[derive(Clone, Copy)]
pub(crate) struct Variable {
    name: &'static str,
    /// The value that it gets, unless it has one that will do.
    value: &'static str,
    /// Whether a value that it has will do.
    accepts: fn(&Path) -> bool,
}

/// Set for work on a graphics device: Mesa's Vulkan layer asks a Wayland server which of several
/// devices to prefer, and the Wayland library prints a line on standard error where this is
/// missing. The folder does not exist, and only root can make it, so no server can be there.
pub(crate) const RUNTIME_FOLDER: Variable = Variable {
    name: "XDG_RUNTIME_DIR",
    value: "/nonexistent",
    accepts: |folder| folder.is_absolute(),
};

/// Set for work on large meshes: milliseconds after which the allocator gives free memory back.
/// Measured on a million triangles: with 1,000, the default, the peak is a quarter higher than with
/// 10; with 50, a tenth higher; with 1 it is the same, and the work takes a twentieth more time.
pub(crate) const RETURN_MEMORY: Variable =
    Variable { name: "MIMALLOC_PURGE_DELAY", value: "10", accepts: |_| true };

/// Starts the program again with those of the variables set that have no acceptable value. Returns
/// only if all have one or the program cannot be started again: it then works without them.
#[cfg(unix)]
pub(crate) fn restart_with(variables: &[Variable]) {
    use std::os::unix::process::CommandExt;
    let is_set = |variable: &Variable| {
        std::env::var_os(variable.name).is_some_and(|value| (variable.accepts)(Path::new(&value)))
    };
    if variables.iter().all(is_set) {
        return;
    }
    let Ok(program) = std::env::current_exe() else { return };
    let mut arguments = std::env::args_os();
    let name = arguments.next().unwrap_or_default();
    let missing = variables.iter().filter(|v| !is_set(v)).map(|v| (v.name, v.value));
    let mut command = std::process::Command::new(program);
    let _ = command.arg0(name).args(arguments).envs(missing).exec();
}

/// Does nothing: other systems need no variables.
#[cfg(not(unix))]
pub(crate) fn restart_with(_: &[Variable]) {}
