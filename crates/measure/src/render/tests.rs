//! Pictures of a few triangles, judged by what must be where, and one by all its bytes.

use super::{BackFaces, Camera, Corner, Framing, Lens, Painter, Run, Style, Up, Viewpoint};
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

/// The camera that sees the square from the front without perspective.
fn ahead(style: &Style) -> Camera {
    let framing =
        Framing { up: Up::Y, azimuth: 0.0, elevation: 0.0, lens: Lens::Orthographic, zoom: 1.0 };
    let points = [[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]];
    let aspect = f64::from(style.size[0]) / f64::from(style.size[1]);
    Camera::around(&points, &framing, aspect)
}

/// Squares of an unlit material, seen from the front without perspective.
fn draw(style: &Style, material: &Material, images: &[Image], parts: &[Vec<Corner>]) -> Image {
    let material = Material { unlit: true, ..*material };
    let run = |corners: &Vec<Corner>| Run { material: 0, corners: corners.clone() };
    let runs: Vec<Run> = parts.iter().map(run).collect();
    Painter::new(images, vec![material]).draw(&ahead(style), style, &runs)
}

/// The first image, whose texels are seen one by one.
const TEXELS: Texture = Texture {
    image: 0,
    set: 0,
    transform: Texture::UNTRANSFORMED,
    wrap: [Wrap::Clamp; 2],
    nearest: true,
};

#[test]
fn a_square_is_where_it_belongs_and_as_large() {
    let picture = draw(&style(), &PLAIN, &[], &[square(0.0, RED)]);
    assert_eq!((picture.width, picture.height, picture.bytes.len()), (64, 48, 4 * 64 * 48));
    let red = picture.bytes.as_chunks::<4>().0.iter().filter(|p| **p == [255, 0, 0, 255]).count();
    // 92 % of 48 rows, and as many columns; the outermost ones are covered in part.
    assert!((43 * 43..=45 * 45).contains(&red), "{red} pixels");
    assert_eq!((picture.at(32, 24), picture.at(0, 0)), ([255, 0, 0, 255], [0, 0, 255, 255]));
}

#[test]
fn nearer_squares_hide_farther_ones_in_any_order() {
    let (near, far) = (square(0.5, RED), square(-0.5, GREEN));
    for parts in [[near.clone(), far.clone()], [far, near]] {
        assert_eq!(draw(&style(), &PLAIN, &[], &parts).at(32, 24), [255, 0, 0, 255]);
    }
}

#[test]
fn back_faces_follow_their_material_or_the_option() {
    let back = [turned(&square(0.0, RED))];
    for (double_sided, back_faces, shown) in [
        (true, BackFaces::AsMaterial, true),
        (false, BackFaces::AsMaterial, false),
        (false, BackFaces::Shown, true),
        (true, BackFaces::Hidden, false),
    ] {
        let material = Material { double_sided, ..PLAIN };
        let middle = draw(&Style { back_faces, ..style() }, &material, &[], &back).at(32, 24);
        assert_eq!(middle == [255, 0, 0, 255], shown, "{double_sided} {back_faces:?}: {middle:?}");
    }
    let marked = Style { back_faces: BackFaces::Marked, ..style() };
    let front = draw(&marked, &PLAIN, &[], &[square(0.0, GREEN)]).at(32, 24);
    assert_eq!(front, [0, 255, 0, 255]);
    let [r, g, b, _] = draw(&marked, &PLAIN, &[], &back).at(32, 24);
    assert!(r > 200 && g < 80 && b > 100, "{r} {g} {b}");
}

