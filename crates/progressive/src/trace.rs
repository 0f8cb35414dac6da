//! Traces of every coded value of two small streams, compared with those in `docs/STREAM.md`.

use crate::entropy::adaptive_probability::{AdaptiveBit, AdaptiveSymbol};
use crate::entropy::coder::Coder;
use crate::entropy::decoder::Decoder;
use crate::entropy::integer_codes::{BoundedCode, GammaCode, ResidualCode};
use crate::source::split_source::DecoderSource;
use crate::vertex_data::number_system::NumberSystem;
use crate::vertex_data::values::ValueContexts;
use crate::vertex_data::vertex_layout::VertexLayout;
use crate::vertex_split::contexts::Contexts;
use crate::vertex_split::object_codec::{ObjectCodec, StepLimits};
use crate::vertex_split::point_contexts::PointContexts;
use lodc_mesh::{Attribute, Component, Semantic, take_leb128};
use std::cell::RefCell;
use std::fmt::Write as _;

const TRIANGLE: &[u8] = include_bytes!("../../../fixtures/golden/v1/triangle.lods");
const TWO_PARTS: &[u8] = include_bytes!("../../../fixtures/golden/v1/two_parts.lods");
const PAGE: &str = include_str!("../../../docs/STREAM.md");

/// The name of each context by its address, and how many bytes the contexts take that have one.
#[derive(Default)]
struct Names {
    by_address: Vec<(usize, String)>,
    bytes: usize,
}

impl Names {
    fn add<T>(&mut self, context: &T, name: String) {
        self.by_address.push((std::ptr::from_ref(context) as usize, name));
        self.bytes += size_of::<T>();
    }

    fn symbols(&mut self, contexts: &[AdaptiveSymbol], name: &str) {
        (0..).zip(contexts).for_each(|(i, c): (u32, _)| self.add(c, format!("{name}[{i}]")));
    }

    fn bits(&mut self, contexts: &[AdaptiveBit], name: &str) {
        (0..).zip(contexts).for_each(|(i, c): (u32, _)| self.add(c, format!("{name}[{i}]")));
    }

    fn gamma(&mut self, code: &GammaCode, name: &str) {
        self.add(&code.length_high, format!("{name}.high"));
        self.symbols(&code.length_low, &format!("{name}.low"));
    }

    /// Names every context as docs/STREAM.md does.
    fn of(c: &Contexts) -> Self {
        let mut names = Self::default();
        names.gamma(&c.first_index, "first_index");
        let BoundedCode(parent) = &c.parent;
        names.add(parent, "parent".to_owned());
        names.symbols(&c.wedge_distance, "wedge_distance");
        names.gamma(&c.turns.object, "object");
        names.add(&c.turns.goes_on, "goes_on".to_owned());
        names.gamma(&c.batches.steps, "batch");
        for (i, by_class) in c.batches.splits.iter().enumerate() {
            for (j, by_triangles) in by_class.iter().enumerate() {
                names.bits(by_triangles, &format!("splits[{i}][{j}]"));
            }
        }
        names.add(&c.same_submesh, "same_submesh".to_owned());
        names.add(&c.repeats_target, "repeats_target".to_owned());
        names.add(&c.same_position, "same_position".to_owned());
        for (i, by_number) in c.continues.iter().enumerate() {
            names.bits(by_number, &format!("continues[{i}]"));
        }
        names.add(&c.error_falls, "error_falls".to_owned());
        names.gamma(&c.error_drop, "error_drop");
        names.add(&c.rms_falls, "rms_falls".to_owned());
        names.gamma(&c.rms_drop, "rms_drop");
        names.add(&c.face_list.is_named, "is_named".to_owned());
        names.gamma(&c.face_list.size, "named");
        for (i, by_size) in c.triangles.pattern.iter().enumerate() {
            for (j, by_closed) in by_size.iter().enumerate() {
                names.symbols(by_closed, &format!("pattern[{i}][{j}]"));
            }
        }
        names.symbols(&c.triangles.count, "count");
        names.gamma(&c.triangles.more, "more");
        for (i, by_number) in c.triangles.side.iter().enumerate() {
            for (j, [detached, left]) in by_number.iter().enumerate() {
                names.add(detached, format!("detached[{i}][{j}]"));
                names.add(left, format!("left[{i}][{j}]"));
            }
        }
        names.bits(&c.triangles.in_link, "in_link");
        for (i, by_origin) in c.triangles.place.iter().enumerate() {
            names.symbols(by_origin, &format!("place[{i}]"));
        }
        for (i, by_expected) in c.transfer.transferred.iter().enumerate() {
            names.bits(by_expected, &format!("transferred[{i}]"));
        }
        names.values(&c.values, "");
        names.points(&c.points);
        names
    }

