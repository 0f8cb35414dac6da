//! `lodc verify`: every model of every file, replayed against the reference.

mod gpu;
mod memory;
mod sources;

use super::each;
use super::read::read_lodc;
use super::runs::{ReportFormat, RunArgs};
use crate::batch;
use crate::clock::{self, Clock};
use crate::console::{self, Loudness, wants};
use crate::exit::{Failure, Outcome, Status, one_line};
use crate::gpu::GpuArgs;
use crate::help::{CHECKED, MANY_ASSETS, MORE};
use crate::limits::ImportArgs;
use crate::numbers::whole;
use crate::output::is_standard_stream;
use crate::program::Program;
use clap::Args;
use gpu::Gpu;
use lodc_formats::RequestedFiles;
use lodc_formats::import::{ImportOptions, import, import_levels, states_levels};
use lodc_report::text::{count, grouped};
use lodc_report::{
    CheckReport, FileReport, SCHEMA_VERSION, VerifyReport, check_errors_again, check_geomorph,
    check_levels, check_models_by_reference, check_source,
};
use memory::Memory;
pub(super) use memory::record_path;
use rayon::prelude::*;
use sources::Sources;
use std::fs::File;
use std::io::Read;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

/// Options of `verify`.
#[derive(Args, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct VerifyArgs {
    /// .lodc files, levels (with --source), or folders of both; - for standard input
    #[arg(value_name = "INPUT", required = true)]
    inputs: Vec<PathBuf>,
    /// Also compare with the original: LOD 0 byte by byte, levels by distance
    ///
    /// LOD 0 of a .lodc file has to have the triangles of MESH. Levels that extract and chain wrote
    /// are measured against it; without MESH only those of chain --geomorph are checked: each,
    /// moved, has to be the next one. If MESH is a folder, the mesh is found there by its content.
    #[arg(long, value_name = "MESH", help_heading = CHECKED)]
    source: Option<PathBuf>,
    /// Check every N-th step
    #[arg(long, value_name = "N", default_value = "1", value_parser = whole::<NonZeroU32>(1..),
          help_heading = CHECKED)]
    stride: NonZeroU32,
    #[command(flatten)]
    pub(crate) gpu: GpuArgs,
    #[command(flatten)]
    run: RunArgs,
    /// In folders, only files whose path below the folder matches
    ///
    /// * does not match a slash, ** does. May be given several times.
    #[arg(long, value_name = "GLOB", help_heading = MANY_ASSETS, hide_short_help = true)]
    include: Vec<String>,
    /// In folders, no files whose path below the folder matches
    ///
    /// * does not match a slash, ** does. May be given several times.
    #[arg(long, value_name = "GLOB", help_heading = MANY_ASSETS, hide_short_help = true)]
    exclude: Vec<String>,
    #[command(flatten)]
    import: ImportArgs,
}

const EXAMPLES: &str = "\
Examples:
  lodc verify chair.lodc --source chair.glb --gpu
  lodc verify levels --source models --junit results.xml
  lodc verify chair.levels.glb --source chair.glb";

/// Extensions of files that are verified: those with all levels, then those with exported levels,
/// which take a source.
const VERIFIED_EXTENSIONS: [&str; 6] = ["lodc", "glb", "gltf", "vrm", "obj", "ply"];