#[test]
fn a_texture_stands_upright_and_keeps_its_colours() {
    // A middle grey survives both ways through linear light; the upper row is red and grey.
    let bytes =
        [[255, 0, 0, 255], [128, 128, 128, 255], [0, 255, 0, 255], [10, 20, 30, 255]].concat();
    let texture = TEXELS;
    let image = Image { width: 2, height: 2, bytes };
    let material = Material { texture: Some(texture), ..PLAIN };
    let picture = draw(&style(), &material, &[image], &[square(0.0, WHITE)]);
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
    let half = [square(0.0, [1.0, 0.0, 0.0, 0.5])];
    let middle = |material: Material, style: &Style| draw(style, &material, &[], &half).at(32, 24);
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
    assert_eq!(draw(&nothing, &blended, &[], &[]).at(32, 24), [0; 4]);
}

#[test]
fn edges_are_drawn_and_the_middle_stays() {
    let style = Style { wire: 1.5, ..style() };
    let picture = draw(&style, &PLAIN, &[], &[square(0.0, WHITE)]);
    assert_eq!(picture.at(24, 16), [255; 4]);
    // The diagonal from the lower left to the upper right.
    let on = picture.at(32, 23);
    assert!(on[0] < 160, "{on:?}");
}

/// A slanted square with a texture, its edges, and half-transparent and masked ones before it, lit
/// and in perspective.
fn everything() -> Image {
    let style = Style { size: [61, 43], wire: 1.0, background: [0.2, 0.4, 0.6, 0.5], ..style() };
    let texture = Texture {
        image: 0,
        set: 0,
        transform: [[3.0, 0.5, 0.1], [-0.4, 2.0, 0.3]],
        wrap: [Wrap::Repeat, Wrap::Mirror],
        nearest: false,
    };
    let bytes = (0..4 * 64).map(|i: u32| (i * i * 7 % 251) as u8).collect();
    let image = Image { width: 8, height: 8, bytes };
    let textured = Material { texture: Some(texture), ..PLAIN };
    let materials = vec![
        textured,
        Material { alpha: AlphaMode::Mask(0.5), ..textured },
        Material { alpha: AlphaMode::Blend, ..PLAIN },
    ];
    let slanted = |z: f32, colour| -> Vec<Corner> {
        let lean = |[x, y, _]: [f32; 3]| [x, y * 0.7 + x * 0.2, z + x];
        let corner = |c: Corner| Corner { position: lean(c.position), ..c };
        square(0.0, colour).into_iter().map(corner).collect()
    };
    let runs = [
        Run { material: 0, corners: slanted(-0.5, WHITE) },
        Run { material: 1, corners: turned(&square(0.3, GREEN)) },
        Run { material: 2, corners: slanted(0.1, [1.0, 0.2, 0.1, 0.4]) },
    ];
    let framing = Framing {
        up: Up::Z,
        azimuth: 20.0,
        elevation: 65.0,
        lens: Lens::Perspective(70.0),
        zoom: 1.1,
    };
    let points: Vec<[f64; 3]> = runs[0].corners.iter().map(|c| c.position.map(f64::from)).collect();
    let camera = Camera::around(&points, &framing, 61.0 / 43.0);
    Painter::new(&[image], materials).draw(&camera, &style, &runs)
}

/// FNV-1a.
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[test]
fn every_machine_and_number_of_threads_gives_the_same_bytes() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(everything)
    };
    let one = run(1);
    assert!(one == run(5));
    let colours: std::collections::BTreeSet<_> = one.bytes.as_chunks::<4>().0.iter().collect();
    assert!(colours.len() > 300, "{} colours", colours.len());
    assert_eq!(hash(&one.bytes), 0x4b93_c08c_6e22_a2c0, "{:#x}", hash(&one.bytes));
}

