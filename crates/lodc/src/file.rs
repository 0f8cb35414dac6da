//! A file with every level of its objects, and levels taken out of it.

use crate::level_mesh::{self, LevelMesh, MeshOptions, Order};
use crate::{Error, LodFile, LodObject, Select, Source, scene_levels};
use lodc_formats::{Limits, Material, Materials, ObjectInfo};
use lodc_mesh::{Attribute, Component, Lod, Mesh, Semantic};
use lodc_scene::{Arrangement, Placement};
use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// A file with every level of its objects, and the path that images are looked for beside.
#[derive(Debug)]
pub struct File {
    content: LodFile,
    path: PathBuf,
    warnings: Vec<String>,
    materials: OnceLock<Materials>,
}

/// Opens a `.lodc` file, given by its path, its bytes or a reader ([`Source`]).
///
/// ```
/// let file = lodc::open("../../fixtures/golden/v1/two_parts.lodc")?;
/// for object in file.objects() {
///     println!("{}: {} triangles", object.info.name, object.simplified.mesh().triangles().len());
/// }
/// # Ok::<(), lodc::Error>(())
/// ```
///
/// # Errors
/// If it cannot be read, is damaged, or needs a newer program.
pub fn open<'a>(source: impl Into<Source<'a>>) -> Result<File, Error> {
    let source = source.into();
    let path = source.path();
    let name = match source {
        Source::Path(_) => path.display().to_string(),
        _ => String::new(),
    };
    let bytes = source.bytes()?;
    let content = crate::read(&bytes).map_err(|e| e.in_file(&name))?;
    Ok(File::new(content, &path, Vec::new()))
}

impl File {
    pub(crate) fn new(mut content: LodFile, path: &Path, mut warnings: Vec<String>) -> Self {
        warnings.append(&mut content.left_out);
        Self { content, path: path.to_owned(), warnings, materials: OnceLock::new() }
    }

    /// Its objects: meshes in collapse order, sequences and models.
    #[must_use]
    pub fn objects(&self) -> &[LodObject] {
        &self.content.objects
    }

    /// Its materials, of any format: names, base colours, and the images that they show.
    ///
    /// ```
    /// # #[cfg(feature = "build")] {
    /// let file = lodc::build("../../fixtures/machine_part.glb").run()?;
    /// let materials = file.materials()?;
    /// for (object, numbers) in file.objects().iter().zip(&materials.of_submesh) {
    ///     let names = numbers.iter().flatten().map(|&number| &*materials.list[number].name);
    ///     println!("{}: {:?}", object.info.name, names.collect::<Vec<_>>());
    /// }
    /// # }
    /// # Ok::<(), lodc::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub fn materials(&self) -> Result<&Materials, Error> {
        if let Some(known) = self.materials.get() {
            return Ok(known);
        }
        let infos: Vec<&ObjectInfo> = self.objects().iter().map(|o| &o.info).collect();
        let read = lodc_formats::materials(&self.content.document, &infos, &Limits::DEFAULT)?;
        Ok(self.materials.get_or_init(|| read))
    }

    /// Where the default scene shows its objects, at rest; as they were modelled if it shows none.
    ///
    /// ```
    /// # #[cfg(feature = "build")] {
    /// let file = lodc::build("../../fixtures/machine_part.glb").run()?;
    /// for place in file.placements()? {
    ///     println!("object {}: {}", place.object, place.transform.translation);
    /// }
    /// # }
    /// # Ok::<(), lodc::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the stored document is damaged.
    pub fn placements(&self) -> Result<Vec<Placement>, Error> {
        let infos: Vec<&ObjectInfo> = self.objects().iter().map(|o| &o.info).collect();
        let graph = lodc_formats::scene_graph(&self.content.document, &infos, &Limits::DEFAULT)?;
        Ok(Arrangement::new(&graph, &graph.rest_pose(), infos.len()).placements().to_vec())
    }

    /// The path that it came from, beside which images are looked for; `-` if it is none.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Everything in it.
    #[must_use]
    pub fn content(&self) -> &LodFile {
        &self.content
    }

    /// One line for each thing that was repaired, dropped or left out while reading.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Triangles of the input, over all objects.
    #[must_use]
    pub fn triangles(&self) -> usize {
        self.objects().iter().map(|o| o.simplified.mesh().triangles().len()).sum()
    }

    /// Takes out one level of the whole scene; several objects share its triangles or error.
    ///
    /// ```
    /// use lodc::Select;
    ///
    /// let file = lodc::open("../../fixtures/golden/v1/two_parts.lodc")?;
    /// let half = file.level(Select::Ratio(0.5))?;
    /// assert!(2 * half.triangles() <= file.triangles());
    /// let close = file.level(Select::Error(0.01))?;
    /// assert!(close.error() <= 0.01);
    /// # Ok::<(), lodc::Error>(())
    /// ```
    ///
    /// # Errors
    /// If a record number is asked of several objects, or a root mean square distance where none
    /// was measured.
    pub fn level(&self, select: Select) -> Result<Level<'_>, Error> {
        self.materials()?;
        let scene = scene_levels(self.objects(), &self.content.document, &Limits::DEFAULT)?;
        let chosen = scene.select(select)?;
        let shape = MeshOptions { model: None, order: Order::Cache };
        let meshes = level_mesh::meshes(self.objects(), &chosen.lods, shape)?;
        let (error, rms) = level_mesh::largest_of_meshes(self.objects(), &meshes);
        Ok(Level { file: self, lods: chosen.lods, meshes, error, rms, warnings: chosen.warnings })
    }

    /// The bytes of a `.lodc` file.
    ///
    /// ```
    /// let file = lodc::open("../../fixtures/golden/v1/two_parts.lodc")?;
    /// assert_eq!(lodc::open(&file.to_bytes())?.triangles(), file.triangles());
    /// # Ok::<(), lodc::Error>(())
    /// ```
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        crate::write(&self.content)
    }

    /// Writes a `.lodc` file, whole or not at all.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref().to_owned();
        let file = lodc_formats::OutputFile { path, bytes: self.to_bytes() };
        Ok(lodc_formats::write_all(&[file])?)
    }
}

