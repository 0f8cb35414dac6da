//! JSON of a stream's objects: names, counts and steps received, for `info` and `unpack`.

use lodc_formats::ObjectInfo;
use lodc_formats::lods::Unpacker;
use lodc_report::ErrorsOver;
use lodc_report::documents::UnpackedReport;
use lodc_select::decimal;

/// Returns how much of each object has been received, and of how much. `infos` has their names.
pub(super) fn reports(unpacker: &Unpacker, infos: &[ObjectInfo]) -> Vec<UnpackedReport> {
    let object = |(i, info): (usize, &ObjectInfo)| {
        let progress = unpacker.progress(i);
        let [vertices, of_vertices] = progress.vertices;
        let [triangles, of_triangles] = progress.triangles;
        let [steps, of_steps] = progress.steps;
        UnpackedReport {
            name: info.name.clone(),
            vertices,
            of_vertices,
            triangles,
            of_triangles,
            steps,
            of_steps,
            error: decimal(progress.error),
            rms: progress.rms.map(decimal),
            world_error: info.world_scale * decimal(progress.error),
            world_rms: progress.rms.map(|rms| info.world_scale * decimal(rms)),
            errors_over: ErrorsOver::of([info]),
        }
    };
    infos.iter().enumerate().map(object).collect()
}
