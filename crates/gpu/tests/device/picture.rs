//! Pictures of a few triangles, judged by what must be where: never by hashes, which differ from
//! driver to driver.

use crate::support::device;
use lodc_gpu::picture::{BackFaces, Camera, Corner, Frame, Framing, Lens, Painter, Style, Up};
use lodc_gpu::{Device, GpuError};
use lodc_scene::{AlphaMode, Coordinates, Image, Material, Texture, Wrap};

const WHITE: [f32; 4] = [1.0; 4];
/// Opaque white, seen from both sides.
const PLAIN: Material = Material {
    colour: WHITE,
    texture: None,
    coordinates: Coordinates::PLAIN,
    double_sided: true,
    alpha: AlphaMode::Opaque,
    unlit: false,
};
const RED: [f32; 4] = [1.0, 0.0, 0.0, 1.0];
const GREEN: [f32; 4] = [0.0, 1.0, 0.0, 1.0];

/// Two triangles that fill the square from -1 to 1 at some depth, texture coordinates from its
/// upper left corner.
fn square(z: f32, colour: [f32; 4]) -> Vec<Corner> {
    let at = |x: f32, y: f32| Corner {
        position: [x, y, z],
        normal: [0.0, 0.0, 1.0],
        uv: [(x + 1.0) / 2.0, (1.0 - y) / 2.0],
        colour,
    };
    let (a, b, c, d) = (at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0));
    vec![a, b, c, a, c, d]
}

fn turned(corners: &[Corner]) -> Vec<Corner> {
    corners.as_chunks::<3>().0.iter().flat_map(|&[a, b, c]| [a, c, b]).collect()
}

fn style() -> Style {
    Style {
        size: [64, 48],
        background: [0.0, 0.0, 1.0, 1.0],
        back_faces: BackFaces::AsMaterial,
        wire: 0.0,
    }
}

/// Squares of an unlit material, seen from the front without perspective.
fn draw(
    device: &Device,
    style: &Style,
    material: &Material,
    images: &[Image],
    parts: &[Vec<Corner>],
) -> Image {
    let material = Material { unlit: true, ..*material };
    let painter =
        Painter::new(device, images, std::slice::from_ref(&material)).expect("small images");
    let framing =
        Framing { up: Up::Y, azimuth: 0.0, elevation: 0.0, lens: Lens::Orthographic, zoom: 1.0 };
    let points = [[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]];
    let aspect = f64::from(style.size[0]) / f64::from(style.size[1]);
    let camera = Camera::around(&points, &framing, aspect);
    let mut frame = Frame::new(&painter, &camera, style).expect("a small picture");
    for part in parts {
        frame.draw(0, material.alpha == AlphaMode::Blend, part).expect("a few triangles");
    }
    frame.finish().expect("pixels")
}

#[test]
fn a_square_is_where_it_belongs_and_as_large() {
    let Some(device) = device() else { return };
    let picture = draw(&device, &style(), &PLAIN, &[], &[square(0.0, RED)]);
    assert_eq!((picture.width, picture.height, picture.bytes.len()), (64, 48, 4 * 64 * 48));
    let red = picture.bytes.as_chunks::<4>().0.iter().filter(|p| **p == [255, 0, 0, 255]).count();
    // 92 % of 48 rows, and as many columns; the outermost ones are covered in part.
    assert!((43 * 43..=45 * 45).contains(&red), "{red} pixels");
    assert_eq!((picture.at(32, 24), picture.at(0, 0)), ([255, 0, 0, 255], [0, 0, 255, 255]));
}

#[test]
fn two_runs_give_the_same_bytes() {
    let Some(device) = device() else { return };
    let slanted: Vec<Corner> = square(0.0, WHITE)
        .into_iter()
        .map(|c| Corner {
            position: [c.position[0], c.position[1] * 0.7 + c.position[0] * 0.2, c.position[0]],
            ..c
        })
        .collect();
    let style = Style { wire: 1.0, ..style() };
    let run = || draw(&device, &style, &PLAIN, &[], std::slice::from_ref(&slanted));
    assert!(run() == run());
}

#[test]
fn nearer_squares_hide_farther_ones_in_any_order() {
    let Some(device) = device() else { return };
    let (near, far) = (square(0.5, RED), square(-0.5, GREEN));
    for parts in [[near.clone(), far.clone()], [far, near]] {
        assert_eq!(draw(&device, &style(), &PLAIN, &[], &parts).at(32, 24), [255, 0, 0, 255]);
    }
}

