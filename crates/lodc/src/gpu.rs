//! Levels on a graphics device: extracted there by one shader and drawn from where they are.
//!
//! ```
//! # let folder = std::env::temp_dir().join("lodc-gpu-door");
//! # std::fs::create_dir_all(&folder)?;
//! # std::fs::copy("../../fixtures/golden/v1/two_parts.lodc", folder.join("part.lodc"))?;
//! # std::env::set_current_dir(&folder)?;
//! # use lodc::gpu::GpuError;
//! # if matches!(lodc::gpu::Device::open(None), Err(GpuError::NoAdapter { .. })) { return Ok(()) }
//! use lodc::gpu::{Device, Levels};
//!
//! let file = lodc::open("part.lodc")?;
//! let device = Device::open(None)?; // an engine has one already: Device::of_host
//! let mut levels = Levels::new(&device, &file.objects()[0])?; // levels.another() for instances
//! let mut encoder = device.encoder();
//! levels.show(&mut encoder, levels.within(0.01))?; // near or far, coarser or finer, by one shader
//! device.submit(encoder)?; // and in a render pass: levels.draw(&mut pass)
//! # assert!(!levels.triangles()?.is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Files without models will do: a device needs the collapse sequence alone.

use crate::{Error, LodObject};
use lodc_lod::interactive::{Move, Resident, ResidentMany, ResidentView};
use lodc_mesh::{CollapseSequence, Lod, Mesh, Simplified};
use std::sync::Arc;

pub use lodc_gpu::{Adapter, CommandEncoder, Device, GpuError, LimitOverrides, RenderPass, wgpu};
pub use lodc_lod::interactive::view::{Criterion, ViewQuery};

/// An object on a device, shown at one level.
pub struct Levels {
    resident: Arc<Resident>,
    simplified: Arc<Simplified>,
    session: lodc_gpu::Session,
    lod: Lod,
}

impl Levels {
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
/// that move in a frame. [`Levels`] takes two for each.
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

    /// Draws an instance, as [`Levels::draw`] does; draws of one crowd after the other share their
    /// buffers.
    pub fn draw(&self, pass: &mut RenderPass<'_>, instance: usize) {
        self.session.draw(pass, &self.resident.drawn(instance));
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
pub struct ViewLevels<'a> {
    resident: Arc<ResidentView<'a>>,
    session: lodc_gpu::Session,
}

impl<'a> ViewLevels<'a> {
    /// Uploads an object with all its attributes.
    ///
    /// # Errors
    /// If it is too large for the device.
    pub fn new(device: &Device, object: &'a LodObject) -> Result<Self, Error> {
        let resident =
            ResidentView::new(&object.simplified).map_err(|e| Error::Request(e.to_string()))?;
        let session = lodc_gpu::Session::new(device, &resident.program)?;
        Ok(Self { resident: Arc::new(resident), session })
    }

    /// Another instance of the object, as [`Levels::another`].
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

    /// Draws it, as [`Levels::draw`] does.
    pub fn draw(&self, pass: &mut RenderPass<'_>) {
        self.session.draw(pass, &self.resident.drawn);
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
