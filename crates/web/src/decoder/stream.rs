//! A `.lods` as messages: each holds what has arrived since the last one.

use super::levels::{self, Level};
use super::message::{Message, Tag};
use lodc_formats::lods::Unpacker;
use lodc_formats::{FormatError, Limits};
use lodc_progressive::MeshDecoder;
use std::ops::Range;

/// Bytes of a stream are read in pieces of this share of those before, so that levels are kept
/// however many come at once.
const PIECE_SHARE: u64 = 16;
const LEAST_PIECE: usize = 256;

/// A stream, and what the page already has of it.
#[derive(Debug)]
pub(super) struct Growing {
    unpacker: Unpacker,
    objects: Vec<Told>,
    document: bool,
    buffer: usize,
    complete: bool,
}

/// What the page has of an object.
#[derive(Debug, Default)]
struct Told {
    /// Vertices that it has room for or values of.
    vertices: u32,
    /// Those among them that had not come.
    missing: Range<u32>,
    /// Indices of all levels that stay, and the triangles of the last.
    kept: usize,
    triangles: u32,
    /// Levels that stay and were not told.
    levels: Vec<Level>,
    /// True if its header was told.
    announced: bool,
    /// Steps at the last message.
    steps: u32,
}

impl Default for Growing {
    fn default() -> Self {
        Self {
            unpacker: Unpacker::new(Limits::DEFAULT),
            objects: Vec::new(),
            document: false,
            buffer: 0,
            complete: false,
        }
    }
}

impl Growing {
    /// Takes the next bytes, and keeps a level of each object whenever it has grown enough.
    pub(super) fn feed(&mut self, mut bytes: &[u8]) -> Result<(), FormatError> {
        while !bytes.is_empty() {
            let piece = (self.unpacker.bytes() / PIECE_SHARE) as usize;
            let (piece, rest) = bytes.split_at(piece.max(LEAST_PIECE).min(bytes.len()));
            self.unpacker.feed(piece)?;
            bytes = rest;
            self.objects.resize_with(self.unpacker.objects(), Told::default);
            for (object, told) in self.objects.iter_mut().enumerate() {
                told.keep(self.unpacker.decoder(object));
            }
        }
        Ok(())
    }

    /// A message with everything new.
    pub(super) fn message(&mut self) -> Message {
        let mut out = Message::default();
        let Some(document) = self.unpacker.text() else { return out };
        if !std::mem::replace(&mut self.document, true) {
            let objects = self.unpacker.all_objects().unwrap_or_default();
            out.document(document, objects, self.unpacker.buffer_bytes() as u32);
        }
        for (at, piece) in self.unpacker.buffer_pieces(self.buffer) {
            out.chunk(Tag::Buffer, |m| {
                m.word(at as u32);
                m.bytes.extend_from_slice(piece);
            });
            self.buffer += piece.len();
        }
        for (number, told) in self.objects.iter_mut().enumerate() {
            let (decoder, info) = (self.unpacker.decoder(number), self.unpacker.info(number));
            let header = decoder.header();
            let is_worth = decoder.is_complete() || decoder.vertex_count() >= told.worth();
            let is_empty = header.steps == 0 && self.unpacker.has_header(number);
            if decoder.steps() == told.steps && !is_empty || !is_worth {
                continue;
            }
            if !std::mem::replace(&mut told.announced, true) {
                let counts = [header.vertices, header.triangles];
                let streams = |s: usize| &header.submeshes[s].attributes[..];
                out.object(number as u32, info, counts, &header.attributes, streams);
            }
            if !is_empty {
                told.tell(number as u32, decoder, &mut out);
            }
        }
        if self.unpacker.is_complete() && !std::mem::replace(&mut self.complete, true) {
            out.chunk(Tag::Complete, |_| ());
        }
        out
    }
}

impl Told {
    /// Vertices that make it worth telling: lists of indices are told whole, so that all together
    /// are a few times as long as the last.
    fn worth(&self) -> u32 {
        self.vertices + self.vertices / 8
    }

    /// Keeps the present level if it is the next finer one.
    fn keep(&mut self, decoder: &MeshDecoder) {
        let triangles = decoder.triangle_count();
        if triangles > 0 && triangles >= levels::finer(self.triangles) {
            self.triangles = triangles;
            self.levels.push(level(decoder));
        }
    }

    /// Tells what has come: vertices, then levels, the last of which is the present one.
    fn tell(&mut self, object: u32, decoder: &MeshDecoder, out: &mut Message) {
        let vertices = decoder.vertex_count();
        self.steps = decoder.steps();
        // Of the vertices that were missing those between the first and the last are told again.
        let again = self.missing.clone();
        let missing = (again.start..vertices).find(|&v| !decoder.has_come(v));
        let behind = (self.missing.start..vertices).rev().find(|&v| !decoder.has_come(v));
        self.missing = missing.unwrap_or(vertices)..behind.map_or(vertices, |v| v + 1);
        for range in [again, self.vertices..vertices] {
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
        let first = self.kept;
        let mut levels = std::mem::take(&mut self.levels);
        self.kept += levels.iter().map(|level| level.indices.len()).sum::<usize>();
        if decoder.triangle_count() > self.triangles {
            levels.push(level(decoder));
        }
        levels::put(out, object, first, &levels);
    }
}

fn level(decoder: &MeshDecoder) -> Level {
    // Within the first batch its error has not come yet, and 0 is stated; no level is taken for one
    // without error, then, before all has come.
    let error = match decoder.error() {
        0.0 if !decoder.is_complete() => f32::INFINITY,
        error => error,
    };
    let submesh = |t: [u32; 3]| decoder.vertex_submesh()[t[0] as usize];
    let triangles = (0..decoder.triangle_count()).map(|t| decoder.triangle(t));
    let triangles = triangles.map(|t| (submesh(t), t));
    Level::new(error, decoder.header().submeshes.len(), triangles)
}
