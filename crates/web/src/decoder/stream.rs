//! A `.lods` as messages to the page: each holds what has arrived since the last one.

use super::levels::{self, DecodedLevel};
use super::message::{Message, Tag};
use lodc_formats::lods::Unpacker;
use lodc_formats::{FormatError, Limits};
use lodc_progressive::MeshDecoder;
use std::ops::Range;

/// A stream is read in pieces of one part in this many of the bytes before, so that levels are kept
/// however many bytes come at once. Chosen by hand.
const PIECE_SHARE: u64 = 48;
/// Bytes of the smallest piece. Chosen by hand.
const MIN_PIECE: usize = 256;

/// A stream, and what the page already has of it.
#[derive(Debug)]
pub(super) struct StreamReader {
    unpacker: Unpacker,
    objects: Vec<SentObject>,
    document_sent: bool,
    /// Bytes of the document's buffer 0 that were sent.
    buffer_sent: usize,
    /// True if the last message said that the stream is complete.
    end_sent: bool,
}

/// What the page has of an object.
#[derive(Debug, Default)]
struct SentObject {
    /// Number of vertices that were sent, the missing ones among them.
    vertices: u32,
    /// The range from the first to the last of them that had not arrived yet.
    missing: Range<u32>,
    /// Number of indices of all levels that stay.
    final_indices: usize,
    /// Triangles of the last of those levels.
    triangles: u32,
    /// Levels that stay and were not sent yet.
    levels: Vec<DecodedLevel>,
    /// True if its header was sent.
    header_sent: bool,
    /// Steps at the last message.
    steps: u32,
}

impl Default for StreamReader {
    fn default() -> Self {
        Self {
            unpacker: Unpacker::new(Limits::DEFAULT),
            objects: Vec::new(),
            document_sent: false,
            buffer_sent: 0,
            end_sent: false,
        }
    }
}

impl StreamReader {
    /// Takes the next bytes, and keeps a level of each object whenever it has grown enough.
    pub(super) fn feed(&mut self, mut bytes: &[u8]) -> Result<(), FormatError> {
        while !bytes.is_empty() {
            let piece = (self.unpacker.bytes() / PIECE_SHARE) as usize;
            let (piece, rest) = bytes.split_at(piece.max(MIN_PIECE).min(bytes.len()));
            self.unpacker.feed(piece)?;
            bytes = rest;
            self.objects.resize_with(self.unpacker.objects(), SentObject::default);
            for (object, sent) in self.objects.iter_mut().enumerate() {
                sent.keep_level(self.unpacker.decoder(object));
            }
        }
        Ok(())
    }

    /// A message with everything new.
    pub(super) fn message(&mut self) -> Message {
        let mut out = Message::default();
        let Some(document) = self.unpacker.text() else { return out };
        if !std::mem::replace(&mut self.document_sent, true) {
            let objects = self.unpacker.all_objects().unwrap_or_default();
            out.document(document, objects, self.unpacker.buffer_bytes() as u32);
        }
        for (at, piece) in self.unpacker.buffer_pieces(self.buffer_sent) {
            out.chunk(Tag::Buffer, |m| {
                m.word(at as u32);
                m.bytes.extend_from_slice(piece);
            });
            self.buffer_sent += piece.len();
        }
        for (number, sent) in self.objects.iter_mut().enumerate() {
            let (decoder, info) = (self.unpacker.decoder(number), self.unpacker.info(number));
            let header = decoder.header();
            let has_news = decoder.is_complete() || decoder.vertex_count() >= sent.next_vertices();
            let is_empty = header.steps == 0 && self.unpacker.has_header(number);
            if decoder.steps() == sent.steps && !is_empty || !has_news {
                continue;
            }
            if !std::mem::replace(&mut sent.header_sent, true) {
                let counts = [header.vertices, header.triangles];
                let streams = |s: usize| &header.submeshes[s].attributes[..];
                out.object(number as u32, info, counts, &header.attributes, streams);
            }
            if !is_empty {
                sent.send_news(number as u32, decoder, &mut out);
            }
        }
        if self.unpacker.is_complete() && !std::mem::replace(&mut self.end_sent, true) {
            out.chunk(Tag::Complete, |_| ());
        }
        out
    }
}

impl SentObject {
    /// The number of vertices from which on the object is sent again: an eighth more than before.
    /// Lists of indices are sent whole, so this bounds all of them together by a few times the
    /// last.
    fn next_vertices(&self) -> u32 {
        self.vertices + self.vertices / 8
    }

    /// Keeps the present level if it is the next finer one.
    fn keep_level(&mut self, decoder: &MeshDecoder) {
        let triangles = decoder.triangle_count();
        if triangles > 0
            && triangles >= levels::min_finer(self.triangles, decoder.header().triangles)
        {
            self.triangles = triangles;
            self.levels.push(level(decoder));
        }
    }

    /// Appends what has arrived: vertices, then levels, the last of which is the present one.
    fn send_news(&mut self, object: u32, decoder: &MeshDecoder, out: &mut Message) {
        let vertices = decoder.vertex_count();
        self.steps = decoder.steps();
        // All vertices from the first to the last that was missing are sent again.
        let resent = self.missing.clone();
        let missing = (resent.start..vertices).find(|&v| !decoder.has_come(v));
        let behind = (self.missing.start..vertices).rev().find(|&v| !decoder.has_come(v));
        self.missing = missing.unwrap_or(vertices)..behind.map_or(vertices, |v| v + 1);
        for range in [resent, self.vertices..vertices] {
            if !range.is_empty() {
                out.chunk(Tag::Vertices, |m| {
                    m.words([object, range.start, range.end - range.start]);
                    for stream in 0..decoder.header().layout.streams.len() {
                        decoder.put_stream(stream, range.clone(), &mut m.bytes);
                        m.pad();
                    }
                });
            }
        }
        self.vertices = vertices;
        let first = self.final_indices;
        let mut levels = std::mem::take(&mut self.levels);
        self.final_indices += levels.iter().map(|level| level.indices.len()).sum::<usize>();
        if decoder.triangle_count() > self.triangles {
            levels.push(level(decoder));
        }
        levels::put(out, object, first, &levels);
    }
}

fn level(decoder: &MeshDecoder) -> DecodedLevel {
    // Before the first batch is complete its error is not known, and the decoder says 0. The page
    // must not take such a level for one without error.
    let error = match decoder.error() {
        0.0 if !decoder.is_complete() => f32::INFINITY,
        error => error,
    };
    let submesh = |t: [u32; 3]| decoder.vertex_submesh()[t[0] as usize];
    let triangles = (0..decoder.triangle_count()).map(|t| decoder.triangle(t));
    let triangles = triangles.map(|t| (submesh(t), t));
    DecodedLevel::new(error, decoder.header().submeshes.len(), triangles)
}
