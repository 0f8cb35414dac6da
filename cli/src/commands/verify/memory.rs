//! Which files have been verified already: for `--if-changed` records beside them, of `NAME` in
//! `.lodc/NAME.verified`, and for `--depfile` every file read.

use super::VerifyArgs;
use super::sources::Sources;
use crate::batch::OptionValues;
use crate::commands::records;
use crate::exit::{Failure, Outcome, Status};
use crate::output::{self, DependencyRule, is_standard_stream};
use crate::program::Program;
use lodc_formats::import::{ImportOptions, import, import_levels};
use lodc_formats::lodc::{MadeFrom, key};
use lodc_formats::{Assets, RequestedFiles};
use lodc_report::FileReport;
use std::path::{Path, PathBuf};

/// What is remembered of runs.
pub(super) struct Memory<'a> {
    args: &'a VerifyArgs,
    import: ImportOptions,
    /// Every option, as text.
    options: String,
}

impl<'a> Memory<'a> {
    /// Checks the options.
    ///
    /// # Errors
    /// If there is no file that a dependency file could have a rule for.
    pub(super) fn new(args: &'a VerifyArgs, program: &Program) -> Outcome<Self> {
        if args.run.depfile.is_some() && args.run.ci.junit().is_none() {
            let what = "--depfile needs --junit FILE: its rule is for that file";
            return Err(Failure::usage(what));
        }
        let read = program.arguments::<VerifyArgs>("verify", &OptionValues::default());
        let (_, options) = read.map_err(Failure::usage)?;
        Ok(Self { args, import: args.import.options(), options })
    }

    /// Verifies a file, unless it was verified before and nothing has changed since. Also returns
    /// the files that this depends on, if anyone asks for them.
    pub(super) fn verified(
        &self,
        input: &Path,
        sources: &Sources,
        verify: impl FnOnce() -> (FileReport, Status),
    ) -> (FileReport, Status, RequestedFiles) {
        let run = &self.args.run;
        // What a device does is seen on the device alone.
        let remembers = run.if_changed && self.args.gpu.gpu.is_none() && !is_standard_stream(input);
        if !remembers && run.depfile.is_none() {
            let (report, status) = verify();
            return (report, status, RequestedFiles::default());
        }
        let mut files = self.files_of(input);
        // A file without a source fails when it is verified.
        let source = sources.of(self.stated_source(input, sources), input).ok().flatten();
        let of_source = source.map(|source| self.files_of(source));
        let keys = [Some((input, &files)), source.zip(of_source.as_ref())];
        let keys = keys.into_iter().flatten().map(|(path, files)| {
            MadeFrom::of(path, files, &self.options, &[]).map(|made| format!("{:032x}\n", made.key))
        });
        let keys: Option<String> = keys.collect();
        let key = keys.map(|keys| format!("{:032x}\n", key(keys.as_bytes())));
        let record = record_path(input);
        let old = std::fs::read_to_string(&record).ok();
        files.extend(&of_source.unwrap_or_default());
        let name = input.display().to_string();
        let checks = Vec::new();
        if remembers && key.is_some() && old == key {
            let report = FileReport { file: name, ok: true, up_to_date: true, checks, error: None };
            return (report, Status::Done, files);
        }
        let (report, status) = verify();
        if let (true, Some(key), Status::Done) = (remembers, key, status) {
            // Without a record the file is verified again.
            let _ = records::write(record, key.into_bytes());
        }
        (report, status, files)
    }

    /// Writes the dependency file: the JUnit file depends on all these.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(super) fn write_depfile(&self, files: &RequestedFiles) -> Outcome<()> {
        let run = &self.args.run;
        let (Some(depfile), Some(junit)) = (&run.depfile, run.ci.junit()) else { return Ok(()) };
        output::write_depfile(depfile, &[DependencyRule::new(junit, files)])
    }

    /// A file and those that it names.
    fn files_of(&self, path: &Path) -> RequestedFiles {
        let mut main = Assets::new(path, &self.import.allowed, self.import.limits);
        let is_whole = super::starts_as_lodc(path);
        let scene = (!is_whole).then(|| import(path, &self.import).ok()).flatten();
        // What cannot be read is a failure when it is verified.
        let _ = main.read_main();
        scene.map_or_else(|| main.files().clone(), |scene| scene.files)
    }

    /// The hash of the mesh that a file was made from, if it is needed and known, else 0.
    fn stated_source(&self, input: &Path, sources: &Sources) -> u128 {
        let hash = match sources {
            Sources::None | Sources::One(_) => None,
            Sources::Folder(..) if super::starts_as_lodc(input) => std::fs::read(input)
                .ok()
                .and_then(|b| lodc::read(&b).ok())
                .map(|f| f.source.content_hash),
            Sources::Folder(..) => {
                import_levels(input, &self.import).ok().map(|levels| levels.stated.source)
            }
        };
        hash.unwrap_or_default()
    }
}

/// The record of a file that has been verified.
pub(crate) fn record_path(input: &Path) -> PathBuf {
    records::path(input, ".verified")
}
