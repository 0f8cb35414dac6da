//! Refitted levels: closer in space, and held back where pictures would get worse.

use lodc_formats::lodc::LodObject;
use lodc_measure::{
    Looks, Sampling, SceneSurface, Surface, Viewing, compare_pictures, distances, pictures,
};
use lodc_mesh::{Lod, Mesh};
use lodc_refit::{Options, Refit};
use lodc_scene::{Appearance, Arrangement, Graph, Pose};

/// Pictures that decide whether attributes look right.
const VIEWING: Viewing = Viewing { views: 12, size: 256 };
/// Shares of the way to the best fit, the first that looks right counts.
const SHARES: [f64; 2] = [1.0, 0.5];
/// Most that the image error may grow, as a share and in addition (of 255).
const WORSE: f64 = 1.005;
const NOTHING: f64 = 0.02;

/// A refitted level, its error and its root mean square distance. These are measured: the stored
/// ones are of the vertices where they were.
pub(crate) fn refitted(object: &LodObject, lod: Lod, looks: &Appearance) -> (Mesh, f64, f64) {
    let original = object.simplified.mesh();
    let found = Refit::new(&object.simplified, lod, &Options::DEFAULT);
    if lod.0 == 0 {
        return (found.mesh(0.0), 0.0, 0.0);
    }
    let mesh = if original.attributes().is_empty() {
        found.mesh(1.0)
    } else {
        that_looks_right(original, &found, looks)
    };
    let measured = distances(&bare(original), &bare(&mesh), &Sampling::DEFAULT);
    let larger = |[a, b]: [f64; 2]| a.max(b);
    (mesh, larger(measured.hausdorff), larger(measured.rms))
}

/// Returns the level as far refitted as it looks no worse than where the simplifier left it.
fn that_looks_right(original: &Mesh, found: &Refit<'_>, looks: &Appearance) -> Mesh {
    let mut whole = surface(original, looks);
    let cameras = VIEWING.cameras(&whole.surface);
    let worn = Looks {
        own_normals: !whole.surface.normals.is_empty(),
        checkerboard: whole.all_textured && whole.surface.materials.is_empty(),
        materials: !whole.surface.materials.is_empty(),
    };
    let wanted = pictures(&whole.surface, &cameras, worn);
    let images = std::mem::take(&mut whole.surface.images);
    drop(whole);
    let without_images = Appearance { images: vec![], ..looks.clone() };
    let mut images = Some(images);
    let mut error = |mesh: &Mesh| {
        let mut level = surface(mesh, &without_images).surface;
        level.images = images.take().unwrap_or_default();
        let error = compare_pictures(&wanted, &pictures(&level, &cameras, worn)).rmse;
        images = Some(level.images);
        error
    };
    let unmoved = found.mesh(0.0);
    let most = WORSE * error(&unmoved) + NOTHING;
    SHARES
        .into_iter()
        .map(|share| found.mesh(share))
        .find(|mesh| error(mesh) <= most)
        .unwrap_or(unmoved)
}

/// An object as it was modelled, with its looks.
fn surface(mesh: &Mesh, looks: &Appearance) -> SceneSurface {
    SceneSurface::new(&[mesh], &Arrangement::new(&Graph::default(), &Pose::default(), 1), looks)
}

fn bare(mesh: &Mesh) -> Surface {
    Surface {
        positions: mesh.positions().iter().map(|&p| p.into()).collect(),
        triangles: mesh.triangles().to_vec(),
        ..Surface::default()
    }
}

/// The looks of one object of a scene, with the images that it shows.
pub(crate) fn of_object(looks: &Appearance, object: usize) -> Appearance {
    let Some(of_submesh) = looks.of_submesh.get(object) else { return Appearance::default() };
    let mut own = Appearance { of_submesh: vec![of_submesh.clone()], ..Appearance::default() };
    let mut number = vec![None; looks.images.len()];
    for (m, mut material) in looks.materials.iter().copied().enumerate() {
        // What other objects wear is nothing here.
        material.texture =
            material.texture.filter(|_| of_submesh.contains(&m)).map(|mut texture| {
                texture.image = *number[texture.image].get_or_insert_with(|| {
                    own.images.push(looks.images[texture.image].clone());
                    own.images.len() - 1
                });
                texture
            });
        own.materials.push(material);
    }
    own
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image_error(original: &Mesh, level: &Mesh) -> f64 {
        let [original, level] = [original, level].map(|m| surface(m, &Appearance::default()));
        let cameras = VIEWING.cameras(&original.surface);
        let worn = Looks {
            own_normals: !original.surface.normals.is_empty(),
            checkerboard: original.all_textured,
            materials: false,
        };
        let shown = [original, level].map(|s| pictures(&s.surface, &cameras, worn));
        compare_pictures(&shown[0], &shown[1]).rmse
    }

    #[test]
    fn no_level_looks_worse_than_where_the_simplifier_left_it() {
        let (mut moved, mut held) = (0, 0);
        for (name, make) in lodc_fixtures::ALL {
            let mesh = make();
            if mesh.attributes().is_empty() || mesh.triangles().len() < 100 {
                continue;
            }
            let options = lodc_simplify::Options::DEFAULT;
            let simplified = lodc_simplify::simplify(&mesh, &options, &|_, _| {});
            let lod = simplified.collapses().lod_for_triangles(mesh.triangles().len() as u32 / 4);
            let found = Refit::new(&simplified, lod, &Options::DEFAULT);
            let level = that_looks_right(simplified.mesh(), &found, &Appearance::default());
            let before = image_error(simplified.mesh(), &found.mesh(0.0));
            let after = image_error(simplified.mesh(), &level);
            assert!(after <= WORSE * before + NOTHING, "{name}: {before} {after}");
            moved += u32::from(level != found.mesh(0.0));
            held += u32::from(level != found.mesh(1.0));
        }
        assert!(moved > 0 && held > 0, "{moved} moved, {held} held back");
    }
}
