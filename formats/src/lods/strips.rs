//! Strips while the mesh grows: all live triangles in the order of drawing, cut into strips.
//!
//! A strip is a sequence of triangles. At any time its live ones, in its order, are what is drawn
//! of it; at the end that is the strip itself. So all that a new triangle brings is its place in
//! this order (the thesis's StripPackage sends masks over full strips instead, most of whose
//! positions show nothing yet).

use super::Broken;
use super::chances::Bit;
use super::coder::Coder;
use super::growth::{Growth, NONE};
use super::script::{Place, Script};
use lodc_strip::StripSet;

/// The order of drawing.
#[derive(Clone, Debug, Default)]
pub(super) struct Order {
    /// The triangle drawn after each, and before each.
    next: Vec<u32>,
    previous: Vec<u32>,
    /// The strip of each triangle, by order of arrival.
    strip: Vec<u32>,
    /// The first and the last triangle of each strip.
    ends: Vec<[u32; 2]>,
    /// The triangle drawn first.
    first: u32,
}

/// What is known about places.
#[derive(Clone, Debug)]
pub(super) struct PlaceModels {
    between: [Bit; 3],
    /// By neighbour, side, whether the strip goes on there, and whether the other neighbour is in
    /// that strip.
    beside: [[[[Bit; 2]; 2]; 2]; 3],
    new: [Bit; 4],
    strip: [[Bit; 2]; 3],
    side: Bit,
}

impl PlaceModels {
    pub(super) const NEW: Self = Self {
        between: [Bit::NEW; 3],
        beside: [[[[Bit::NEW; 2]; 2]; 2]; 3],
        new: [Bit::NEW; 4],
        strip: [[Bit::NEW; 2]; 3],
        side: Bit::NEW,
    };
}

impl Order {
    pub(super) fn new() -> Self {
        Self { first: NONE, ..Self::default() }
    }

    /// The strip of a triangle.
    pub(super) fn strip(&self, face: u32) -> u32 {
        self.strip[face as usize]
    }

    pub(super) fn strips(&self) -> u32 {
        self.ends.len() as u32
    }

    fn next_of(&self, face: u32) -> u32 {
        if face == NONE { self.first } else { self.next[face as usize] }
    }

    fn same(&self, a: u32, b: u32) -> bool {
        a != NONE && b != NONE && self.strip(a) == self.strip(b)
    }

    /// Says where a new triangle stands, and puts it there. `around` are up to three neighbours.
    /// Returns whether these were not enough to say it.
    pub(super) fn place<C: Coder, S: Script>(
        &mut self,
        coder: &mut C,
        script: &S,
        models: &mut PlaceModels,
        around: [u32; 3],
    ) -> Result<bool, Broken> {
        let face = self.next.len() as u32;
        let wanted = if C::WRITES {
            script.place(face, self.strips(), &|f| self.strip(f))
        } else {
            Place { after: NONE, strip: 0 }
        };
        let (place, explicit) = self.say(coder, models, around, wanted)?;
        self.insert(place);
        Ok(explicit)
    }

