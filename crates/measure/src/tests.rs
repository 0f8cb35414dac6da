use crate::{
    Pyramid, Sampling, ShadingOptions, Surface, Viewing, compare_pictures, distances, pictures,
};
use glam::{Vec2, Vec3};
use lodc_scene::{Image, Material, Texture, Wrap};

/// A sphere of `rows` × `2 rows` squares.
fn sphere(rows: u32, radius: f32, shift: Vec3) -> Surface {
    let columns = 2 * rows;
    let mut s = Surface::default();
    for i in 0..=rows {
        for j in 0..=columns {
            let (polar, around) = (
                std::f32::consts::PI * i as f32 / rows as f32,
                std::f32::consts::TAU * j as f32 / columns as f32,
            );
            let n = Vec3::new(polar.sin() * around.cos(), polar.cos(), -polar.sin() * around.sin());
            s.positions.push(n * radius + shift);
            s.normals.push(n);
            s.texture.push(Vec2::new(j as f32 / columns as f32, i as f32 / rows as f32));
        }
    }
    let at = |i, j| i * (columns + 1) + j;
    for i in 0..rows {
        for j in 0..columns {
            s.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            s.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    s
}

fn square(z: f32) -> Surface {
    let positions =
        [[0., 0.], [1., 0.], [1., 1.], [0., 1.]].map(|[x, y]| Vec3::new(x, y, z)).to_vec();
    Surface { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..Surface::default() }
}

#[test]
fn a_surface_is_nowhere_from_itself() {
    let s = sphere(12, 1.0, Vec3::ZERO);
    let d = distances(&s, &s, &Sampling::DEFAULT);
    assert!(d.hausdorff.iter().chain(&d.rms).all(|&x| x < 1e-6), "{d:?}");
    let cameras = Viewing { views: 5, size: 64 }.cameras(&s);
    let p = pictures(&s, &cameras, ShadingOptions::default());
    let error = compare_pictures(&p, &p);
    assert_eq!((error.rmse, error.silhouette), (0.0, 0.0));
    assert!(p.iter().all(|p| p.colours.iter().any(|c| c[0] > 200.0)));
}

#[test]
fn parallel_squares_are_as_far_apart_as_they_are() {
    let d = distances(&square(0.0), &square(0.25), &Sampling::DEFAULT);
    assert!(d.hausdorff.iter().chain(&d.rms).all(|&x| (x - 0.25).abs() < 1e-12), "{d:?}");
}

#[test]
fn a_part_is_near_the_whole_but_not_the_whole_near_the_part() {
    let whole = square(0.0);
    let part = Surface { triangles: vec![[0, 1, 2]], ..whole.clone() };
    let d = distances(&whole, &part, &Sampling::DEFAULT);
    // The corner that is missing is half a diagonal away; squared distances over the missing half
    // have a mean of 1/12.
    assert!((d.hausdorff[0] - 0.5_f64.sqrt()).abs() < 1e-6, "{d:?}");
    assert!((d.rms[0] - (1.0_f64 / 24.0).sqrt()).abs() < 1e-3, "{d:?}");
    assert_eq!((d.hausdorff[1], d.rms[1]), (0.0, 0.0));
}

#[test]
fn nothing_is_infinitely_far_from_something() {
    let d = distances(&square(0.0), &Surface::default(), &Sampling::DEFAULT);
    assert!(d.hausdorff[0].is_infinite() && d.hausdorff[1] == 0.0);
}

#[test]
fn the_result_does_not_depend_on_threads() {
    let (a, b) = (sphere(8, 1.0, Vec3::ZERO), sphere(5, 1.0, Vec3::ZERO));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| distances(&a, &b, &Sampling { samples: 5000, lattice: 5000, seed: 3 }))
    };
    assert_eq!(with(1), with(4));
}

#[test]
fn coarser_spheres_look_and_are_worse_in_step() {
    let fine = sphere(48, 1.0, Vec3::ZERO);
    let cameras = Viewing { views: 6, size: 96 }.cameras(&fine);
    let shown = pictures(&fine, &cameras, ShadingOptions::default());
    let mut last = (0.0, 0.0);
    for rows in [24, 12, 6] {
        let coarse = sphere(rows, 1.0, Vec3::ZERO);
        let error =
            compare_pictures(&shown, &pictures(&coarse, &cameras, ShadingOptions::default()));
        let rms = distances(&fine, &coarse, &Sampling::DEFAULT).rms[0];
        assert!(error.rmse > last.0 && rms > last.1, "{rows}: {error:?} {rms}");
        last = (error.rmse, rms);
    }
}

