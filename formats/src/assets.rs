//! Access to the files of one asset, which untrusted files name: a main file, and others by
//! relative paths. Paths that lead out of its folder, by name or through symbolic links, devices
//! and pipes are refused, and sizes are limited.

#[cfg(feature = "gltf")]
use crate::percent::percent_decoded;
use crate::words::counted;
use crate::{Fault, FormatError, Limits, RequestedFiles};
use std::ffi::OsStr;
use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

const OUTSIDE: &str =
    "leads out of the asset's own folder (--allow-path FOLDER permits another one)";

/// The folder of an asset and what has been read from it.
#[derive(Clone, Debug)]
pub struct Assets {
    main: PathBuf,
    /// Further folders that may be read.
    allowed: Vec<PathBuf>,
    limits: Limits,
    /// Bytes of all files that have been read.
    total: u64,
    requested: RequestedFiles,
}

impl Assets {
    /// An asset whose main file is `main`, or standard input if that is `-` (which then has no
    /// folder of its own). `allowed` are further folders that may be read.
    #[must_use]
    pub fn new(main: &Path, allowed: &[PathBuf], limits: Limits) -> Self {
        Self {
            main: main.to_owned(),
            allowed: allowed.to_owned(),
            limits,
            total: 0,
            requested: RequestedFiles::default(),
        }
    }
    /// The limits in force.
    #[must_use]
    pub fn limits(&self) -> &Limits {
        &self.limits
    }
    /// Every file looked for so far, named as the user would.
    #[must_use]
    pub fn files(&self) -> &RequestedFiles {
        &self.requested
    }
    /// The main file as the user named it, for messages.
    #[must_use]
    pub fn main_name(&self) -> String {
        if self.is_stdin() { "standard input".to_owned() } else { self.main.display().to_string() }
    }
    /// The main file's name without folder and extension; empty for standard input.
    #[must_use]
    pub fn stem(&self) -> String {
        if self.is_stdin() {
            return String::new();
        }
        self.main.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default()
    }
    fn is_stdin(&self) -> bool {
        self.main.as_os_str() == "-"
    }

    /// Reads the main file.
    ///
    /// # Errors
    /// If it cannot be read, is not a regular file, or is larger than the limits allow.
    pub fn read_main(&mut self) -> Result<Vec<u8>, FormatError> {
        let name = self.main_name();
        if self.is_stdin() {
            let bytes = self.read_bounded(&mut io::stdin().lock(), 0);
            return bytes.map_err(|e| e.in_file(&name));
        }
        let path = self.main.clone();
        self.read_file(&path, &path).map_err(|e| e.in_file(&name))
    }

    /// Reads a file that the asset refers to by a path relative to its folder (percent-decoding is
    /// the caller's).
    ///
    /// # Errors
    /// [`Fault::Forbidden`] if the reference has a scheme or a NUL, or leads out of the allowed
    /// folders, be it by name or through a symbolic link; else if the file is not there, not a
    /// regular file, or too large. The error names the reference as its file.
    pub fn read_reference(&mut self, reference: &str) -> Result<Vec<u8>, FormatError> {
        let file = self.locate(reference).map_err(|e| e.in_file(reference))?;
        let real = file.real();
        let bytes = real.and_then(|real| self.read_file(&real, &file.named));
        if bytes.is_err() {
            self.requested.add_absent(&file.named);
        }
        bytes.map_err(|e| e.in_file(reference))
    }

    /// Reads the file that a name in a document means. Tries in turn the name as it is, with
    /// slashes for backslashes, its last part beside the asset if it leads out of the folder or to
    /// another machine, and the name percent-decoded.
    ///
    /// # Errors
    /// As [`Self::read_reference`] for the name as it is.
    #[cfg(feature = "gltf")]
    pub(crate) fn read_name(&mut self, name: &str) -> Result<Vec<u8>, FormatError> {
        let first = match self.read_reference(name) {
            Err(e) if matches!(e.fault, Fault::Unreadable | Fault::Forbidden) => e,
            other => return other,
        };
        let with_slashes = name.replace('\\', "/");
        let mut others = vec![with_slashes.as_str()];
        if first.fault == Fault::Forbidden || is_of_another_machine(&with_slashes) {
            others.push(last_part(&with_slashes));
        }
        let decoded = percent_decoded(&with_slashes).and_then(|b| String::from_utf8(b).ok());
        others.extend(decoded.as_deref());
        for other in others.into_iter().filter(|other| *other != name) {
            if let Ok(bytes) = self.read_reference(other) {
                self.set_replaced(name);
                self.set_replaced(&with_slashes);
                return Ok(bytes);
            }
        }
        Err(first)
    }

