//! A scene as one surface, with the colours and pictures it shows.

use super::CompareArgs;
use crate::console;
use crate::exit::{Failure, Outcome, Status};
use crate::paints::Paints;
use lodc_formats::appearance::{Appearance, appearance};
use lodc_formats::export::flat_mesh;
use lodc_formats::{Assets, ObjectInfo, import};
use lodc_measure::Surface;
use std::path::Path;

/// What is compared.
pub(super) struct Shown {
    pub(super) surface: Surface,
    /// Whether all of it has texture coordinates.
    pub(super) all_textured: bool,
}

/// Reads a mesh as it stands in its scene.
pub(super) fn surface(path: &Path, args: &CompareArgs) -> Outcome<Shown> {
    let options = args.import.options();
    let scene = import::import(path, &options)?;
    let name = path.display().to_string();
    for warning in &scene.warnings {
        console::warning(&name, warning);
    }
    let looks = if args.no_attributes || args.views == 0 {
        Appearance::default()
    } else {
        let infos: Vec<&ObjectInfo> = scene.objects.iter().map(|o| &o.info).collect();
        let mut assets = Assets::new(path, &options.allowed, options.limits);
        appearance(&scene.document, &infos, &mut assets).map_err(|e| e.in_file(&name))?
    };
    for warning in &looks.warnings {
        console::warning(&name, warning);
    }
    let material =
        |object: usize, submesh: usize| looks.of_submesh.get(object)?.get(submesh).copied();
    let texture =
        |object: usize, submesh: usize| looks.materials[material(object, submesh)?].texture;
    let flat = flat_mesh(&scene, &|o, s| texture(o, s).map_or(0, |t| t.set))
        .map_err(|e| e.in_file(&name))?;
    if flat.triangles.is_empty() {
        return Err(Failure::new(
            Status::Input,
            format!("{name}: has no triangles: there is nothing to compare"),
        ));
    }
    let vectors = |all: Vec<[f32; 3]>| all.into_iter().map(Into::into).collect();
    let mut surface = Surface {
        positions: vectors(flat.positions),
        triangles: flat.triangles,
        normals: vectors(flat.normals),
        texture: flat.texture.into_iter().map(Into::into).collect(),
        ..Surface::default()
    };
    if looks.materials.iter().any(|m| m.texture.is_some()) && !surface.texture.is_empty() {
        paint(&mut surface, &flat.submesh_of, &looks);
    }
    Ok(Shown { surface, all_textured: flat.all_textured })
}

/// Gives every triangle the paint of its submesh, and every vertex the place in its picture.
fn paint(surface: &mut Surface, submesh_of: &[[u32; 2]], looks: &Appearance) {
    let material = |[o, s]: [u32; 2]| looks.of_submesh[o as usize][s as usize];
    let Paints { paints, textures, .. } = Paints::new(looks);
    (surface.paints, surface.textures) = (paints, textures);
    let mut placed = vec![false; surface.positions.len()];
    for (triangle, &submesh) in surface.triangles.iter().zip(submesh_of) {
        let material = material(submesh);
        surface.paint_of.push(material as u32);
        let Some(texture) = looks.materials[material].texture else { continue };
        // A vertex belongs to one submesh, so to one material.
        for &v in triangle {
            if !std::mem::replace(&mut placed[v as usize], true) {
                let at = surface.texture[v as usize];
                surface.texture[v as usize] =
                    texture.transform.map(|[x, y, shift]| x * at.x + y * at.y + shift).into();
            }
        }
    }
}