/// One level of detail of a file's objects.
#[derive(Debug)]
pub struct Level<'a> {
    file: &'a File,
    lods: Vec<Lod>,
    meshes: Vec<LevelMesh>,
    error: f64,
    rms: Option<f64>,
    warnings: Vec<String>,
}

impl<'a> Level<'a> {
    /// Triangles of all objects.
    #[must_use]
    pub fn triangles(&self) -> usize {
        self.meshes.iter().map(|m| m.mesh.triangles().len()).sum()
    }

    /// Upper bound of the Hausdorff distance from the input, in world units.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Root mean square distance from the input, in the same units; none if it was not measured.
    #[must_use]
    pub fn rms(&self) -> Option<f64> {
        self.rms
    }

    /// Its objects, in the order of the file. One that is left without triangles is there too.
    pub fn objects(&self) -> impl ExactSizeIterator<Item = LevelObject<'_>> {
        let objects = self.file.objects().iter().zip(&self.meshes).zip(&self.lods);
        objects.enumerate().map(|(number, ((object, level), &lod))| LevelObject {
            file: self.file,
            number,
            object,
            level,
            lod,
        })
    }

    /// One line for each request that could not be met in full.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Writes the level as a mesh file by the extension of its path (.glb, .vrm, .gltf, .obj, .ply,
    /// .stl), with the nodes, materials, skins and animations of the input, as far as the format
    /// has them. Images go into a .glb and beside a .gltf, .obj or .ply; those that cannot be read
    /// are left out, with a line in what is returned.
    ///
    /// ```
    /// # #[cfg(feature = "build")] {
    /// let file = lodc::build("../../fixtures/machine_part.glb").run()?;
    /// let path = std::env::temp_dir().join("lodc-level-write.stl");
    /// for warning in file.level(lodc::Select::Ratio(0.5))?.write(&path)? {
    ///     println!("{warning}");
    /// }
    /// # std::fs::remove_file(path).expect("it was written");
    /// # }
    /// # Ok::<(), lodc::Error>(())
    /// ```
    ///
    /// # Errors
    /// If the extension names no format, the format cannot hold the scene, or the file cannot be
    /// written.
    #[cfg(feature = "export")]
    pub fn write(&self, path: impl AsRef<Path>) -> Result<Vec<String>, Error> {
        use crate::{LevelOf, single};
        use lodc_formats::export::{ExportFormat, ExportOptions};
        use lodc_formats::images::{TextureMode, Textures};
        let path = path.as_ref();
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let mut known = ExportFormat::EXTENSIONS.into_iter();
        let Some((_, format)) = known.find(|(known, _)| *known == extension) else {
            let known = ExportFormat::EXTENSIONS.map(|(known, _)| format!(".{known}")).join(", ");
            let what = format!("the extension names no known format: {known}");
            return Err(Error::Request(format!("{}: {what}", path.display())));
        };
        let mode = match format {
            ExportFormat::Glb => Some(TextureMode::Embed),
            ExportFormat::Gltf | ExportFormat::Obj | ExportFormat::Ply => Some(TextureMode::Copy),
            ExportFormat::Stl => None,
        };
        let content = &self.file.content;
        let mut options = ExportOptions::default();
        let mut warnings = Vec::new();
        if let Some(mode) = mode {
            let mut assets = lodc_formats::Assets::new(&self.file.path, &[], Limits::DEFAULT);
            let mut textures = Textures::read(&content.document, &mut assets)?;
            if matches!(format, ExportFormat::Obj | ExportFormat::Ply) {
                textures.add_embedded(&content.document)?;
            }
            warnings.append(&mut textures.warnings);
            options.textures = textures.placed(mode, path);
            warnings.extend_from_slice(&options.textures.warnings);
        }
        let level = LevelOf {
            objects: &content.objects,
            document: &content.document,
            source: content.source.content_hash,
            lod: single(&self.lods),
        };
        let made = level.files(&self.meshes, path, format, &mut options)?;
        warnings.extend(made.left_out);
        warnings.extend(made.warnings);
        lodc_formats::write_all(&made.files)?;
        Ok(warnings)
    }
}

