//! What a reader has received of a stream: the head, the document and one decoder for each object
//! announced.

use super::document::{ParsedText, ReceivedDocument, SequenceFacts};
use super::head::Head;
use crate::gltf::PartialBuffer;
use crate::{Document, Fault, FormatError, Limits, ObjectInfo, SubmeshInfo};
use lodc_progressive::{MeshDecoder, MeshHeader};

/// An object so far.
#[derive(Debug)]
pub(super) struct ReceivedObject {
    pub(super) info: ObjectInfo,
    pub(super) facts: SequenceFacts,
    pub(super) decoder: MeshDecoder,
}

impl AsMut<MeshDecoder> for ReceivedObject {
    fn as_mut(&mut self) -> &mut MeshDecoder {
        &mut self.decoder
    }
}

/// A scene so far.
#[derive(Debug)]
pub(super) struct Received {
    pub(super) head: Head,
    pub(super) document: ReceivedDocument,
    pub(super) objects: Vec<ReceivedObject>,
    /// Number of objects whose header has arrived: the first ones.
    pub(super) announced: usize,
    /// Vertices and triangles that they will have.
    announced_size: [u64; 2],
}

impl Received {
    /// A scene of which the first block has arrived.
    pub(super) fn new(payload: &[u8]) -> Result<Self, FormatError> {
        let (head, document) = (Head::parse(payload)?, ReceivedDocument::default());
        let (objects, announced) = (Vec::new(), 0);
        let mut received = Self { head, document, objects, announced, announced_size: [0; 2] };
        // A document without bytes has no blocks.
        received.read_document(&[])?;
        Ok(received)
    }

    /// Returns whether all that the head announces has come.
    pub(super) fn is_complete(&self) -> bool {
        self.announced == self.head.objects as usize
            && self.document.is_complete(self.head)
            && self.objects.iter().all(|o| o.decoder.is_complete())
    }

    /// Takes the next piece of the document.
    pub(super) fn read_document(&mut self, piece: &[u8]) -> Result<(), FormatError> {
        if self.head.stored > 0 && piece.is_empty() || !self.document.feed(self.head, piece)? {
            return Ok(());
        }
        let parsed = self.document.parsed.take();
        let result = parsed.as_ref().map_or(Ok(()), |parsed| self.name_objects(parsed));
        self.document.parsed = parsed;
        result
    }

    /// Returns whether the header of an object is what comes next of it.
    pub(super) fn awaits_header(&self, object: usize) -> bool {
        object == self.announced && object < self.head.objects as usize
    }

    /// Adds the next object.
    pub(super) fn announce(
        &mut self,
        header: MeshHeader,
        limits: &Limits,
    ) -> Result<(), FormatError> {
        let [vertices, triangles] = &mut self.announced_size;
        *vertices += u64::from(header.vertices);
        *triangles += u64::from(header.triangles);
        if *vertices > limits.vertices || *triangles > limits.triangles {
            let problem = "announces more vertices or triangles than the limit";
            return Err(FormatError::new(Fault::Limit, "objects", problem));
        }
        let submeshes = header.submeshes.len();
        let decoder = MeshDecoder::new(header);
        let number = self.announced;
        self.announced += 1;
        if let Some(object) = self.objects.get_mut(number) {
            check_submeshes(&object.info, submeshes)?;
            object.decoder = decoder;
        } else {
            let info = unnamed(number, submeshes);
            let facts = SequenceFacts::default();
            self.objects.push(ReceivedObject { info, facts, decoder });
        }
        Ok(())
    }

    /// Gives all objects their names, also those that are still to come.
    fn name_objects(&mut self, parsed: &ParsedText) -> Result<(), FormatError> {
        for (number, (info, facts)) in parsed.objects.iter().enumerate() {
            let (info, facts) = (info.clone(), *facts);
            if let Some(object) = self.objects.get_mut(number) {
                check_submeshes(&info, object.decoder.header().submeshes.len())?;
                (object.info, object.facts) = (info, facts);
            } else {
                let decoder = MeshDecoder::new(MeshHeader::unknown(info.submeshes.len()));
                self.objects.push(ReceivedObject { info, facts, decoder });
            }
        }
        Ok(())
    }

    /// The whole document; none while some of it is missing.
    pub(super) fn complete_document(&self) -> Option<&Document> {
        let parsed = self.document.parsed.as_ref()?;
        self.document.is_complete(self.head).then_some(&parsed.document)
    }

    /// The JSON of a glTF and the bytes of its buffer that have arrived; none before its text.
    pub(super) fn partial_gltf(&self) -> Option<(&str, PartialBuffer)> {
        match &self.document.parsed.as_ref()?.document {
            Document::Gltf(gltf) => Some((gltf.json(), self.document.partial_buffer())),
            Document::Obj(_) => None,
        }
    }
}

fn check_submeshes(info: &ObjectInfo, submeshes: usize) -> Result<(), FormatError> {
    if info.submeshes.len() == submeshes {
        return Ok(());
    }
    let problem = "has other submeshes in the document than in its header";
    Err(FormatError::new(Fault::Malformed, format!("object \"{}\"", info.name), problem))
}

/// The description of an object whose name has not come.
fn unnamed(number: usize, submeshes: usize) -> ObjectInfo {
    let submesh = |i| SubmeshInfo { name: String::new(), material: None, document_primitive: i };
    ObjectInfo {
        name: format!("mesh{number}"),
        submeshes: (0..submeshes as u32).map(submesh).collect(),
        world_scale: 1.0,
        document_mesh: number as u32,
        poses: vec![],
    }
}
