//! Levels on a graphics device: extracted there by one shader and drawn from where they are.
//!
//! ```
//! # let folder = std::env::temp_dir().join("lodc-gpu-door");
//! # std::fs::create_dir_all(&folder)?;
//! # std::fs::copy("../../fixtures/golden/v1/two_parts.lodc", folder.join("part.lodc"))?;
//! # std::env::set_current_dir(&folder)?;
//! # use lodc::gpu::GpuError;
//! # if matches!(lodc::gpu::Device::open(None), Err(GpuError::NoAdapter { .. })) { return Ok(()) }
//! use lodc::gpu::{Device, ResidentObject};
//!
//! let file = lodc::open("part.lodc")?;
//! let device = Device::open(None)?; // an engine has one already: Device::of_host
//! let mut part = ResidentObject::new(&device, &file.objects()[0])?; // instances: part.another()
//! let mut encoder = device.encoder();
//! part.show(&mut encoder, part.within(0.01))?; // near or far, coarser or finer, by one shader
//! device.submit(encoder)?; // and in a render pass: part.draw(&mut pass)
//! # assert!(!part.triangles()?.is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Scenes have several objects, places and materials:
//!
//! ```
//! # let folder = std::env::temp_dir().join("lodc-gpu-scene");
//! # std::fs::create_dir_all(&folder)?;
//! # std::fs::copy("../../fixtures/golden/v1/two_parts.lodc", folder.join("part.lodc"))?;
//! # std::env::set_current_dir(&folder)?;
//! # use lodc::gpu::GpuError;
//! # if matches!(lodc::gpu::Device::open(None), Err(GpuError::NoAdapter { .. })) { return Ok(()) }
//! use lodc::gpu::{Device, ResidentObject};
//!
//! let file = lodc::open("part.lodc")?;
//! let device = Device::open(None)?;
//! let (pixels, height, fovy) = (1.0, 1080.0, 60.0_f64.to_radians());
//! let eye = [0.0, 2.0, 9.0];
//!
//! // Once: each object, an instance for each place that shows it, and the images of materials.
//! let objects = file.objects();
//! let upload = |object| ResidentObject::new(&device, object);
//! let uploaded = objects.iter().map(upload).collect::<Result<Vec<_>, _>>()?;
//! let mut instances = Vec::new();
//! for place in file.placements()? {
//!     instances.push((uploaded[place.object].another()?, place));
//! }
//! let materials = file.materials()?;
//! for material in &materials.list {
//!     println!("{}: {:?}", material.name, material.base_image()); // beside the file or inside
//! }
//!
//! // In every frame: levels by distance, in one submission.
//! let mut encoder = device.encoder();
//! for (instance, place) in &mut instances {
//!     let object = &objects[place.object];
//!     let (mesh, scale) = (object.simplified.mesh(), object.info.world_scale);
//!     let (low, high) = mesh.bounds();
//!     let middle = [0, 1, 2].map(|i| f64::from(low[i] + high[i]) / 2.0);
//!     let middle = place.transform.transform_point3(middle.into());
//!     let distance = middle.distance(eye.into()) - scale * mesh.diagonal() / 2.0;
//!     let error = pixels * 2.0 * (fovy / 2.0).tan() / height * distance.max(0.01); // in the world
//!     instance.show(&mut encoder, instance.within((error / scale) as f32))?;
//! }
//! device.submit(encoder)?;
//!
//! // In a render pass, with pipeline and textures of each material.
//! for (_, place) in &instances {
//!     for (submesh, material) in materials.of_submesh[place.object].iter().enumerate() {
//!         println!("{material:?}: instance.draw_submesh(&mut pass, {submesh})");
//!     }
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Files without models will do: a device needs the collapse sequence alone. [`ResidentObject`]
//! and [`ViewLevels`] own what they need: they can be components of an engine and cross threads.

use crate::{Error, LodObject};
use lodc_lod::interactive::{Move, Resident, ResidentMany, ResidentView};
use lodc_mesh::{CollapseSequence, Lod, Mesh, Simplified};
use std::sync::Arc;