/// One object at one level of detail.
#[derive(Clone, Copy, Debug)]
pub struct LevelObject<'a> {
    file: &'a File,
    number: usize,
    object: &'a LodObject,
    level: &'a LevelMesh,
    lod: Lod,
}

impl<'a> LevelObject<'a> {
    /// Its name in the input.
    #[must_use]
    pub fn name(&self) -> &'a str {
        &self.object.info.name
    }

    /// Records that were applied: 0 is the input.
    #[must_use]
    pub fn lod(&self) -> u32 {
        self.lod.0
    }

    /// Upper bound of the distance from the input, in the mesh's units: times
    /// [`ObjectInfo::world_scale`](lodc_formats::ObjectInfo::world_scale) it is one in world units.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.level.error
    }

    /// The mesh itself, with its submeshes.
    #[must_use]
    pub fn mesh(&self) -> &'a Mesh {
        &self.level.mesh
    }

    /// Positions of its vertices.
    #[must_use]
    pub fn positions(&self) -> &'a [[f32; 3]] {
        self.mesh().positions()
    }

    /// Its triangles as indices of vertices, sorted by submesh.
    #[must_use]
    pub fn indices(&self) -> &'a [[u32; 3]] {
        self.mesh().triangles()
    }

    /// The other attributes of its vertices.
    #[must_use]
    pub fn attributes(&self) -> &'a [Attribute] {
        self.mesh().attributes()
    }

    /// The `N` numbers that each vertex has of an attribute: the attribute itself where it is of
    /// floats, else its values, fractions of integers included. None if there is no such attribute,
    /// or it has another number of components. Differences of morph targets are left out.
    ///
    /// ```
    /// # #[cfg(feature = "build")] {
    /// use lodc::{Select, mesh::Semantic};
    ///
    /// let file = lodc::build("../../fixtures/machine_part.glb").run()?;
    /// let level = file.level(Select::Ratio(0.5))?;
    /// for part in level.objects() {
    ///     let normals = part.floats::<3>(&Semantic::Normal).expect("it has normals");
    ///     assert_eq!(normals.len(), part.positions().len());
    ///     assert_eq!(part.floats::<2>(&Semantic::Normal), None);
    /// }
    /// # }
    /// # Ok::<(), lodc::Error>(())
    /// ```
    #[must_use]
    pub fn floats<const N: usize>(&self, semantic: &Semantic) -> Option<Cow<'a, [[f32; N]]>> {
        let is_it = |a: &&Attribute| a.semantic == *semantic && a.morph_target.is_none();
        let attribute = self.attributes().iter().find(is_it)?;
        let is_stored = attribute.component == Component::F32
            && usize::from(attribute.components) == N
            && cfg!(target_endian = "little");
        // Bytes may lie where no float can.
        match bytemuck::try_cast_slice(&attribute.bytes) {
            Ok(floats) if is_stored => Some(Cow::Borrowed(floats.as_chunks().0)),
            _ => attribute.floats().map(Cow::Owned),
        }
    }

    /// The material of each submesh, if the input has one for it.
    ///
    /// # Panics
    /// Never: the file has read them with the level.
    pub fn materials(&self) -> impl ExactSizeIterator<Item = Option<&'a Material>> + use<'a> {
        let all = self.file.materials.get().expect("they are read with the level");
        all.of_submesh[self.number].iter().map(|number| number.map(|i| &all.list[i]))
    }
}