    /// Notes that another file was read instead of one that is not there.
    #[cfg(feature = "gltf")]
    pub(crate) fn set_replaced(&mut self, reference: &str) {
        if let Ok(file) = self.locate(reference) {
            self.requested.set_replaced(&file.named);
        }
    }

    /// The file that a reference names: by its name inside the allowed folders.
    fn locate(&self, reference: &str) -> Result<ReferencedFile, FormatError> {
        let forbidden = |problem: &str| Err(FormatError::new(Fault::Forbidden, "", problem));
        if reference.contains('\0') {
            return forbidden("a file name cannot contain NUL");
        }
        if has_scheme(reference) {
            return forbidden(
                "only files beside the asset are read, never an address with a scheme or drive",
            );
        }
        let relative = Path::new(reference);
        if relative.file_name().is_none() {
            return Err(FormatError::new(Fault::Unreadable, "", "does not name a file"));
        }
        if self.is_stdin() && relative.is_relative() {
            return forbidden(
                "what comes from standard input has no folder to read other files from",
            );
        }
        let folder = match self.main.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
        let own_folder = if self.is_stdin() { None } else { folder.canonicalize().ok() };
        let roots: Vec<PathBuf> = own_folder
            .iter()
            .cloned()
            .chain(self.allowed.iter().filter_map(|a| a.canonicalize().ok()))
            .collect();
        // By name first, so that not even the existence of anything outside is asked about; then by
        // what it really is.
        let absolute = own_folder.unwrap_or_default().join(relative);
        if !normalised(&absolute).is_some_and(|path| is_inside(&path, &roots)) {
            return forbidden(OUTSIDE);
        }
        let named =
            if folder == Path::new(".") { relative.to_owned() } else { folder.join(relative) };
        Ok(ReferencedFile { absolute, named, roots })
    }

    fn read_file(&mut self, path: &Path, named: &Path) -> Result<Vec<u8>, FormatError> {
        // Asked before opening, because opening a FIFO waits for a writer and opening a device may
        // do anything.
        require_regular(&std::fs::metadata(path).map_err(|e| unreadable(&e))?)?;
        let mut file = open(path).map_err(|e| unreadable(&e))?;
        // Asked again of what was really opened.
        let metadata = file.metadata().map_err(|e| unreadable(&e))?;
        require_regular(&metadata)?;
        if metadata.len() > self.bytes_allowed() {
            return Err(self.too_large());
        }
        let bytes = self.read_bounded(&mut file, metadata.len())?;
        self.requested.add_read(named, &bytes);
        Ok(bytes)
    }

    fn bytes_allowed(&self) -> u64 {
        self.limits.file_bytes.min(self.limits.total_bytes.saturating_sub(self.total))
    }

    fn too_large(&self) -> FormatError {
        let problem = if self.limits.total_bytes.saturating_sub(self.total) < self.limits.file_bytes
        {
            let bytes = counted(self.limits.total_bytes, "byte", "bytes");
            format!("the input's files are larger than {bytes} together")
        } else {
            format!("larger than {}", counted(self.limits.file_bytes, "byte", "bytes"))
        };
        FormatError::new(Fault::Limit, "", problem)
    }