pub use lodc_gpu::{Adapter, CommandEncoder, Device, GpuError, LimitOverrides, RenderPass, wgpu};
pub use lodc_lod::interactive::view::{Criterion, ViewQuery};

/// An object on a device, shown at one level.
pub struct ResidentObject {
    resident: Arc<Resident>,
    simplified: Arc<Simplified>,
    session: lodc_gpu::Session,
    lod: Lod,
}

impl ResidentObject {
    /// Uploads an object with all its attributes, and shows LOD 0.
    ///
    /// # Errors
    /// If it is too large for the device.
    pub fn new(device: &Device, object: &LodObject) -> Result<Self, Error> {
        let simplified = Arc::clone(&object.simplified);
        let resident = Resident::new(&simplified).map_err(|e| Error::Request(e.to_string()))?;
        let mut session = lodc_gpu::Session::new(device, &resident.program)?;
        session.run(&resident.setup)?;
        Ok(Self { resident: Arc::new(resident), simplified, session, lod: Lod(0) })
    }

    /// Another instance of the object, which has a level of its own, at first the same. All
    /// instances share the buffers that never change.
    ///
    /// # Errors
    /// If the device has no room.
    pub fn another(&self) -> Result<Self, Error> {
        Ok(Self {
            resident: Arc::clone(&self.resident),
            simplified: Arc::clone(&self.simplified),
            session: self.session.sharing(&self.resident.instance_buffers)?,
            lod: self.lod,
        })
    }

    /// Shows a LOD, rounded down to a step: near or far, coarser or finer, by two passes at the end
    /// of `encoder`. Passes of an instance have to be submitted in the order of these calls.
    ///
    /// # Errors
    /// If the device fails.
    pub fn show(&mut self, encoder: &mut CommandEncoder, lod: Lod) -> Result<(), Error> {
        let lod = self.collapses().floor(lod);
        if lod != self.lod {
            self.session.encode_passes(encoder, &self.resident.seek(self.lod, lod))?;
            self.lod = lod;
        }
        Ok(())
    }

    /// The LOD that is shown.
    #[must_use]
    pub fn lod(&self) -> Lod {
        self.lod
    }

    /// The coarsest LOD with triangles whose error is at most `error`, in the mesh's units.
    #[must_use]
    pub fn within(&self, error: f32) -> Lod {
        self.collapses().lod_for_error(error).min(self.collapses().last_visible())
    }

    /// The finest LOD with at most `max_triangles` triangles; the last one with any if none has so
    /// few.
    #[must_use]
    pub fn with_triangles(&self, max_triangles: u32) -> Lod {
        self.collapses().lod_for_triangles(max_triangles).min(self.collapses().last_visible())
    }

    /// Draws the level with the pipeline that is set: sets vertex buffer 0, the index buffer, and
    /// draws every submesh. Records are [`stride`] bytes long and begin with a position, three f32;
    /// the object's attributes follow in their order, each at a multiple of four bytes.
    pub fn draw(&self, pass: &mut RenderPass<'_>) {
        self.session.draw(pass, &self.resident.drawn);
    }

    /// Draws one submesh of it, with the pipeline that is set.
    ///
    /// # Panics
    /// If it has fewer submeshes.
    pub fn draw_submesh(&self, pass: &mut RenderPass<'_>, submesh: usize) {
        self.session.draw_one(pass, &self.resident.drawn, submesh);
    }

    /// The corners of all triangles that are drawn, read back: for tests, not for frames.
    ///
    /// # Errors
    /// If the device fails.
    pub fn triangles(&mut self) -> Result<Vec<[[f32; 3]; 3]>, Error> {
        Ok(self.session.drawn_triangles(&self.resident.drawn)?)
    }

    fn collapses(&self) -> &CollapseSequence {
        self.simplified.collapses()
    }
}

