//! Meshes that are too large are refused; small ones stand in for them under lowered limits.

use crate::support::{device, models, reference};
use lodc_fixtures as fixtures;
use lodc_gpu::{Device, GpuError, LimitOverrides, replay};
use lodc_lod::AnyModel;
use lodc_model::Model;
use lodc_plan::schedule;

fn lowered(lowered: &LimitOverrides) -> Option<Device> {
    device().map(|_| Device::open_with(None, lowered).expect("limits below those of an adapter"))
}

/// Replays every model; the first error, or whether all was well.
fn all(device: &Device, models: &[AnyModel]) -> Result<(), GpuError> {
    for model in models {
        let stops = schedule(model.simplified().collapses(), 6, 2, 1);
        let reference = reference(model.simplified());
        for plan in model.replays(&stops, &reference).expect("a small mesh") {
            assert_eq!(replay(device, plan)?.difference, None, "{}", model.name());
        }
    }
    Ok(())
}

/// 3 × 3 workgroups have 2304 threads, and 642 vertices, 1280 triangles or their strips make up to
/// eight workgroups in rows.
#[test]
fn passes_with_too_many_workgroups_for_a_row_take_several() {
    let models = models(fixtures::random_collapse(&fixtures::icosphere(3), 1));
    let lowered = |most| {
        lowered(&LimitOverrides {
            workgroups_per_dimension: Some(most),
            ..LimitOverrides::default()
        })
    };
    let Some(device) = lowered(3) else { return };
    all(&device, &models).expect("several rows");
    // With one there is no room left: nothing is cut off, and the limit has its name.
    let Some(device) = lowered(1) else { return };
    let refused = all(&device, &models).expect_err("too many workgroups");
    assert!(refused.to_string().contains("max_compute_workgroups_per_dimension"), "{refused}");
    assert!(matches!(refused, GpuError::Limit { allowed: 1, needed: 2.., .. }), "{refused:?}");
}

#[test]
fn buffers_too_large_for_a_binding_are_refused_by_name() {
    let models = models(fixtures::random_collapse(&fixtures::icosphere(3), 1));
    // 642 positions are 7704 bytes.
    let lowered =
        |most| lowered(&LimitOverrides { binding_bytes: Some(most), ..LimitOverrides::default() });
    let Some(device) = lowered(7000) else { return };
    let refused = all(&device, &models).expect_err("a buffer that is too large");
    assert!(refused.to_string().contains("max_storage_buffer_binding_size"), "{refused}");
    assert!(matches!(refused, GpuError::Limit { allowed: 7000, .. }), "{refused:?}");
    let Some(device) = lowered(1 << 20) else { return };
    all(&device, &models).expect("large enough");
}