    fn say<C: Coder>(
        &self,
        coder: &mut C,
        models: &mut PlaceModels,
        around: [u32; 3],
        wanted: Place,
    ) -> Result<(Place, bool), Broken> {
        let [a, b, _] = around;
        // Two neighbours drawn one after the other: mostly the new triangle comes between them.
        let linked = if self.same(a, b) && self.next[a as usize] == b {
            Some(a)
        } else if self.same(a, b) && self.next[b as usize] == a {
            Some(b)
        } else {
            None
        };
        let mut tried = NONE;
        if let Some(after) = linked {
            let place = Place { after, strip: self.strip(after) };
            if coder.bit(&mut models.between[0], wanted == place) {
                return Ok((place, false));
            }
            tried = after;
        }
        for (i, &f) in around.iter().enumerate().filter(|(_, f)| **f != NONE) {
            for (side, after) in [f, self.previous[f as usize]].into_iter().enumerate() {
                let place = Place { after, strip: self.strip(f) };
                let before = self.next_of(after);
                let inside = self.same(after, before);
                if inside && tried == after {
                    continue;
                }
                let other = around.iter().any(|&g| g != f && self.same(f, g));
                let model = &mut models.beside[i][side][usize::from(inside)][usize::from(other)];
                if coder.bit(model, wanted == place) {
                    return Ok((place, false));
                }
            }
        }
        let context = usize::from(around[0] != NONE)
            + usize::from(around[1] != NONE)
            + usize::from(around[2] != NONE);
        if coder.bit(&mut models.new[context], wanted.strip == self.strips()) {
            let (after, explicit) = self.new_strip(coder, models, around, wanted.after);
            return Ok((Place { after, strip: self.strips() }, explicit));
        }
        if self.next.is_empty() {
            return Err(Broken("has a triangle that joins no strip"));
        }
        let after =
            coder.uniform(self.next.len() as u32 + 1, wanted.after.wrapping_add(1)).wrapping_sub(1);
        let before = self.next_of(after);
        if self.same(after, before) {
            return Ok((Place { after, strip: self.strip(after) }, true));
        }
        // At the end of one strip or the beginning of the next.
        let choices = [after, before].map(|f| if f == NONE { NONE } else { self.strip(f) });
        let second = coder.bit(&mut models.side, wanted.strip == choices[1]);
        match choices[usize::from(second)] {
            NONE => Err(Broken("has a triangle that joins a strip that is not there")),
            strip => Ok((Place { after, strip }, true)),
        }
    }

    /// The triangle after which a new strip begins: the last of another strip, or none. And whether
    /// it had to be named.
    fn new_strip<C: Coder>(
        &self,
        coder: &mut C,
        models: &mut PlaceModels,
        around: [u32; 3],
        wanted: u32,
    ) -> (u32, bool) {
        for (i, &f) in around.iter().enumerate().filter(|(_, f)| **f != NONE) {
            let [first, last] = self.ends[self.strip(f) as usize];
            for (side, after) in [last, self.previous[first as usize]].into_iter().enumerate() {
                if coder.bit(&mut models.strip[i][side], wanted == after) {
                    return (after, false);
                }
            }
        }
        let strip = if wanted == NONE || !C::WRITES { 0 } else { self.strip(wanted) + 1 };
        match coder.uniform(self.strips() + 1, strip) {
            0 => (NONE, true),
            strip => (self.ends[strip as usize - 1][1], true),
        }
    }

    fn insert(&mut self, place: Place) {
        let face = self.next.len() as u32;
        let before = self.next_of(place.after);
        self.next.push(before);
        self.previous.push(place.after);
        self.strip.push(place.strip);
        match place.after {
            NONE => self.first = face,
            after => self.next[after as usize] = face,
        }
        if before != NONE {
            self.previous[before as usize] = face;
        }
        if place.strip == self.strips() {
            self.ends.push([face; 2]);
        } else {
            let [first, last] = &mut self.ends[place.strip as usize];
            if *last == place.after {
                *last = face;
            } else if *first == before {
                *first = face;
            }
        }
    }

    /// The strips of a mesh with so many submeshes as a graphics card reads them.
    pub(super) fn draw(&self, growth: &Growth, submeshes: usize) -> Option<StripSet> {
        let (mut indices, mut ends) = (Vec::new(), Vec::new());
        let mut submesh_ends = vec![0; submeshes];
        let mut strip = Vec::new();
        let mut face = self.first;
        while face != NONE {
            strip.push(growth.face(face));
            let next = self.next[face as usize];
            if !self.same(face, next) {
                write(&strip, &mut indices, &mut ends);
                strip.clear();
                submesh_ends[growth.submesh[growth.face(face)[0] as usize] as usize] =
                    ends.len() as u32;
            }
            face = next;
        }
        for s in 1..submeshes {
            submesh_ends[s] = submesh_ends[s].max(submesh_ends[s - 1]);
        }
        StripSet::from_parts(indices, ends, submesh_ends).ok()
    }
}