#[test]
fn a_texture_that_slips_is_seen_on_the_checkerboard_only() {
    let a = sphere(16, 1.0, Vec3::ZERO);
    let slipped = Surface {
        texture: a.texture.iter().map(|t| *t + Vec2::new(0.02, 0.0)).collect(),
        ..a.clone()
    };
    let cameras = Viewing { views: 4, size: 64 }.cameras(&a);
    let error = |shading| {
        compare_pictures(&pictures(&a, &cameras, shading), &pictures(&slipped, &cameras, shading))
            .rmse
    };
    assert_eq!(error(ShadingOptions::default()), 0.0);
    assert!(error(ShadingOptions { checkerboard: true, ..ShadingOptions::default() }) > 5.0);
}

#[test]
fn what_is_turned_inside_out_looks_the_same_without_normals_of_its_own() {
    let a = sphere(16, 1.0, Vec3::ZERO);
    let inside = Surface {
        triangles: a.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(),
        ..a.clone()
    };
    let cameras = Viewing { views: 3, size: 64 }.cameras(&a);
    let shading = ShadingOptions::default();
    let error =
        compare_pictures(&pictures(&a, &cameras, shading), &pictures(&inside, &cameras, shading));
    assert!(error.rmse < 1e-3, "{error:?}");
}

/// Vertical stripes of two colours that are equally bright, four texels each.
fn stripes() -> Pyramid {
    let texel = |i: u32| {
        if (i / 4).is_multiple_of(2) { [200, 20, 20, 255] } else { [20, 200, 20, 255] }
    };
    let bytes = (0..64 * 64).flat_map(|i| texel(i % 64)).collect();
    Pyramid::new(&Image { width: 64, height: 64, bytes })
}

#[test]
fn a_texture_that_slips_is_seen_where_it_changes() {
    let striped = |shift: f32| {
        let mut s = sphere(16, 1.0, Vec3::ZERO);
        s.texture.iter_mut().for_each(|t| t.x += shift);
        s.material_of = vec![0; s.triangles.len()];
        let texture = Texture {
            image: 0,
            set: 0,
            transform: Texture::UNTRANSFORMED,
            wrap: [Wrap::Repeat; 2],
            nearest: false,
        };
        s.materials = vec![Material { texture: Some(texture), ..Material::default() }];
        s.images = [stripes()].into();
        s
    };
    let a = striped(0.0);
    let cameras = Viewing { views: 4, size: 128 }.cameras(&a);
    let shading = ShadingOptions { materials: true, ..ShadingOptions::default() };
    let shown = pictures(&a, &cameras, shading);
    let error =
        |b: &Surface, shading| compare_pictures(&shown, &pictures(b, &cameras, shading)).rmse;
    assert_eq!(error(&a, shading), 0.0);
    let (little, more) =
        (error(&striped(1.0 / 64.0), shading), error(&striped(4.0 / 64.0), shading));
    assert!(little > 20.0 && more > 1.5 * little, "{little} {more}");
    // A whole period later it is the same again.
    assert!(error(&striped(8.0 / 64.0), shading) < 0.1);
    assert!(error(&a, ShadingOptions::default()) > 20.0);
}

#[test]
fn textures_are_read_between_texels_and_beyond_their_edges() {
    let two = Image { width: 2, height: 1, bytes: [[0; 4], [255; 4]].concat() };
    let two = Pyramid::new(&two);
    let at = |wrap, x: f32| two.at(Vec2::new(x, 0.5), 0.0, [wrap; 2]).x;
    for (wrap, x, value) in [
        (Wrap::Clamp, 0.25, 0.0),
        (Wrap::Clamp, 0.5, 0.5),
        (Wrap::Clamp, 9.0, 1.0),
        (Wrap::Clamp, -9.0, 0.0),
        (Wrap::Repeat, 0.0, 0.5),
        (Wrap::Repeat, -0.25, 1.0),
        (Wrap::Repeat, 3.25, 0.0),
        (Wrap::Mirror, 1.25, 1.0),
        (Wrap::Mirror, 1.75, 0.0),
        (Wrap::Mirror, -0.25, 0.0),
        (Wrap::Repeat, f32::NAN, 0.5),
    ] {
        assert_eq!(at(wrap, x), value, "{wrap:?} {x}");
    }
    // Far away only the mean is left.
    let far = stripes().at(Vec2::new(0.3, 0.7), 1e9, [Wrap::Repeat; 2]);
    // The mean of light, which is brighter than that of values.
    assert!((far - Vec3::new(147.0, 147.0, 20.0) / 255.0).abs().max_element() < 0.01, "{far}");
    let empty = Pyramid::new(&Image::default());
    assert_eq!(empty.at(Vec2::ZERO, 1.0, [Wrap::Repeat; 2]), Vec3::ONE);
}