#[test]
fn back_faces_follow_their_material_or_the_option() {
    let Some(device) = device() else { return };
    let back = [turned(&square(0.0, RED))];
    for (double_sided, back_faces, shown) in [
        (true, BackFaces::AsMaterial, true),
        (false, BackFaces::AsMaterial, false),
        (false, BackFaces::Shown, true),
        (true, BackFaces::Hidden, false),
    ] {
        let material = Material { double_sided, ..PLAIN };
        let middle =
            draw(&device, &Style { back_faces, ..style() }, &material, &[], &back).at(32, 24);
        assert_eq!(middle == [255, 0, 0, 255], shown, "{double_sided} {back_faces:?}: {middle:?}");
    }
    let marked = Style { back_faces: BackFaces::Marked, ..style() };
    let front = draw(&device, &marked, &PLAIN, &[], &[square(0.0, GREEN)]).at(32, 24);
    assert_eq!(front, [0, 255, 0, 255]);
    let [r, g, b, _] = draw(&device, &marked, &PLAIN, &[], &back).at(32, 24);
    assert!(r > 200 && g < 80 && b > 100, "{r} {g} {b}");
}

#[test]
fn a_texture_stands_upright_and_keeps_its_colours() {
    let Some(device) = device() else { return };
    // A middle grey survives both ways through linear light; the upper row is red and grey.
    let bytes =
        [[255, 0, 0, 255], [128, 128, 128, 255], [0, 255, 0, 255], [10, 20, 30, 255]].concat();
    let texture = Texture {
        image: 0,
        set: 0,
        transform: Texture::UNTRANSFORMED,
        wrap: [Wrap::Clamp; 2],
        nearest: true,
    };
    let image = Image { width: 2, height: 2, bytes };
    let material = Material { texture: Some(texture), ..PLAIN };
    let picture = draw(&device, &style(), &material, &[image], &[square(0.0, WHITE)]);
    let near = |[x, y]: [u32; 2], wanted: [u8; 3]| {
        let got = picture.at(x, y);
        assert!(
            (0..3).all(|c| got[c].abs_diff(wanted[c]) <= 1),
            "({x}, {y}): {got:?}, not {wanted:?}"
        );
    };
    near([20, 12], [255, 0, 0]);
    near([44, 12], [128, 128, 128]);
    near([20, 36], [0, 255, 0]);
    near([44, 36], [10, 20, 30]);
}

#[test]
fn opacity_cuts_blends_or_does_not_matter() {
    let Some(device) = device() else { return };
    let half = [square(0.0, [1.0, 0.0, 0.0, 0.5])];
    let middle =
        |material: Material, style: &Style| draw(&device, style, &material, &[], &half).at(32, 24);
    assert_eq!(middle(PLAIN, &style()), [255, 0, 0, 255]);
    assert_eq!(
        middle(Material { alpha: AlphaMode::Mask(0.6), ..PLAIN }, &style()),
        [0, 0, 255, 255]
    );
    assert_eq!(
        middle(Material { alpha: AlphaMode::Mask(0.4), ..PLAIN }, &style()),
        [255, 0, 0, 255]
    );
    let blended = Material { alpha: AlphaMode::Blend, ..PLAIN };
    // Half the light of each: 188 of 255 in sRGB.
    let [r, g, b, a] = middle(blended, &style());
    assert!(r.abs_diff(188) <= 1 && g == 0 && b.abs_diff(188) <= 1 && a == 255, "{r} {g} {b} {a}");
    let nothing = Style { background: [0.0; 4], ..style() };
    let [r, g, b, a] = middle(blended, &nothing);
    assert!(r >= 254 && g == 0 && b == 0 && a.abs_diff(128) <= 1, "{r} {g} {b} {a}");
    assert_eq!(draw(&device, &nothing, &blended, &[], &[]).at(32, 24), [0; 4]);
}

#[test]
fn edges_are_drawn_and_the_middle_stays() {
    let Some(device) = device() else { return };
    let style = Style { wire: 1.5, ..style() };
    let picture = draw(&device, &style, &PLAIN, &[], &[square(0.0, WHITE)]);
    assert_eq!(picture.at(24, 16), [255; 4]);
    // The diagonal from the lower left to the upper right.
    let on = picture.at(32, 23);
    assert!(on[0] < 160, "{on:?}");
}

#[test]
fn a_picture_that_the_device_cannot_hold_is_a_limit() {
    let Some(device) = device() else { return };
    let painter = Painter::new(&device, &[], &[PLAIN]).expect("one material");
    let framing =
        Framing { up: Up::Y, azimuth: 0.0, elevation: 0.0, lens: Lens::Orthographic, zoom: 1.0 };
    let camera = Camera::around(&[], &framing, 1.0);
    let refused = Frame::new(&painter, &camera, &Style { size: [1 << 20, 1], ..style() }).err();
    assert!(matches!(refused, Some(GpuError::Limit { .. })), "{refused:?}");
}
