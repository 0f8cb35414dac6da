//! Environment variables that libraries read as the program starts. They can be set safely for a
//! new program only, so the program starts again with them.

use std::path::Path;

/// A variable, the value it gets, and whether one that it has will do.
type Variable = (&'static str, &'static str, fn(&Path) -> bool);

/// Set for work on a graphics device: Mesa's Vulkan layer asks a Wayland server which of several
/// devices to prefer, and the Wayland library prints a line on standard error where this is
/// missing. The folder does not exist, and only root can make it, so no server can be there.
pub(crate) const RUNTIME_FOLDER: Variable =
    ("XDG_RUNTIME_DIR", "/nonexistent", |folder| folder.is_absolute());

/// Set for work on large meshes, in milliseconds after which the allocator gives free memory back.
/// By default a thousand: a quarter more at the peak of a million triangles. Fifty: a tenth more.
/// One: a twentieth more time, for as much memory.
pub(crate) const RETURN_MEMORY: Variable = ("MIMALLOC_PURGE_DELAY", "10", |_| true);

/// Starts the program again with those of some variables that are not as they should be. Returns
/// only if there is nothing to do or it cannot be done; then nothing else is lost.
#[cfg(unix)]
pub(crate) fn restart_with(variables: &[Variable]) {
    use std::os::unix::process::CommandExt;
    let is_set = |(name, _, will_do): &Variable| {
        std::env::var_os(name).is_some_and(|value| will_do(Path::new(&value)))
    };
    if variables.iter().all(is_set) {
        return;
    }
    let Ok(program) = std::env::current_exe() else { return };
    let mut arguments = std::env::args_os();
    let name = arguments.next().unwrap_or_default();
    let missing = variables.iter().filter(|v| !is_set(v)).map(|&(name, value, _)| (name, value));
    let mut command = std::process::Command::new(program);
    let _ = command.arg0(name).args(arguments).envs(missing).exec();
}

/// Does nothing: other systems need none of it.
#[cfg(not(unix))]
pub(crate) fn restart_with(_: &[Variable]) {}
