//! A file of the gpu layout: sections are uploaded as they lie there, the rest says which LODs
//! there are.

use lodc_formats::FormatError;
use lodc_formats::lodc::{LodFile, Section, read, sections};
use lodc_mesh::{CollapseSequence, Mesh, Simplified};
use std::error::Error;

/// The first object of a file.
pub(crate) struct Mapped<'a> {
    file: LodFile,
    sections: Vec<Section<'a>>,
}

impl<'a> Mapped<'a> {
    /// Reads a file, and finds the sections in its bytes.
    pub(crate) fn read(bytes: &'a [u8]) -> Result<Self, Box<dyn Error>> {
        let (file, sections): (_, Result<_, FormatError>) = (read(bytes, &[])?, sections(bytes));
        let mapped = Self { file, sections: sections? };
        if mapped.file.objects.is_empty() {
            return Err("the file has no object".into());
        }
        if !mapped.section(b"TRIS").is_some_and(|triangles| triangles.wide) {
            return Err("the file is not of the gpu layout: build it with --layout gpu".into());
        }
        Ok(mapped)
    }

    fn section(&self, tag: &[u8; 4]) -> Option<&Section<'a>> {
        self.sections.iter().find(|s| (s.tag, s.object, s.index) == (*tag, Some(0), 0))
    }

    /// The bytes of a section, to be uploaded.
    pub(crate) fn bytes(&self, tag: &[u8; 4]) -> &'a [u8] {
        self.section(tag).expect("a file that was read has it").bytes
    }

    pub(crate) fn simplified(&self) -> &Simplified {
        &self.file.objects[0].simplified
    }

    pub(crate) fn mesh(&self) -> &Mesh {
        self.simplified().mesh()
    }

    pub(crate) fn collapses(&self) -> &CollapseSequence {
        self.simplified().collapses()
    }

    /// First triangle and number of triangles of each submesh.
    pub(crate) fn ranges(&self) -> Vec<u32> {
        let submeshes = self.mesh().submeshes().iter();
        submeshes.flat_map(|s| [s.first_triangle, s.triangle_count]).collect()
    }

    /// The finest LOD with at most that share of the triangles: always the end of a step.
    pub(crate) fn lod_for(&self, share: f64) -> u32 {
        let most = share * f64::from(self.collapses().parts().triangles);
        self.collapses().lod_for_triangles(most as u32).0
    }
}