/// Many instances of an object on a device, each shown at a level of its own: two passes move all
/// that move in a frame. [`ResidentObject`] takes two for each.
///
/// ```no_run
/// use lodc::gpu::{Crowd, Device};
/// use lodc::mesh::Lod;
///
/// let file = lodc::open("chair.lodc")?;
/// let device = Device::open(None)?;
/// let mut chairs = Crowd::new(&device, &file.objects()[0], 1000)?;
/// let lods: Vec<Lod> = (0..1000).map(|i| Lod(i / 10)).collect(); // by distance
/// let mut encoder = device.encoder();
/// chairs.show(&mut encoder, &lods)?;
/// device.submit(encoder)?; // and in a render pass: chairs.draw(&mut pass, instance)
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Crowd {
    resident: ResidentMany,
    simplified: Arc<Simplified>,
    session: lodc_gpu::Session,
    /// By instance.
    lods: Vec<Lod>,
}

impl Crowd {
    /// Uploads an object with all its attributes, and shows LOD 0 of every instance. Each takes the
    /// memory of the object's vertices, and one word more for each of them.
    ///
    /// # Errors
    /// If the object, or all instances together, are too large for the device.
    pub fn new(device: &Device, object: &LodObject, instances: u32) -> Result<Self, Error> {
        let simplified = Arc::clone(&object.simplified);
        let resident =
            ResidentMany::new(&simplified, instances).map_err(|e| Error::Request(e.to_string()))?;
        let mut session = lodc_gpu::Session::new(device, &resident.program)?;
        let [source, vertices] = resident.repeated;
        session.repeat(source, vertices)?;
        let lods = vec![Lod(0); instances as usize];
        let mut crowd = Self { resident, simplified, session, lods };
        let still = (0..instances).map(|i| Move { instance: i, from: Lod(0), to: Lod(0) });
        let mut encoder = device.encoder();
        crowd.encode(&mut encoder, &still.collect::<Vec<_>>())?;
        device.submit(encoder)?;
        crowd.session.run(&[])?;
        Ok(crowd)
    }

    /// Shows a LOD of every instance, rounded down to a step, by two passes at the end of `encoder`
    /// for all that are not shown at it yet. Encoders have to be submitted in the order of these
    /// calls.
    ///
    /// # Errors
    /// If there is not one LOD for each instance, or the device fails.
    pub fn show(&mut self, encoder: &mut CommandEncoder, lods: &[Lod]) -> Result<(), Error> {
        if lods.len() != self.lods.len() {
            let (given, instances) = (lods.len(), self.lods.len());
            return Err(Error::Request(format!("{given} LODs for {instances} instances")));
        }
        let collapses = self.simplified.collapses();
        let mut moves = Vec::new();
        for (instance, (shown, &wanted)) in (0..).zip(self.lods.iter_mut().zip(lods)) {
            let to = collapses.floor(wanted);
            let from = std::mem::replace(shown, to);
            if from != to {
                moves.push(Move { instance, from, to });
            }
        }
        self.encode(encoder, &moves)
    }

    /// The LOD that each instance is shown at.
    #[must_use]
    pub fn lods(&self) -> &[Lod] {
        &self.lods
    }

    /// Draws an instance, as [`ResidentObject::draw`] does; draws of one crowd after the other
    /// share their buffers.
    pub fn draw(&self, pass: &mut RenderPass<'_>, instance: usize) {
        self.session.draw(pass, &self.resident.drawn(instance));
    }

    /// Draws one submesh of an instance, with the pipeline that is set.
    ///
    /// # Panics
    /// If the object has fewer submeshes.
    pub fn draw_submesh(&self, pass: &mut RenderPass<'_>, instance: usize, submesh: usize) {
        self.session.draw_one(pass, &self.resident.drawn(instance), submesh);
    }

    /// The corners of all triangles of an instance, read back: for tests, not for frames.
    ///
    /// # Errors
    /// If the device fails.
    pub fn triangles(&mut self, instance: usize) -> Result<Vec<[[f32; 3]; 3]>, Error> {
        Ok(self.session.drawn_triangles(&self.resident.drawn(instance))?)
    }

    fn encode(&mut self, encoder: &mut CommandEncoder, moves: &[Move]) -> Result<(), Error> {
        for (table, passes) in self.resident.moves(moves) {
            self.session.encode_words(encoder, self.resident.table, &table);
            self.session.encode_passes(encoder, &passes)?;
        }
        Ok(())
    }
}