    fn values(&mut self, c: &ValueContexts, prefix: &str) {
        for (i, by_available) in c.source.iter().enumerate() {
            for (j, by_last) in by_available.iter().enumerate() {
                for (k, by_before) in by_last.iter().enumerate() {
                    self.symbols(by_before, &format!("{prefix}source[{i}][{j}][{k}]"));
                }
            }
        }
        for (i, by_number) in c.which.iter().enumerate() {
            self.symbols(by_number, &format!("{prefix}which[{i}]"));
        }
        for (i, by_accuracy) in c.residual.iter().enumerate() {
            for (j, by_bit) in by_accuracy.iter().enumerate() {
                for (k, ResidualCode(context)) in by_bit.iter().enumerate() {
                    let name = format!("{prefix}residual[{}][{}][{j}][{k}]", i / 4, i % 4);
                    self.add(context, name);
                }
            }
        }
    }

    fn points(&mut self, c: &PointContexts) {
        self.gamma(&c.count, "points");
        self.bits(&c.wedge, "point_wedge");
        self.add(&c.continues, "point_continues".to_owned());
        self.add(&c.in_last, "point_in_last".to_owned());
        self.gamma(&c.parent, "point_parent");
        self.gamma(&c.next_parent, "point_next_parent");
        self.add(&c.same_submesh, "point_submesh".to_owned());
        self.values(&c.values, "point_");
    }

    fn name(&self, address: usize) -> &str {
        self.by_address.iter().find(|n| n.0 == address).map_or("unnamed", |n| &n.1)
    }
}

/// A decoder that writes down what it decodes.
struct Tracer<'a> {
    decoder: Decoder<'a>,
    names: &'a Names,
    lines: &'a RefCell<String>,
}

impl Tracer<'_> {
    fn line(&self, what: &str, value: u32) {
        let _ = writeln!(self.lines.borrow_mut(), "  {what:<28} {value}");
    }
}

impl Coder for Tracer<'_> {
    const ENCODES: bool = false;

    fn bit(&mut self, context: &mut AdaptiveBit, bit: bool) -> bool {
        let name = self.names.name(std::ptr::from_ref(context) as usize);
        let bit = self.decoder.bit(context, bit);
        self.line(&format!("bit {name}"), u32::from(bit));
        bit
    }

    fn symbol(&mut self, context: &mut AdaptiveSymbol, value: u32) -> u32 {
        let name = self.names.name(std::ptr::from_ref(context) as usize);
        let symbol = self.decoder.symbol(context, value);
        self.line(&format!("symbol {name}"), symbol);
        symbol
    }

    fn raw(&mut self, bits: u32, value: u32) -> u32 {
        let value = self.decoder.raw(bits, value);
        self.line(&format!("raw({bits})"), value);
        value
    }

    fn uniform(&mut self, end: u32, value: u32) -> u32 {
        let value = self.decoder.uniform(end, value);
        self.line(&format!("uniform({end})"), value);
        value
    }
}

