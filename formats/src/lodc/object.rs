//! One object: its mesh, its collapse sequence and its models as sections.

use super::container::{Container, Writer};
use super::manifest::{self, AttributeEntry, ModelEntry, ObjectEntry};
use super::skipped::{SkippedParts, shortened};
use super::streams::{self, OmittedZeros, Plan, StreamVertices};
use super::table::{Tag, location, tag};
use super::{Bounds, LodObject, StoredModel, arrays, overview, poses, steps};
use crate::fields::Record;
use crate::{Fault, FormatError, ObjectInfo, SubmeshInfo};
use lodc_mesh::{
    Attribute, CollapseSequence, Lod, Mesh, MeshParts, SequenceParts, Simplified, Submesh,
};
use lodc_model::{Array, Layout};
use std::sync::Arc;

/// Bytes of each entry of `VSUB`: enough for the last submesh's number; 0 if there is only one.
fn submesh_width(submeshes: usize) -> usize {
    match submeshes {
        0..=1 => 0,
        2..=0x100 => 1,
        0x101..=0x1_0000 => 2,
        _ => 4,
    }
}

/// Indices of vertices as they are stored, and the bytes of each.
fn take_indices<'a>(
    container: &mut Container<'a>,
    (tag, number): (Tag, u32),
    vertices: usize,
) -> Result<(&'a [u8], usize), FormatError> {
    let section = container.take_section(tag, number, 0)?;
    let layout = if section.wide { Layout::Gpu } else { Layout::Packed };
    Ok((section.bytes, layout.width(vertices)))
}

/// Bytes of the sections that every model needs.
pub(super) fn geometry_bytes(simplified: &Simplified, layout: Layout) -> u64 {
    let (mesh, sequence) = (simplified.mesh(), simplified.collapses().parts());
    let index = layout.width(mesh.vertex_count());
    let vertices = (12 + submesh_width(mesh.submeshes().len())) * mesh.vertex_count();
    let triangles = 3 * index * mesh.triangles().len();
    let records = index * sequence.targets.len() + sequence.targets.len().div_ceil(8);
    let lost = steps::lost_triangles(sequence.triangles, &sequence.step_triangles).len();
    let errors = steps::error_growth(&sequence.step_errors).len();
    let rms = steps::error_growth(&sequence.step_rms).len();
    (vertices + triangles + records + errors + rms + lost) as u64
}

pub(super) fn write<'a>(
    writer: &mut Writer<'a>,
    number: u32,
    simplified: &'a Simplified,
    models: Vec<StoredModel>,
    plan: &'a Plan,
    layout: Layout,
) {
    let (mesh, sequence) = (simplified.mesh(), simplified.collapses().parts());
    writer.for_device(tag::POSITIONS, number, 0, layout, |out| {
        arrays::put_f32s(out, mesh.positions().as_flattened());
    });
    let width = submesh_width(mesh.submeshes().len());
    if width > 0 {
        writer.required(tag::VERTEX_SUBMESH, number, 0, move |out| {
            arrays::put_narrow(out, mesh.vertex_submesh(), width);
        });
    }
    let index = layout.width(mesh.vertex_count());
    writer.for_device(tag::TRIANGLES, number, 0, layout, move |out| {
        arrays::put_narrow(out, mesh.triangles().as_flattened(), index);
    });
    writer.for_device(tag::TARGETS, number, 0, layout, move |out| {
        arrays::put_narrow(out, &sequence.targets, index);
    });
    writer.required(tag::JOINED, number, 0, |out| {
        out.extend(steps::joined(sequence.targets.len(), &sequence.step_ends));
    });
    writer.required(tag::STEP_ERRORS, number, 0, |out| {
        out.extend(steps::error_growth(&sequence.step_errors));
    });
    writer.required(tag::STEP_TRIANGLES, number, 0, |out| {
        out.extend(steps::lost_triangles(sequence.triangles, &sequence.step_triangles));
    });
    if simplified.collapses().is_measured() {
        writer.optional(tag::STEP_RMS, number, 0, |out| {
            out.extend(steps::error_growth(&sequence.step_rms));
        });
    }
    if !simplified.locked().is_empty() {
        writer.optional(tag::LOCKED, number, 0, |out| {
            arrays::put_bits(out, simplified.locked());
        });
    }
    for i in 0..mesh.attributes().len() {
        writer.for_device(tag::ATTRIBUTE, number, i as u32, layout, move |out| {
            streams::put(out, mesh, i, plan, layout);
        });
    }
    for (index, array) in (0..).zip(models.into_iter().flat_map(|model| model.arrays)) {
        writer.array(number, index, array);
    }
}