pub(crate) fn run(args: &VerifyArgs, program: &Program) -> Outcome<Status> {
    let standard_inputs =
        args.inputs.iter().chain(&args.source).filter(|path| is_standard_stream(path));
    if standard_inputs.count() > 1 {
        return Err(Failure::usage("standard input can be read once only"));
    }
    args.run.ci.check(args.inputs.iter().chain(&args.source).map(PathBuf::as_path))?;
    let memory = Memory::new(args, program)?;
    let gpu = gpu::open(args.gpu.gpu, args.gpu.adapter.as_deref())?;
    let mut report = VerifyReport { schema_version: SCHEMA_VERSION, ok: true, files: vec![] };
    let (mut worst, mut files) = (Status::Done, RequestedFiles::default());
    let options = args.import.options();
    let kinds: &[&str] =
        if args.source.is_some() { &VERIFIED_EXTENSIONS } else { &VERIFIED_EXTENSIONS[..1] };
    let mut inputs = batch::expand_folders(&args.inputs, kinds, &args.include, &args.exclude)?;
    // In folders, meshes that are not levels by lodc are skipped; named ones are checked anyway.
    inputs.retain(|path| {
        let is_named =
            args.inputs.contains(path) || path.extension() == Some(VERIFIED_EXTENSIONS[0].as_ref());
        is_named || states_levels(path, &options)
    });
    clock::expect_several(inputs.len() > 1);
    let sources = Sources::new(args.source.as_deref(), &options)?;
    let one = |input: &PathBuf| {
        memory.verified(input, &sources, || verify_one(args, &sources, gpu.as_ref(), input))
    };
    // On a device one file at a time: several would share its memory. Else two files for each
    // thread, so that few threads are idle while the last files of a group are verified.
    let max_group_files = if gpu.is_some() { 1 } else { 2 * rayon::current_num_threads() };
    for group in groups(&inputs, max_group_files) {
        let done: Vec<(FileReport, Status, RequestedFiles)> =
            group.par_iter().with_max_len(1).map(one).collect();
        for (file, status, read) in done {
            files.extend(&read);
            report.ok &= file.ok;
            worst = worst.max(status);
            match args.run.format() {
                None => print(&file)?,
                Some(ReportFormat::Json) => {}
                Some(ReportFormat::Jsonl) => console::json_line(&file)?,
            }
            report.files.push(file);
        }
    }
    args.run.ci.publish("lodc verify", &report.suites())?;
    memory.write_depfile(&files)?;
    if args.run.if_changed {
        let left = report.files.iter().filter(|file| file.up_to_date).count();
        let failed = report.files.iter().filter(|file| !file.ok).count();
        let verified = report.files.len() - left - failed;
        let failed = if failed > 0 { format!(", {failed} failed") } else { String::new() };
        console::note(&format!("{verified} verified, {left} up to date{failed}"));
    }
    match args.run.format() {
        None => {}
        Some(ReportFormat::Json) => console::json(&report)?,
        Some(ReportFormat::Jsonl) => console::json_line(&report.summary())?,
    }
    Ok(worst)
}

/// Bytes, at most, of the files that are verified at a time; a larger file is verified alone.
/// Chosen by hand: small files give work to all threads, and groups take little memory.
const MAX_GROUP_BYTES: u64 = 16 << 20;

/// Divides inputs, in order, into groups that are verified at a time, each of at most
/// `max_group_files` files.
fn groups(inputs: &[PathBuf], max_group_files: usize) -> Vec<&[PathBuf]> {
    let bytes = |path: &PathBuf| path.metadata().map_or(0, |m| m.len());
    let (mut groups, mut first, mut sum) = (Vec::new(), 0, 0);
    for (i, size) in inputs.iter().map(bytes).enumerate() {
        if i > first && (i - first == max_group_files || sum + size > MAX_GROUP_BYTES) {
            groups.push(&inputs[first..i]);
            (first, sum) = (i, 0);
        }
        sum += size;
    }
    groups.extend((first < inputs.len()).then(|| &inputs[first..]));
    groups
}

/// Verifies one file. A failure is in its report and does not stop the other files.
fn verify_one(
    args: &VerifyArgs,
    sources: &Sources,
    gpu: Option<&Gpu>,
    input: &Path,
) -> (FileReport, Status) {
    let name = input.display().to_string();
    let failure = match each::guarded(input, || check(args, sources, gpu, input)) {
        Ok(checks) => {
            let ok = checks.iter().all(|c| c.ok != Some(false));
            let status = if ok { Status::Done } else { Status::Difference };
            return (FileReport { file: name, ok, up_to_date: false, checks, error: None }, status);
        }
        Err(failure) => failure,
    };
    each::print(&failure);
    (
        FileReport {
            file: name,
            ok: false,
            up_to_date: false,
            checks: vec![],
            error: Some(failure.message),
        },
        failure.status,
    )
}