/// Appends the indices of a sequence of triangles, as one strip if each shares the right edge with
/// the next, else as several.
fn write(triangles: &[[u32; 3]], indices: &mut Vec<u32>, ends: &mut Vec<u32>) {
    let mut rest = triangles;
    while !rest.is_empty() {
        let used = one_strip(rest, indices);
        ends.push(indices.len() as u32);
        rest = &rest[used..];
    }
}

/// How two triangles meet: the corner of the first before their common edge, and that of the second
/// opposite of it.
type Link = (usize, usize);

/// All ways in which two triangles meet; mostly one.
fn links(from: [u32; 3], to: [u32; 3]) -> impl Iterator<Item = Link> {
    let meets =
        move |&(i, j): &Link| from[i] == to[(j + 2) % 3] && from[(i + 1) % 3] == to[(j + 1) % 3];
    (0..9).map(|i| (i / 3, i % 3)).filter(meets)
}

/// The vertex that the edge into a triangle and the edge out of it have in common, if they are not
/// the same edge.
fn pivot(t: [u32; 3], opposite: usize, leave: usize) -> Option<u32> {
    match (leave + 3 - opposite) % 3 {
        0 => Some(t[(leave + 1) % 3]),
        2 => Some(t[leave]),
        _ => None,
    }
}

/// Appends the longest strip that the first triangles make, in the fewest indices, and says how
/// many triangles that are.
///
/// A strip that goes round the same vertex twice in a row has to name it again. Where two triangles
/// have several common edges, the ways through are compared: each keeps the cheapest way to every
/// link (Viterbi 1967).
fn one_strip(triangles: &[[u32; 3]], indices: &mut Vec<u32>) -> usize {
    // For each link its cost so far, the vertex it turned around, and which link came before it.
    let mut ways: Vec<Vec<(Link, u32, u32, usize)>> = Vec::new();
    for pair in triangles.windows(2) {
        let mut here = Vec::new();
        for link in links(pair[0], pair[1]) {
            let way = match ways.last() {
                None => Some((0, pair[0][link.0], 0)),
                Some(before) => (before.iter().enumerate())
                    .filter_map(|(i, &((_, opposite), cost, turned, _))| {
                        let pivot = pivot(pair[0], opposite, link.0)?;
                        Some((cost + u32::from(pivot == turned), pivot, i))
                    })
                    .min_by_key(|&(cost, _, i)| (cost, i)),
            };
            here.extend(way.map(|(cost, turned, i)| (link, cost, turned, i)));
        }
        if here.is_empty() {
            break;
        }
        ways.push(here);
    }
    let mut chosen = Vec::with_capacity(ways.len());
    let last = ways.last().and_then(|w| (0..w.len()).min_by_key(|&i| w[i].1));
    let mut at = last.unwrap_or_default();
    for way in ways.iter().rev() {
        chosen.push((way[at].0, way[at].2));
        at = way[at].3;
    }
    let Some(&((leave, _), _)) = chosen.last() else {
        indices.extend(triangles[0]);
        return 1;
    };
    let first = triangles[0];
    indices.extend([first[(leave + 2) % 3], first[leave], first[(leave + 1) % 3]]);
    for (i, pair) in chosen.windows(2).rev().enumerate() {
        let ((_, turned), ((_, opposite), before)) = (pair[0], pair[1]);
        if turned == before {
            indices.push(turned);
        }
        indices.push(triangles[i + 1][opposite]);
    }
    let ((_, opposite), _) = chosen[0];
    indices.push(triangles[chosen.len()][opposite]);
    chosen.len() + 1
}
