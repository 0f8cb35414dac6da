//! Importance that is painted: a vertex attribute or an image says how much distances count where.

use crate::Error;
use lodc_formats::import::ImportOptions;
use lodc_formats::{Assets, Document, FormatError, RequestedFiles, Scene, SceneObject, images};
use lodc_measure::Pyramid;
use lodc_mesh::{Attribute, Semantic, Submesh};
use lodc_scene::Wrap;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Where importance is painted: 0 makes distances count a tenth, 1 ten times, 0.5 as usual. It is
/// the first component (red); values beyond 0 and 1 count as these.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Painted {
    /// Vertex colours (`COLOR_0`) or application-specific data (`_IMPORTANCE`), by their name in a
    /// glTF; the colours of an OBJ or PLY are `COLOR_0`.
    Attribute(String),
    /// A PNG or JPEG, read at the first texture coordinates of the vertices, without transforms of
    /// materials; it repeats. A relative path starts at the current folder or, if there is no such
    /// file, at the scene's.
    Map(PathBuf),
}

/// Importance by object and vertex.
#[derive(Clone, Debug, Default)]
pub struct PaintedValues {
    /// From 0 to 1; the list of an object that nothing is painted on is empty.
    pub of_vertices: Vec<Vec<f32>>,
    /// The files that were looked for.
    pub files: RequestedFiles,
}

/// Importance where nothing is painted.
const USUAL: f32 = 0.5;

impl Painted {
    /// An image if it is called `.png`, `.jpg` or `.jpeg`, else an attribute.
    #[must_use]
    pub fn named(name: &str) -> Self {
        let extension = Path::new(name).extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("png" | "jpg" | "jpeg") => Self::Map(name.into()),
            _ => Self::Attribute(name.to_owned()),
        }
    }

    /// Reads the importance of a scene's vertices; `input` is the scene's file.
    ///
    /// # Errors
    /// If the image cannot be read, no object has such an attribute, or, for an image, texture
    /// coordinates.
    pub fn read(
        &self,
        input: &Path,
        import: &ImportOptions,
        scene: &Scene,
    ) -> Result<PaintedValues, Error> {
        match self {
            Self::Attribute(name) => {
                let of_vertices = of_attribute(scene, &|a| name_of(a).as_deref() == Some(name));
                if of_vertices.iter().any(|list| !list.is_empty()) {
                    return Ok(PaintedValues { of_vertices, files: RequestedFiles::default() });
                }
                Err(Error::Request(format!(
                    "{}: no object has the attribute {name} to take importance from {}",
                    input.display(),
                    names(scene)
                )))
            }
            Self::Map(path) => {
                let path = beside(path, input);
                let (map, files) = Map::read(&path, import)?;
                let of_vertices = map.of_scene(scene);
                if of_vertices.iter().any(|list| !list.is_empty()) {
                    return Ok(PaintedValues { of_vertices, files });
                }
                Err(Error::Request(format!(
                    "{}: no object has texture coordinates to read importance at ({})",
                    input.display(),
                    path.display()
                )))
            }
        }
    }
}

/// The name of an attribute that importance can be taken from.
fn name_of(attribute: &Attribute) -> Option<String> {
    match &attribute.semantic {
        _ if attribute.morph_target.is_some() => None,
        Semantic::Color(set) => Some(format!("COLOR_{set}")),
        Semantic::Custom(name) => Some(name.clone()),
        _ => None,
    }
}

/// The names of a scene's attributes, for a message.
fn names(scene: &Scene) -> String {
    let attributes = scene.objects.iter().flat_map(|o| o.mesh.attributes());
    let names: BTreeSet<String> = attributes.filter_map(name_of).collect();
    if names.is_empty() {
        return "(there is none)".to_owned();
    }
    format!("(there are: {})", names.into_iter().collect::<Vec<_>>().join(", "))
}

/// The file that a relative path means.
fn beside(path: &Path, input: &Path) -> PathBuf {
    match input.parent() {
        Some(folder) if path.is_relative() && !path.exists() => folder.join(path),
        _ => path.to_owned(),
    }
}

/// By object and vertex the first component of the attribute that `is_wanted`; usual in submeshes
/// without it.
fn of_attribute(scene: &Scene, is_wanted: &dyn Fn(&Attribute) -> bool) -> Vec<Vec<f32>> {
    let value = |a: &Attribute, vertex| a.value(vertex, 0);
    scene.objects.iter().map(|object| values(object, is_wanted, &value)).collect()
}

/// By vertex of an object what `value` makes of the attribute that `is_wanted`; an empty list if no
/// submesh has it.
fn values(
    object: &SceneObject,
    is_wanted: &dyn Fn(&Attribute) -> bool,
    value: &dyn Fn(&Attribute, u32) -> f32,
) -> Vec<f32> {
    let mesh = &object.mesh;
    let wanted = |submesh: &Submesh| {
        let mut own = submesh.attributes.iter().map(|&a| &mesh.attributes()[a as usize]);
        own.find(|a| is_wanted(a))
    };
    let of_submesh: Vec<Option<&Attribute>> = mesh.submeshes().iter().map(wanted).collect();
    if of_submesh.iter().all(Option::is_none) {
        return Vec::new();
    }
    let of_vertex = |(vertex, &submesh): (u32, &u32)| {
        of_submesh[submesh as usize].map_or(USUAL, |a| value(a, vertex))
    };
    (0..).zip(mesh.vertex_submesh()).map(of_vertex).collect()
}

/// An image of importance.
struct Map {
    image: Pyramid,
}

impl Map {
    fn read(path: &Path, import: &ImportOptions) -> Result<(Self, RequestedFiles), FormatError> {
        let mut assets = Assets::new(path, &[], import.limits);
        let bytes = assets.read_main()?;
        let image = images::decode(&bytes).map_err(|e| e.in_file(&path.display().to_string()))?;
        Ok((Self { image: Pyramid::new(&image) }, assets.files().clone()))
    }

    fn of_scene(&self, scene: &Scene) -> Vec<Vec<f32>> {
        // Rows of images go down; texture coordinates of a glTF do so, too, others go up.
        let is_upward = matches!(scene.document, Document::Obj(_));
        let is_wanted =
            |a: &Attribute| a.semantic == Semantic::TexCoord(0) && a.morph_target.is_none();
        let value = |a: &Attribute, vertex| {
            let [u, v] = [a.value(vertex, 0), a.value(vertex, 1)];
            let point = [u, if is_upward { 1.0 - v } else { v }];
            self.image.at(point.into(), 1.0, [Wrap::Repeat; 2]).x
        };
        scene.objects.iter().map(|object| values(object, &is_wanted, &value)).collect()
    }
}
