//! Reads an input that is a mesh file or a `.lodc` file.

use lodc_formats::FormatError;
use lodc_formats::import::{self, ImportOptions};
use lodc_lod::AnyModel;
use std::path::Path;

/// A mesh file or a `.lodc` file.
pub type Input = import::Either<AnyModel>;

/// Reads a mesh file or a `.lodc` file, `-` from standard input.
///
/// ```
/// use lodc::formats::import::ImportOptions;
/// use std::path::Path;
///
/// for name in ["machine_part.glb", "golden/v1/two_parts.lodc"] {
///     let path = Path::new("../../fixtures").join(name);
///     match lodc::read_input(&path, &ImportOptions::default())? {
///         lodc::Input::Scene(scene) => println!("{name}: {} meshes", scene.objects.len()),
///         lodc::Input::Lodc(file) => println!("{name}: {} objects", file.objects.len()),
///     }
/// }
/// # Ok::<(), lodc::formats::FormatError>(())
/// ```
///
/// # Errors
/// If it cannot be read, is malformed, unsupported, or larger than the limits. The error names the
/// file.
pub fn read_input(path: &Path, options: &ImportOptions) -> Result<Input, FormatError> {
    import::either(path, options, crate::read)
}