/// The blocks of a stream with one object that hold steps: the number of steps and the payload of
/// each, without the header of the object.
fn step_blocks(stream: &[u8]) -> Vec<(u32, &[u8])> {
    let mut rest = &stream[16..];
    let mut blocks = Vec::new();
    while !rest.is_empty() {
        let mut field = || take_leb128(&mut rest, u64::from(u32::MAX)).expect("a number") as u32;
        let [length, tag, steps] = [field(), field(), field()];
        let (mut payload, more) = rest[6..].split_at(length as usize);
        rest = more;
        if tag > 0 {
            if blocks.is_empty() {
                let mut length = || take_leb128(&mut payload, 1 << 20).expect("a length");
                let (_, stored) = (length(), length());
                payload = &payload[stored as usize..];
            }
            blocks.push((steps, payload));
        }
    }
    blocks
}

/// Every value of a stream of one object.
fn trace(stream: &[u8], layout: VertexLayout, submeshes: u32, vertices: u32) -> String {
    let mut contexts = Box::new(Contexts::new());
    let names = Names::of(&contexts);
    let lines = RefCell::new(String::new());
    let mut codec = ObjectCodec::new(layout, submeshes, false);
    for (steps, payload) in step_blocks(stream) {
        let _ = writeln!(lines.borrow_mut(), "block of {steps} steps");
        let hex: Vec<String> = payload.iter().map(|b| format!("{b:02x}")).collect();
        let _ = writeln!(lines.borrow_mut(), "{}", hex.join(" "));
        let mut tracer = Tracer { decoder: Decoder::new(payload), names: &names, lines: &lines };
        for _ in 0..steps {
            let step = codec.mesh.vertex_count();
            let _ = writeln!(lines.borrow_mut(), "step, from vertex {step} on");
            let limits = StepLimits { vertices, triangles: 0, bytes: stream.len() };
            let coded = codec.code_step(&mut tracer, &DecoderSource, &mut contexts, limits);
            coded.expect("a golden stream");
        }
        assert!(tracer.decoder.is_finished());
    }
    lines.into_inner()
}

#[test]
fn the_page_has_the_traces_of_golden_streams() {
    // What their headers say: three floats in system 1 with no decimals, and in the second stream
    // texture coordinates with one.
    let positions = VertexLayout {
        systems: vec![NumberSystem::Decimal(0); 3],
        streams: VertexLayout::streams(&[], &[]),
    };
    let uv = Attribute {
        semantic: Semantic::TexCoord(0),
        morph_target: None,
        component: Component::F32,
        components: 2,
        normalized: false,
        bytes: Vec::new(),
    };
    let mut with_uv = positions.clone();
    with_uv.systems.extend([NumberSystem::Decimal(1); 2]);
    with_uv.streams = VertexLayout::streams(&[uv], &[]);
    let traces = [trace(TRIANGLE, positions, 1, 3), trace(TWO_PARTS, with_uv, 2, 7)];
    let missing: Vec<_> = traces.into_iter().filter(|trace| !PAGE.contains(trace)).collect();
    assert!(missing.is_empty(), "docs/STREAM.md lacks these traces:\n{}", missing.join("\n"));
}

#[test]
fn every_context_is_named_and_on_the_page() {
    let contexts = Box::new(Contexts::new());
    let names = Names::of(&contexts);
    // The states of value contexts, of vertices and of points, that are no probabilities.
    let states = [&contexts.values, &contexts.points.values].map(|values| {
        size_of_val(values)
            - size_of_val(&values.source)
            - size_of_val(&values.which)
            - size_of_val(&values.residual)
    });
    let all = size_of::<Contexts>() - states.iter().sum::<usize>();
    assert!(names.bytes <= all && all - names.bytes < 16, "{} of {all} bytes", names.bytes);
    for (_, name) in &names.by_address {
        let name = name.split(['[', '.']).next().unwrap_or_default();
        assert!(PAGE.contains(&format!("| `{name}` |")), "docs/STREAM.md has no context {name}");
    }
}