/// Reads the objects of a file.
pub(super) struct ObjectReader<'r, 'a> {
    pub(super) container: Container<'a>,
    /// Kinds of models that are read; others are skipped.
    pub(super) model_kinds: &'r [&'r str],
    pub(super) zeros: OmittedZeros,
    pub(super) skipped: SkippedParts,
}

impl ObjectReader<'_, '_> {
    /// Reads an object by its number and its entry in the manifest.
    pub(super) fn object(
        &mut self,
        number: u32,
        entry: ObjectEntry,
    ) -> Result<LodObject, FormatError> {
        let wrong = |problem: String| {
            FormatError::new(Fault::Malformed, format!("object {number}"), problem)
        };
        if !(entry.world_scale.is_finite() && entry.world_scale > 0.0) {
            return Err(wrong(format!(
                "is shown at a scale of {}, which is not a number above 0",
                entry.world_scale
            )));
        }
        let mesh = self.mesh(number, &entry)?;
        let collapses = read_sequence(&mut self.container, number, &entry, &mesh)?;
        let mut simplified = Simplified::new(mesh, collapses).map_err(|e| wrong(format!("{e}")))?;
        if let Some(stored) = self.container.take_optional(tag::LOCKED, number, 0) {
            let vertices = simplified.mesh().vertex_count();
            let locked = arrays::bits(stored, vertices, || location(tag::LOCKED, number, 0))?;
            simplified = simplified.with_locked(locked);
        }
        let simplified = Arc::new(simplified);
        if Bounds::of(simplified.mesh().positions()) != entry.bounds {
            return Err(wrong("has other bounds than its vertices".to_owned()));
        }
        if let Some(stored) = self.container.take_optional(tag::LEVELS, number, 0) {
            overview::check_levels(stored, number, &simplified)?;
        }

        let models = self.models(number, entry.models)?;
        let submeshes = entry.submeshes.into_iter().map(|Record(s)| SubmeshInfo {
            name: s.name,
            material: s.material,
            document_primitive: s.document_primitive,
        });
        let poses = self.container.take_optional(tag::POSES, number, 0).unwrap_or_default();
        let info = ObjectInfo {
            name: entry.name,
            submeshes: submeshes.collect(),
            world_scale: entry.world_scale,
            document_mesh: entry.document_mesh,
            poses: poses::get(poses, number)?,
        };
        Ok(LodObject { info, simplified, models })
    }

    /// Reads the models of an object.
    fn models(
        &mut self,
        number: u32,
        entries: Vec<Record<ModelEntry>>,
    ) -> Result<Vec<StoredModel>, FormatError> {
        let Self { container, model_kinds, skipped, .. } = self;
        let mut models: Vec<StoredModel> = Vec::new();
        let mut index = 0;
        for Record(ModelEntry { name, arrays }) in entries {
            let first = index;
            // Each name takes at least a byte of the manifest, which is far smaller than 2^32.
            index += arrays.len() as u32;
            let sections = (first..index).zip(arrays);
            if !model_kinds.contains(&name.as_str()) {
                sections.for_each(|(index, _)| container.skip(tag::MODEL_ARRAY, number, index));
                skipped.add(|| {
                let name = shortened(&name);
                format!(
                    "object {number}: the model \"{name}\" is not in this version and was left out"
                )
            });
                continue;
            }
            if models.iter().any(|m| m.name == name) {
                let problem = format!("the model {name} occurs twice");
                return Err(FormatError::new(
                    Fault::Malformed,
                    format!("object {number}"),
                    problem,
                ));
            }
            let array = |(index, name)| {
                let section = container.take_section(tag::MODEL_ARRAY, number, index)?;
                Ok(Array { name, bytes: section.bytes.to_vec(), wide: section.wide })
            };
            models
                .push(StoredModel { name, arrays: sections.map(array).collect::<Result<_, _>>()? });
        }
        Ok(models)
    }

