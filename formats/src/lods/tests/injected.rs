//! Defects injected into streams whose checksums are right again, and how each is detected.
//! (Flipped bits are detected by the checksums: `damage.rs`.)

use super::*;
use lodc_fixtures as fixtures;

/// A block of a stream, with its payload.
struct OwnedBlock {
    tag: u32,
    steps: u32,
    payload: Vec<u8>,
}

/// How a defect is detected: the first of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Detection {
    /// The decoder refuses the stream.
    Refused,
    /// The stream does not end.
    Incomplete,
    /// The mesh is another one, which only a comparison shows.
    AnotherMesh,
}
use Detection::{AnotherMesh, Incomplete, Refused};

type Inject = fn(&mut Vec<OwnedBlock>);

/// Block 0 is the head, the last one the end.
const DEFECTS: &[(&str, Detection, Inject)] = &[
    ("no head", Refused, |blocks| drop(blocks.remove(0))),
    ("the head in second place", Refused, |blocks| blocks.swap(0, 1)),
    ("a head that is cut", Refused, |blocks| cut(&mut blocks[0])),
    ("no end", Incomplete, |blocks| drop(blocks.pop())),
    ("a block after the end", Refused, |blocks| again(blocks, 1)),
    ("a step that is lost", Refused, |blocks| drop(blocks.remove(step(blocks)))),
    ("two steps in the other order", Refused, |blocks| {
        let step = step(blocks);
        blocks.swap(step, step + 1);
    }),
    ("a step of an object that is not there", Refused, |blocks| middle(blocks).tag += 1),
    ("a step as the document's", Refused, |blocks| middle(blocks).tag = 0),
    ("one step more", Refused, |blocks| middle(blocks).steps += 1),
    ("one step less", Refused, |blocks| middle(blocks).steps -= 1),
    ("a byte less", Refused, |blocks| cut(middle(blocks))),
    ("a byte more", Refused, |blocks| middle(blocks).payload.push(1)),
    ("another byte", Refused, |blocks| middle(blocks).payload[0] ^= 1),
];

/// The number of a block in the middle that has a step, before another one.
fn step(blocks: &[OwnedBlock]) -> usize {
    let has_step = |&i: &usize| blocks[i].steps > 0 && blocks[i + 1].steps > 0;
    (blocks.len() / 2..blocks.len() - 1).find(has_step).expect("a block to each step")
}

fn middle(blocks: &mut [OwnedBlock]) -> &mut OwnedBlock {
    let step = step(blocks);
    &mut blocks[step]
}

/// Takes off the last byte.
fn cut(block: &mut OwnedBlock) {
    let shorter = block.payload.len() - 1;
    block.payload.truncate(shorter);
}

/// Puts a block at the end, too.
fn again(blocks: &mut Vec<OwnedBlock>, number: usize) {
    let OwnedBlock { tag, steps, ref payload } = blocks[number];
    let payload = payload.clone();
    blocks.push(OwnedBlock { tag, steps, payload });
}

fn detected(bytes: &[u8], whole: &Unpacker) -> Option<Detection> {
    let mut unpacker = Unpacker::new(Limits::DEFAULT);
    if unpacker.feed(bytes).is_err() {
        return Some(Refused);
    } else if !unpacker.is_complete() {
        return Some(Incomplete);
    }
    let mesh = |unpacker: &Unpacker| unpacker.mesh(0).expect("a mesh").0.into_parts();
    let [injected, sound] = [mesh(&unpacker), mesh(whole)];
    let is_same = injected.positions == sound.positions
        && injected.triangles == sound.triangles
        && injected.attributes == sound.attributes;
    (!is_same).then_some(AnotherMesh)
}

#[test]
fn injected_defects_are_detected() {
    let mesh = fixtures::named("machine_part").expect("a shape");
    let file = gltf(vec![object("part", fixtures::random_collapse(&mesh, 3))]);
    let bytes = stepwise(&file).bytes;
    let whole = fed(&bytes);
    let injected = |inject: Inject| {
        let owned = |(_, b): (usize, Block<'_>)| OwnedBlock {
            tag: b.tag,
            steps: b.steps,
            payload: b.payload.to_vec(),
        };
        let mut blocks: Vec<OwnedBlock> = blocks(&bytes).into_iter().map(owned).collect();
        inject(&mut blocks);
        let mut out = bytes[..FILE_HEADER.length].to_vec();
        for (number, OwnedBlock { tag, steps, payload }) in (0..).zip(&blocks) {
            block::put(&mut out, number, Block { tag: *tag, steps: *steps, payload });
        }
        out
    };
    assert_eq!(detected(&injected(|_| {}), &whole), None, "nothing injected");
    let found: Vec<_> = DEFECTS
        .iter()
        .map(|&(name, _, inject)| (name, detected(&injected(inject), &whole)))
        .collect();
    let wanted: Vec<_> = DEFECTS.iter().map(|&(name, by, _)| (name, Some(by))).collect();
    assert_eq!(found, wanted);
}