/// A checkerboard on the ground that runs from behind the eye to the horizon: what is behind is
/// cut away, and squares are where perspective puts them.
#[test]
fn what_is_behind_the_eye_is_cut_away_and_textures_follow_perspective() {
    let texture = TEXELS;
    // The far half of the ground is green, the near half is red.
    let image = Image { width: 1, height: 2, bytes: [[0, 255, 0, 255], [255, 0, 0, 255]].concat() };
    let at = |x: f32, z: f32| Corner {
        position: [x, 0.0, z],
        normal: [0.0, 1.0, 0.0],
        uv: [0.5, (z + 9.0) / 18.0],
        colour: WHITE,
    };
    let (a, b, c, d) = (at(-9.0, 9.0), at(9.0, 9.0), at(9.0, -9.0), at(-9.0, -9.0));
    let ground = Run { material: 0, corners: vec![a, b, c, a, c, d] };
    let points: Vec<[f64; 3]> = ground.corners.iter().map(|c| c.position.map(f64::from)).collect();
    let eye = [0.0, 1.0, 3.0];
    let view = Viewpoint { eye, target: [0.0, 1.0, 0.0], up: Up::Y, degrees: 90.0, zoom: 1.0 };
    let camera = Camera::at(&points, &view, 1.0);
    let style = Style { size: [90, 90], ..style() };
    let unlit = Material { texture: Some(texture), unlit: true, ..PLAIN };
    let picture = Painter::new(&[image], vec![unlit]).draw(&camera, &style, &[ground]);
    let column: Vec<[u8; 4]> = (0..90).map(|y| picture.at(45, y)).collect();
    // The end is 12 ahead and 1 below: at 45 + 45 / 12 rows; the middle is 3 ahead: at 45 + 45 / 3.
    assert!(column[..48].iter().all(|p| *p == [0, 0, 255, 255]));
    assert!(column[50..59].iter().all(|p| *p == [0, 255, 0, 255]), "{:?}", &column[50..59]);
    assert!(column[61..].iter().all(|p| *p == [255, 0, 0, 255]), "{:?}", &column[61..]);
}

#[test]
fn edges_of_a_slanted_square_have_many_shades() {
    let mut corners = square(0.0, WHITE);
    corners.iter_mut().for_each(|c| c.position[1] += c.position[0] * 0.07);
    let picture = draw(&style(), &PLAIN, &[], &[corners]);
    let shades: std::collections::BTreeSet<u8> =
        picture.bytes.as_chunks::<4>().0.iter().map(|p| p[0]).collect();
    assert!(shades.len() >= 14, "{shades:?}");
}

#[test]
fn a_minified_texture_is_averaged_and_no_seam_shows_between_triangles() {
    let texture = Texture {
        image: 0,
        set: 0,
        transform: [[160.0, 0.0, 0.0], [0.0, 160.0, 0.0]],
        wrap: [Wrap::Repeat; 2],
        nearest: false,
    };
    let (black, white) = ([0, 0, 0, 255], [255; 4]);
    let image = Image { width: 2, height: 2, bytes: [black, white, white, black].concat() };
    let material = Material { texture: Some(texture), ..PLAIN };
    let picture = draw(&style(), &material, &[image], &[square(0.0, WHITE)]);
    for (x, y) in (12..52).flat_map(|x| (4..44).map(move |y| (x, y))) {
        let [r, g, b, a] = picture.at(x, y);
        assert!(r.abs_diff(188) <= 3 && r == g && g == b && a == 255, "{x} {y}: {r} {g} {b} {a}");
    }
}

#[test]
fn huge_and_broken_corners_draw_nothing_that_is_not_there() {
    let mut corners = square(0.0, RED);
    corners[0].position[0] = f32::NAN;
    corners[3].position[1] = f32::INFINITY;
    let nothing = draw(&style(), &PLAIN, &[], &[corners]);
    assert!(nothing.bytes.as_chunks::<4>().0.iter().all(|p| *p == [0, 0, 255, 255]));
    // A square so large that its corners are far beyond what the rasteriser can count.
    let mut corners = square(0.0, RED);
    for corner in &mut corners {
        corner.position = corner.position.map(|p| p * 1e9);
    }
    let all = draw(&style(), &PLAIN, &[], &[corners]);
    assert!(all.bytes.as_chunks::<4>().0.iter().all(|p| *p == [255, 0, 0, 255]));
}