    /// Reads the mesh of an object.
    fn mesh(&mut self, number: u32, entry: &ObjectEntry) -> Result<Mesh, FormatError> {
        let container = &mut self.container;
        let location = |tag: Tag| move || location(tag, number, 0);
        let positions = arrays::f32_triples(
            container.take(tag::POSITIONS, number, 0)?,
            location(tag::POSITIONS),
        )?;
        let vertex_submesh = match submesh_width(entry.submeshes.len()) {
            0 => vec![0; positions.len()],
            width => {
                let stored = container.take(tag::VERTEX_SUBMESH, number, 0)?;
                arrays::narrow(stored, width, location(tag::VERTEX_SUBMESH))?
            }
        };
        let (stored, width) = take_indices(container, (tag::TRIANGLES, number), positions.len())?;
        let triangles = arrays::narrow_triples(stored, width, location(tag::TRIANGLES))?;
        let mut first = 0u32;
        let mut submeshes = Vec::with_capacity(entry.submeshes.len());
        for s in &entry.submeshes {
            let submesh = Submesh {
                first_triangle: first,
                triangle_count: s.triangles,
                attributes: s.attributes.clone(),
            };
            // A sum that overflows is refused with the mesh: its submeshes do not follow each
            // other.
            first = first.saturating_add(s.triangles);
            submeshes.push(submesh);
        }
        // For each stream the submeshes that have it: to ask each submesh for each stream would
        // take time that grows with their product.
        let mut users = vec![Vec::new(); entry.attributes.len()];
        for (submesh, s) in submeshes.iter().enumerate() {
            for &a in &s.attributes {
                // Streams that are not there are refused with the mesh.
                if let Some(users) = users.get_mut(a as usize) {
                    users.push(submesh);
                }
            }
        }
        let mut has = vec![false; submeshes.len()];
        let mut attributes = Vec::new();
        for ((i, a), users) in (0..).zip(&entry.attributes).zip(&users) {
            users.iter().for_each(|&s| has[s] = true);
            let vertices = StreamVertices { has: &has, vertex_submesh: &vertex_submesh };
            attributes.push(self.stream(number, i, a, &vertices)?);
            users.iter().for_each(|&s| has[s] = false);
        }
        let parts = MeshParts { positions, vertex_submesh, attributes, triangles, submeshes };
        let wrong = |problem: String| {
            FormatError::new(Fault::Malformed, format!("object {number}"), problem)
        };
        Mesh::try_from(parts).map_err(|e| wrong(format!("{e}")))
    }

    /// Reads stream `i` of an object.
    fn stream(
        &mut self,
        number: u32,
        i: u32,
        entry: &AttributeEntry,
        vertices: &StreamVertices<'_>,
    ) -> Result<Attribute, FormatError> {
        let location = || location(tag::ATTRIBUTE, number, i);
        let wrong = |problem: &str| FormatError::new(Fault::Malformed, location(), problem);
        let component = manifest::component(entry.component)
            .ok_or_else(|| wrong("has components of an unknown type"))?;
        if !(1..=16).contains(&entry.components) {
            return Err(wrong("has no, or more than 16, components"));
        }
        let section = self.container.take_section(tag::ATTRIBUTE, number, i)?;
        let mut attribute = Attribute {
            semantic: entry.semantic(),
            morph_target: entry.morph_target,
            component,
            components: entry.components,
            normalized: entry.normalized,
            bytes: Vec::new(),
        };
        let stride = attribute.stride();
        let stored = match section.wide {
            true => &*streams::without_padding(section.bytes, stride, location)?,
            false => section.bytes,
        };
        attribute.bytes = match entry.full {
            // The length is checked with the mesh.
            true => stored.to_vec(),
            false => streams::with_zeros(stored, stride, vertices, &mut self.zeros, location)?,
        };
        Ok(attribute)
    }
}

fn read_sequence(
    container: &mut Container<'_>,
    number: u32,
    entry: &ObjectEntry,
    mesh: &Mesh,
) -> Result<CollapseSequence, FormatError> {
    let wrong = |tag: Tag| {
        move |problem: String| FormatError::new(Fault::Malformed, location(tag, number, 0), problem)
    };
    let (stored, width) = take_indices(container, (tag::TARGETS, number), mesh.vertex_count())?;
    let targets = arrays::narrow(stored, width, || location(tag::TARGETS, number, 0))?;
    let bits = container.take(tag::JOINED, number, 0)?;
    let step_ends = steps::step_ends(bits, targets.len()).map_err(wrong(tag::JOINED))?;
    let stored = container.take(tag::STEP_ERRORS, number, 0)?;
    let step_errors =
        steps::step_errors(stored, step_ends.len()).map_err(wrong(tag::STEP_ERRORS))?;
    // Errors without these are estimates.
    let step_rms = match container.take_optional(tag::STEP_RMS, number, 0) {
        Some(stored) => {
            steps::step_errors(stored, step_ends.len()).map_err(wrong(tag::STEP_RMS))?
        }
        None => vec![],
    };
    let lost = container.take(tag::STEP_TRIANGLES, number, 0)?;
    // A mesh has fewer than 2^30 triangles.
    let triangles = mesh.triangles().len() as u32;
    let step_triangles = steps::step_triangles(lost, step_ends.len(), triangles)
        .map_err(wrong(tag::STEP_TRIANGLES))?;
    CollapseSequence::try_from(SequenceParts {
        targets,
        step_ends,
        step_errors,
        step_rms,
        step_triangles,
        triangles,
        last_legal_lod: Lod(entry.last_legal_lod),
        topology_changes: entry.topology_changes,
        first_topology_change: entry.first_topology_change.map(Lod),
    })
    .map_err(|e| FormatError::new(Fault::Malformed, format!("object {number}"), format!("{e}")))
}