    /// Reads to the end, but never more than the limits allow: the size that a directory states
    /// (`expected`) is only a hint.
    fn read_bounded(
        &mut self,
        source: &mut dyn Read,
        expected: u64,
    ) -> Result<Vec<u8>, FormatError> {
        let bytes_allowed = self.bytes_allowed();
        let mut bytes = Vec::new();
        // One byte more than expected lets the end be seen without growing.
        let capacity =
            usize::try_from(expected.min(bytes_allowed).saturating_add(1)).unwrap_or(usize::MAX);
        if bytes.try_reserve_exact(capacity).is_err() {
            return Err(FormatError::new(Fault::Limit, "", "not enough memory to read it"));
        }
        source.take(bytes_allowed.saturating_add(1)).read_to_end(&mut bytes).map_err(
            |e| match e.kind() {
                io::ErrorKind::OutOfMemory => {
                    FormatError::new(Fault::Limit, "", "not enough memory to read it")
                }
                _ => unreadable(&e),
            },
        )?;
        if bytes.len() as u64 > bytes_allowed {
            return Err(self.too_large());
        }
        self.total += bytes.len() as u64;
        Ok(bytes)
    }
}

/// A file that a reference names.
struct ReferencedFile {
    absolute: PathBuf,
    /// As the user would name it.
    named: PathBuf,
    /// The folders that may be read.
    roots: Vec<PathBuf>,
}

impl ReferencedFile {
    /// The path without links, which may lead anywhere; refused if it is outside the folders.
    fn real(&self) -> Result<PathBuf, FormatError> {
        let real = self.absolute.canonicalize().map_err(|e| unreadable(&e))?;
        if is_inside(&real, &self.roots) {
            return Ok(real);
        }
        Err(FormatError::new(Fault::Forbidden, "", OUTSIDE))
    }
}

fn is_inside(path: &Path, roots: &[PathBuf]) -> bool {
    roots.iter().any(|root| path.starts_with(root))
}

/// The message does not depend on the system: warnings are written into files, too.
fn unreadable(error: &io::Error) -> FormatError {
    let problem = match error.kind() {
        io::ErrorKind::NotFound => "no such file".to_owned(),
        io::ErrorKind::PermissionDenied => "permission denied".to_owned(),
        _ => format!("cannot be read: {error}"),
    };
    FormatError::new(Fault::Unreadable, "", problem)
}

fn require_regular(metadata: &Metadata) -> Result<(), FormatError> {
    if metadata.is_file() {
        return Ok(());
    }
    let problem = if metadata.is_dir() {
        "is a folder, not a file"
    } else {
        "is a device, pipe or socket, not a file (`-` reads standard input)"
    };
    Err(FormatError::new(Fault::Unreadable, "", problem))
}

/// Opens without waiting, in case the path has become a FIFO since it was checked.
#[cfg(target_os = "linux")]
fn open(path: &Path) -> io::Result<File> {
    use std::os::unix::fs::OpenOptionsExt;
    const O_NONBLOCK: i32 = 0o4000;
    OpenOptions::new().read(true).custom_flags(O_NONBLOCK).open(path)
}

#[cfg(not(target_os = "linux"))]
fn open(path: &Path) -> io::Result<File> {
    OpenOptions::new().read(true).open(path)
}

/// Returns whether a reference starts like `http:`, `file:`, `data:` or `C:` (RFC 3986, 3.1; a
/// drive letter looks the same).
fn has_scheme(reference: &str) -> bool {
    reference.split_once(':').is_some_and(|(scheme, _)| {
        scheme.starts_with(|c: char| c.is_ascii_alphabetic())
            && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
    })
}

/// Returns whether a path with slashes begins at a root, at a drive, or with `file:`.
#[cfg(feature = "gltf")]
pub(crate) fn is_of_another_machine(path: &str) -> bool {
    path.starts_with('/') || has_scheme(path)
}

/// What follows the last slash of a path.
#[cfg(feature = "gltf")]
pub(crate) fn last_part(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

/// The path without `.` and `..`, by name alone; none if it climbs above the root.
fn normalised(path: &Path) -> Option<PathBuf> {
    let mut out = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir => {
                if out.file_name().is_none_or(|name| name == OsStr::new("..")) || !out.pop() {
                    return None;
                }
            }
            other => out.push(other),
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests;
