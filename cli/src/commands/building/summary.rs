//! The summary that is printed after a build.

use super::pipeline::BuildOutput;
use crate::console::{Loudness, note, wants};
use crate::output::Target as Output;
use lodc::{levels::TABLE_SHARES, scene_levels};
use lodc_formats::Limits;
use lodc_formats::images::Textures;
use lodc_report::text::{count, distance, grouped, percent, quoted, size};
use lodc_select::{Selection, Target, scene_diagonal};
use std::fmt::Write;
use std::path::Path;

/// Prints the summary on standard error, unless `-q`.
pub(super) fn print(made: &BuildOutput, output: &Output, seconds: f64) {
    if wants(Loudness::Normal) {
        note(text(made, output, seconds).trim_end());
    }
}

/// One line, for one of many assets.
pub(super) fn line(made: &BuildOutput, output: &Output, seconds: f64) -> String {
    let triangles = made.file.objects.iter().map(|o| o.simplified.mesh().triangles().len() as u64);
    let (triangles, bytes) = (count(triangles.sum(), "triangle"), size(made.bytes as u64));
    let images = match images_to_copy(made, output).len() {
        0 => String::new(),
        missing => format!("; copy {} beside it", count(missing as u64, "image")),
    };
    format!("{}: {triangles}, {bytes} in {seconds:.2} s{images}", output.name())
}

/// Image files that the document names and that are not where the file looks for them: those of a
/// mesh in another folder. Those that are missing there, too, have a warning of their own.
fn images_to_copy(made: &BuildOutput, output: &Output) -> Vec<String> {
    let Output::File(path) = output else { return Vec::new() };
    let folder = path.parent().unwrap_or(Path::new(""));
    let names = Textures::names(&made.file.document).unwrap_or_default();
    let absent = made.files.absent();
    let is_there = |name: &String| !absent.iter().any(|path| path.ends_with(name));
    names.into_iter().filter(|name| !folder.join(name).exists()).filter(is_there).collect()
}

fn text(made: &BuildOutput, output: &Output, seconds: f64) -> String {
    let objects = &made.file.objects;
    let counts: Vec<_> = objects.iter().map(|o| super::counts(&o.info, &o.simplified)).collect();
    let sum =
        |of: fn(&lodc_report::documents::ObjectCounts) -> u64| counts.iter().map(of).sum::<u64>();
    let (referenced, triangles, fakes) =
        (sum(|c| c.referenced_vertices), sum(|c| c.triangles), sum(|c| c.fakes));
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "{}: {}, {} vertices, {}",
        output.name(),
        count(triangles, "triangle"),
        grouped(referenced),
        count(sum(|c| c.submeshes), "submesh")
    );
    let _ = writeln!(
        text,
        "  {}, {}, {}",
        count(objects.len() as u64, "object"),
        count(sum(|c| c.steps), "step"),
        match fakes {
            0 => "no vertices duplicated at seams".to_owned(),
            _ => format!(
                "{} duplicated at seams ({:.1} %)",
                count(fakes, "vertex"),
                percent(fakes, referenced)
            ),
        }
    );
    if let [one] = counts.as_slice() {
        let legal =
            objects[0].simplified.collapses().triangles_at(lodc_mesh::Lod(one.last_legal_lod));
        let _ = writeln!(
            text,
            "  valid down to LOD {} of {} ({} left)",
            grouped(u64::from(one.last_legal_lod)),
            grouped(one.records),
            count(u64::from(legal), "triangle")
        );
    }
    table(&mut text, made);
    let _ = writeln!(text, "  {} in {seconds:.2} s", size(made.bytes as u64));
    let images = images_to_copy(made, output);
    if let [first, more @ ..] = images.as_slice() {
        let more = match more.len() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let what = count(images.len() as u64, "image");
        let _ = writeln!(text, "  copy {what} beside it: {first}{more}");
    }
    if let Output::File(path) = output
        && triangles > 0
    {
        let example = path.with_extension("10percent.glb");
        let _ = writeln!(
            text,
            "  next: lodc extract {} --ratio 0.1 -o {}",
            quoted(path),
            quoted(&example)
        );
    }
    text
}

/// Adds a table of levels: triangles and errors by share of the triangles.
fn table(text: &mut String, made: &BuildOutput) {
    let objects = &made.file.objects;
    let Ok(levels) = scene_levels(objects, &made.file.document, &Limits::DEFAULT) else {
        return;
    };
    let candidates = levels.candidates();
    let triangles: u64 = candidates.iter().map(|c| u64::from(c.collapses.parts().triangles)).sum();
    if triangles == 0 {
        return;
    }
    let diagonal = scene_diagonal(&candidates);
    let _ = writeln!(text, "     share   triangles       error   of the diagonal         rms");
    for share in TABLE_SHARES {
        let chosen = levels.select(Target::Ratio(share));
        let Ok(Selection { lods, error, rms, .. }) = chosen else { continue };
        let remaining: u64 = candidates
            .iter()
            .zip(&lods)
            .map(|(c, &l)| u64::from(c.collapses.triangles_at(l)))
            .sum();
        let _ = writeln!(
            text,
            "    {:4.0} %{:>12}{:>12}{:16.3} %{:>12}",
            share * 100.0,
            grouped(remaining),
            distance(error),
            if diagonal > 0.0 { error / diagonal * 100.0 } else { 0.0 },
            rms.map_or("-".to_owned(), distance)
        );
    }
}