/// An object on a device, each part of whose surface has a level of its own, by view.
///
/// ```no_run
/// use lodc::gpu::{Criterion, Device, ViewLevels, ViewQuery};
///
/// let file = lodc::open("terrain.lodc")?;
/// let device = Device::open(None)?;
/// let mut levels = ViewLevels::new(&device, &file.objects()[0])?;
/// let mut encoder = device.encoder();
/// let slope = Criterion::slope(1.0, 1080.0, 30.0_f32.to_radians().tan()); // one pixel of 1,080
/// let criterion = Criterion::ScreenError { eye: [0.0, 2.0, 9.0], slope };
/// levels.show(&mut encoder, &ViewQuery { criterion, morph: false })?;
/// device.submit(encoder)?; // and in a render pass: levels.draw(&mut pass)
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct ViewLevels {
    resident: Arc<ResidentView>,
    session: lodc_gpu::Session,
}

impl ViewLevels {
    /// Uploads an object with all its attributes.
    ///
    /// # Errors
    /// If it is too large for the device.
    pub fn new(device: &Device, object: &LodObject) -> Result<Self, Error> {
        let resident =
            ResidentView::new(&object.simplified).map_err(|e| Error::Request(e.to_string()))?;
        let session = lodc_gpu::Session::new(device, &resident.program)?;
        Ok(Self { resident: Arc::new(resident), session })
    }

    /// Another instance of the object, as [`ResidentObject::another`].
    ///
    /// # Errors
    /// If the device has no room.
    pub fn another(&self) -> Result<Self, Error> {
        let session = self.session.sharing(&self.resident.instance_buffers)?;
        Ok(Self { resident: Arc::clone(&self.resident), session })
    }

    /// Shows what a view asks for, by passes at the end of `encoder`. Before the first call nothing
    /// is drawn.
    ///
    /// # Errors
    /// If the device fails.
    pub fn show(&mut self, encoder: &mut CommandEncoder, view: &ViewQuery) -> Result<(), Error> {
        Ok(self.session.encode_passes(encoder, &self.resident.show(view))?)
    }

    /// Draws it, as [`ResidentObject::draw`] does.
    pub fn draw(&self, pass: &mut RenderPass<'_>) {
        self.session.draw(pass, &self.resident.drawn);
    }

    /// Draws one submesh of it, with the pipeline that is set.
    ///
    /// # Panics
    /// If it has fewer submeshes.
    pub fn draw_submesh(&self, pass: &mut RenderPass<'_>, submesh: usize) {
        self.session.draw_one(pass, &self.resident.drawn, submesh);
    }

    /// The corners of all triangles that are drawn, read back: for tests, not for frames.
    ///
    /// # Errors
    /// If the device fails.
    pub fn triangles(&mut self) -> Result<Vec<[[f32; 3]; 3]>, Error> {
        Ok(self.session.drawn_triangles(&self.resident.drawn)?)
    }
}

/// Bytes from one vertex record of a mesh to the next.
#[must_use]
pub fn stride(mesh: &Mesh) -> u64 {
    offset(mesh, mesh.attributes().len())
}

/// Bytes from the start of a vertex record to the attribute of a number.
#[must_use]
pub fn offset(mesh: &Mesh, attribute: usize) -> u64 {
    let before = mesh.attributes()[..attribute].iter();
    12 + before.map(|a| a.stride().next_multiple_of(4) as u64).sum::<u64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_guide_has_the_scene_of_these_pages() {
        let own = include_str!("gpu.rs").split("//! ```").nth(3).expect("the second example");
        let lines = own.lines().filter(|line| !line.starts_with("//! # "));
        let code: Vec<&str> = lines
            .map(|line| line.trim_start_matches("//!").strip_prefix(' ').unwrap_or(""))
            .collect();
        let page = include_str!("../../../docs/ENGINE.md");
        assert!(page.contains(code.join("\n").trim()), "{}", code.join("\n"));
    }

    #[test]
    fn levels_can_be_components_of_an_engine() {
        const fn component<T: Send + Sync + 'static>() {}
        component::<ResidentObject>();
        component::<ViewLevels>();
        component::<crate::File>();
        component::<Error>();
    }
}
