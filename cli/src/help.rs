//! Texts that the help of all commands shares: the headings of groups of options, and the line that
//! leads from `-h` to `--help`.

/// Options that choose a level of detail.
pub(crate) const LEVEL: &str = "Level";
/// The eye, the screen, the moment.
pub(crate) const SEEN: &str = "View";
/// Options of simplifying a mesh.
pub(crate) const SIMPLIFIED: &str = "Simplification";
/// Contents of a `.lodc` file.
pub(crate) const STORED: &str = "File contents";
/// Shape of a result.
pub(crate) const BECOMES: &str = "Output mesh";
/// The checks of `verify`.
pub(crate) const CHECKED: &str = "Checks";
/// The measurements of `compare` and `bench`.
pub(crate) const MEASURED: &str = "Measurements";
/// The limits of `compare`, beyond which it ends with status 1.
pub(crate) const DIFFERENCE: &str = "Thresholds";
/// The graphics device.
pub(crate) const DEVICE: &str = "Graphics device";
/// Where results go, and reports about them.
pub(crate) const OUTPUT: &str = "Output";
/// Folders and lists of assets, and shards of them.
pub(crate) const MANY_ASSETS: &str = "Many assets";
/// Options from files.
pub(crate) const CONFIGURATION: &str = "Configuration";
/// Inputs and what they may name.
pub(crate) const READ: &str = "Input";
/// Bounds on size and work.
pub(crate) const LIMITS: &str = "Limits";
/// Options of every command.
pub(crate) const GENERAL: &str = "General";

/// The last line of `-h`.
pub(crate) const MORE: &str = "--help has the rest: every option in full, and examples.";
