//! Figures on a device whose buffers are too small for the models.

#![expect(clippy::print_stderr, reason = "a test that is left out says so aloud")]

use super::*;
use crate::{Prepared, Settings, tables};
use lodc_formats::ObjectInfo;
use lodc_gpu::LimitOverrides;
use std::sync::Arc;

#[test]
fn what_a_device_has_no_room_for_is_left_out_and_the_rest_is_timed() {
    // 642 positions are 7,704 bytes, and lists of the models more than as many again.
    let limits = LimitOverrides { binding_bytes: Some(7000), ..LimitOverrides::default() };
    let device = match Device::open_with(None, &limits) {
        Ok(device) => device,
        Err(error) => return eprintln!("left out: {error}"),
    };
    assert_eq!(most_triangles(&device), 218);
    let ball = lodc_fixtures::icosphere(3);
    let simplified = Arc::new(lodc_fixtures::random_collapse(&ball, 1));
    let info = ObjectInfo {
        name: "ball".to_owned(),
        submeshes: vec![],
        world_scale: 1.0,
        document_mesh: 0,
        poses: vec![],
    };
    let object = LodObject { info, simplified, models: vec![] };
    let prepared = Prepared::new(object, &[], Default::default()).expect("models");
    let settings = Settings { steps: 0.1, rounds: Some(1), streams: false };
    let figures = crate::measure(&prepared, &settings, Some(&device)).expect("figures");
    let report = figures.gpu.as_ref().expect("a device");
    let names: Vec<&str> = report.left_out.keys().map(String::as_str).collect();
    assert_eq!(names, ["speed", "masking", "interactive"]);
    assert!(report.models.is_empty() && report.words_per_vertex.len() == 3);
    assert_eq!(report.primitives.len(), 4);
    assert!(report.curve.structures["interactive"].draw_ms.iter().all(|&ms| ms > 0.0));
    let text = tables(&figures, settings.steps);
    assert!(text.contains("interactive left out: ") && text.contains("allows 7000"), "{text}");
}
