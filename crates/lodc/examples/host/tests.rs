//! The example draws what the reference says, whatever was shown before.

use super::*;
use lodc::gpu::{Crowd, GpuError};
use lodc::mesh::{Lod, OrientedTriangle, Simplified};
use lodc::models::interactive::view::{Selector, live_triangles};

/// The graphics device; none, with a line that says so, if there is none. Where all tests are asked
/// for there must be one.
#[expect(clippy::print_stderr, reason = "a test that is left out says so")]
fn device() -> Option<Device> {
    match Device::open(None) {
        Ok(device) => Some(device),
        Err(GpuError::NoAdapter { why }) => {
            assert!(!lodc_fixtures::all_asked(), "{why}");
            eprintln!("SKIPPED: no graphics device: {why}");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

fn fixture(name: &str) -> lodc::File {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/");
    lodc::build(format!("{folder}{name}")).run().expect("a fixture")
}

type Corners = Vec<[[u32; 3]; 3]>;

/// The corners of triangles by the bits of their positions, the smallest corner first; sorted.
fn sorted(triangles: impl Iterator<Item = [[f32; 3]; 3]>) -> Corners {
    let turned = |t: [[f32; 3]; 3]| {
        let mut corners = t.map(|p| p.map(f32::to_bits));
        let first = (0..3).min_by_key(|&i| corners[i]).expect("three corners");
        corners.rotate_left(first);
        corners
    };
    let mut all: Corners = triangles.map(turned).collect();
    all.sort_unstable();
    all
}

fn reference_corners(simplified: &Simplified, triangles: &[OrientedTriangle]) -> Corners {
    let positions = simplified.mesh().positions();
    sorted(triangles.iter().map(|t| t.corners.map(|v| positions[v as usize])))
}

#[test]
fn levels_are_those_of_the_reference_for_every_instance() {
    let Some(device) = device() else { return };
    for name in ["machine_part.glb", "terrain.obj", "several_components.obj"] {
        let file = fixture(name);
        let object = &file.objects()[0];
        let simplified = &object.simplified;
        let last = simplified.collapses().records();
        let mut one = ResidentObject::new(&device, object).expect("a small mesh");
        let mut other = one.another().expect("a small mesh");
        for [a, b] in [[0, 2], [5, 1], [10, 9], [3, 10], [0, 0], [7, 7]] {
            let mut encoder = device.encoder();
            for (instance, part) in [(&mut one, a), (&mut other, b)] {
                instance.show(&mut encoder, Lod(last * part / 10)).expect("a LOD");
            }
            device.submit(encoder).expect("it runs");
            for instance in [&mut one, &mut other] {
                let truth = reference_corners(simplified, &simplified.triangles_at(instance.lod()));
                let drawn = sorted(instance.triangles().expect("it is read").into_iter());
                assert!(drawn == truth, "{name}: LOD {}", instance.lod().0);
            }
        }
        // An instance of an instance begins where that one is.
        let mut third = other.another().expect("a small mesh");
        assert_eq!(third.triangles().expect("it is read"), other.triangles().expect("it is read"));
        assert_eq!(third.lod(), other.lod());
    }
}

#[test]
fn a_crowd_has_the_levels_that_it_is_asked_for() {
    let Some(device) = device() else { return };
    let file = fixture("machine_part.glb");
    let object = &file.objects()[0];
    let simplified = &object.simplified;
    let last = simplified.collapses().records();
    let mut crowd = Crowd::new(&device, object, 3).expect("a small mesh");
    for parts in [[0, 0, 0], [0, 5, 10], [10, 5, 1], [3, 3, 3]] {
        let mut encoder = device.encoder();
        crowd.show(&mut encoder, &parts.map(|part| Lod(last * part / 10))).expect("LODs");
        device.submit(encoder).expect("it runs");
        for (instance, lod) in crowd.lods().to_vec().into_iter().enumerate() {
            let truth = reference_corners(simplified, &simplified.triangles_at(lod));
            let drawn = sorted(crowd.triangles(instance).expect("it is read").into_iter());
            assert!(drawn == truth, "instance {instance}: LOD {}", lod.0);
        }
    }
    let refused = crowd.show(&mut device.encoder(), &[Lod(0)]).expect_err("too few LODs");
    assert_eq!(refused.to_string(), "1 LODs for 3 instances");
}

#[test]
fn views_are_those_of_the_processor_for_every_instance() {
    let Some(device) = device() else { return };
    let file = fixture("terrain.glb");
    let object = &file.objects()[0];
    let simplified = &object.simplified;
    let (selector, positions) = (Selector::new(simplified), simplified.mesh().position_ids());
    let mut one = ViewLevels::new(&device, object).expect("a small mesh");
    let mut other = one.another().expect("a small mesh");
    let camera = Camera::around(simplified.mesh());
    let seen = |pixels| Criterion::ScreenError { eye: camera.eye, slope: camera.slope(pixels) };
    let lod = simplified.collapses().floor(Lod(simplified.collapses().records() / 2));
    let criteria = [seen(1.0), seen(20.0), Criterion::everywhere(lod), seen(3.0)];
    for pair in criteria.windows(2) {
        let mut encoder = device.encoder();
        for (levels, &criterion) in [&mut one, &mut other].into_iter().zip(pair) {
            levels.show(&mut encoder, &ViewQuery { criterion, morph: false }).expect("a view");
        }
        device.submit(encoder).expect("it runs");
        for (levels, criterion) in [&mut one, &mut other].into_iter().zip(pair) {
            let states = selector.states(&selector.lods(criterion), false);
            let truth =
                reference_corners(simplified, &live_triangles(simplified, &positions, &states));
            let drawn = sorted(levels.triangles().expect("it is read").into_iter());
            assert!(drawn == truth && !drawn.is_empty(), "{criterion:?}");
        }
    }
}

#[test]
fn the_example_draws_its_pictures() {
    let Some(device) = device() else { return };
    let name = std::env::temp_dir().join(format!("lodc-host-{}", std::process::id()));
    let name = name.to_str().expect("a plain name");
    let covered = draw(&device, &fixture("machine_part.glb"), name).expect("it draws");
    assert!(covered.iter().all(|&pixels| pixels > 2_000), "{covered:?}");
    for picture in ["levels", "view"] {
        std::fs::remove_file(format!("{name}.{picture}.png")).expect("it was written");
    }
}