fn check(
    args: &VerifyArgs,
    sources: &Sources,
    gpu: Option<&Gpu>,
    input: &Path,
) -> Outcome<Vec<CheckReport>> {
    let (options, clock) = (args.import.options(), args.import.clock(input));
    if !is_standard_stream(input) && !starts_as_lodc(input) {
        return check_exported(sources, input, &options, &clock);
    }
    let limits = options.limits;
    let (file, _) = read_lodc(input, limits)?;
    clock.check();
    let (mut all, references) =
        check_models_by_reference(&file.objects, &file.document, args.stride.get(), &limits)?;
    clock.check();
    all.extend(check_errors_again(&file, &limits)?);
    clock.check();
    if let Some(source) = sources.of(file.source.content_hash, input)? {
        all.extend(check_source(&file, source, &options)?);
    }
    if let (Some(gpu), Some(wanted)) = (gpu, args.gpu.gpu) {
        all.extend(gpu::checks(&file, &references, gpu, wanted)?);
    }
    Ok(all)
}

/// Returns whether a file begins as a .lodc file does, or cannot be read: then reading it as one
/// says why.
fn starts_as_lodc(input: &Path) -> bool {
    let mut head = [0; 8];
    let read = File::open(input).and_then(|mut file| file.read(&mut head));
    read.map_or(true, |n| lodc_formats::lodc::is_lodc(&head[..n]))
}

/// Checks levels that `extract` or `chain` wrote against the mesh.
fn check_exported(
    sources: &Sources,
    input: &Path,
    options: &ImportOptions,
    clock: &Clock,
) -> Outcome<Vec<CheckReport>> {
    let levels = import_levels(input, options)?;
    clock.check();
    let geomorph = check_geomorph(&levels);
    let Some(source) = sources.of(levels.stated.source, input)? else {
        // Whether each level, moved, is the next one can be checked without the mesh.
        if let Some(geomorph) = geomorph {
            return Ok(vec![geomorph]);
        }
        let name = input.display();
        let what =
            format!("{name}: levels are verified against their mesh: give it with --source MESH");
        return Err(Failure::usage(what));
    };
    let source = import(source, options)?;
    clock.check();
    let mut all = check_levels(&levels, &source, &options.limits)?;
    clock.check();
    all.extend(geomorph);
    Ok(all)
}

/// One line per check on standard output; with `-q` only those that failed.
fn print(file: &FileReport) -> Outcome<()> {
    if file.up_to_date && wants(Loudness::Normal) {
        return console::result(&one_line(&format!("{}: up to date", file.file)));
    }
    for check in &file.checks {
        if check.ok != Some(false) && !wants(Loudness::Normal) {
            continue;
        }
        let verdict = match check.ok {
            Some(true) => "ok",
            Some(false) => "DIFFERENT",
            None => "skipped",
        };
        let object = check.object.as_deref().map(|o| format!(" {o}")).unwrap_or_default();
        let reason = check.first_difference.as_ref().or(check.skipped.as_ref());
        let reason = reason.map(|r| format!(": {r}")).unwrap_or_default();
        // Printed only if some levels were compared in full, but not all.
        let full = if (1..check.lods).contains(&check.full) {
            format!(" ({} in full)", grouped(check.full))
        } else {
            String::new()
        };
        let device = check
            .adapter
            .as_deref()
            .map_or(check.device.to_owned(), |a| format!("{} {a}", check.device));
        let line = format!(
            "{}:{object} {}, {}, {device}: {verdict}, {}{full}{reason}",
            file.file,
            check.model,
            check.check,
            count(check.lods, "LOD")
        );
        console::result(&one_line(&line))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_keep_the_order_and_large_files_are_alone() {
        let folder = std::env::temp_dir().join(format!("lodc-groups-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let large = folder.join("large");
        let file = File::create(&large).expect("a file");
        file.set_len(MAX_GROUP_BYTES + 1).expect("a sparse file");
        let small = folder.join("small");
        let inputs = [&small, &small, &small, &large, &small].map(Clone::clone);
        let sizes: Vec<usize> = groups(&inputs, 2).into_iter().map(<[PathBuf]>::len).collect();
        std::fs::remove_dir_all(&folder).expect("it is there");
        assert_eq!(sizes, [2, 1, 1, 1]);
        assert!(groups(&[], 2).is_empty());
    }
}
