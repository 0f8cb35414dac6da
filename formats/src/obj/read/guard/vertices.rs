//! The vertices of an OBJ, and every statement that is no face.

use super::super::lines::text;
use super::super::number::Number;
use super::super::parsed::NONE;
use super::{Guard, shown};
use crate::{Fault, FormatError};

/// Upper bound on the material libraries of a file: each is a file to be opened.
const MAX_LIBRARIES: usize = 1000;

impl<'a> Guard<'a> {
    /// Passes the vertices on; notes everything else that is no face.
    pub(super) fn vertices(&mut self) -> Result<(), FormatError> {
        let mut known = false;
        let mut word = self.lines.first_statement()?;
        while let Some(statement) = word {
            known |= match statement {
                b"v" => self.position()?,
                b"vt" => self.texcoord()?,
                b"vn" => self.normal()?,
                b"mtllib" => self.library()?,
                other => self.other(other),
            };
            if self.got.colors_came_late {
                return Ok(());
            }
            self.out.pass(usize::MAX);
            word = self.lines.next_statement()?;
        }
        let notes = &self.got.parsed.notes;
        if notes.unknown.times > 0 && !known {
            let what = format!(
                "not an OBJ file: no line of it is an OBJ statement (the first is `{}`)",
                notes.unknown_first
            );
            return Err(FormatError::new(Fault::Malformed, "", what));
        }
        Ok(())
    }

    /// Notes a statement that is not read here; returns whether OBJ has it.
    fn other(&mut self, word: &[u8]) -> bool {
        let (notes, line) = (&mut self.got.parsed.notes, self.lines.number());
        match word {
            b"l" => notes.lines.add(line),
            b"p" => notes.points.add(line),
            b"curv" | b"curv2" | b"surf" => notes.free_form.add(line),
            b"f" | b"fo" | b"usemtl" | b"g" | b"o" | b"s" | b"vp" | b"bevel" | b"c_interp"
            | b"d_interp" | b"lod" | b"mg" | b"shadow_obj" | b"trace_obj" | b"usemap"
            | b"maplib" | b"cstype" | b"deg" | b"bmat" | b"step" | b"ctech" | b"stech"
            | b"parm" | b"trim" | b"hole" | b"scrv" | b"sp" | b"end" | b"con" => {}
            other => {
                if notes.unknown.times == 0 {
                    notes.unknown_first = text(&other[..other.len().min(20)]);
                }
                notes.unknown.add(line);
                return false;
            }
        }
        self.lines.skip();
        true
    }

    /// Reads numbers to the end of the statement; those beyond `N` are only counted.
    fn numbers<const N: usize>(&mut self) -> Result<([Number<'a>; N], usize), FormatError> {
        let (mut numbers, mut count) = ([Number::ZERO; N], 0);
        while let Some(token) = self.lines.token() {
            if let Some(number) = numbers.get_mut(count) {
                *number = Number::new(token)
                    .ok_or_else(|| self.malformed(format!("`{}` is not a number", shown(token))))?;
            }
            count += 1;
        }
        if count > N {
            self.got.parsed.notes.extra_values.add(self.lines.number());
        }
        Ok((numbers, count))
    }

    /// Passes one vertex on and counts it.
    fn vertex(&mut self, kind: usize, numbers: &[Number<'_>]) -> Result<bool, FormatError> {
        self.out.text.extend_from_slice([b"v", &b"vt"[..], b"vn"][kind]);
        for number in numbers {
            self.out.text.push(b' ');
            number.write(&mut self.out.text);
        }
        if kind == 0 && self.got.colored && numbers.len() == 3 {
            self.out.text.extend_from_slice(b" 1 1 1");
        }
        self.out.text.push(b'\n');
        self.got.counts[kind] += 1;
        if u64::from(self.got.counts[kind]) > self.limits.vertices.min(u64::from(NONE) - 1) {
            return Err(self.limit(format!("more than {} vertices", self.limits.vertices)));
        }
        Ok(true)
    }

    fn position(&mut self) -> Result<bool, FormatError> {
        let (numbers, count) = self.numbers::<7>()?;
        if count < 3 {
            return Err(self.malformed(format!("a position needs three numbers, here are {count}")));
        }
        if !numbers[..3].iter().all(Number::is_finite) {
            let [x, y, z] = [0, 1, 2].map(|i| numbers[i].value());
            return Err(self.malformed(format!("the position ({x}, {y}, {z}) is not finite")));
        }
        let (got, line) = (&mut self.got, self.lines.number());
        if count == 4 && numbers[3].value() != 1.0 {
            got.parsed.notes.weights.add(line);
        }
        if count == 5 {
            got.parsed.notes.extra_values.add(line);
        }
        if count < 6 {
            got.parsed.notes.uncolored.add(line);
            return self.vertex(0, &numbers[..3]);
        }
        got.colors_came_late |= !got.colored && got.counts[0] > 0;
        got.colored = true;
        if count >= 7 {
            got.parsed.faces.color_has_alpha = true;
            got.alphas.resize(got.counts[0] as usize, 1.0);
            got.alphas.push(numbers[6].value());
        }
        self.vertex(0, &numbers[..6])
    }

    fn texcoord(&mut self) -> Result<bool, FormatError> {
        let (numbers, count) = self.numbers::<3>()?;
        if count == 0 {
            return Err(self.malformed("texture coordinates need at least one number"));
        }
        let (w, all) = (numbers[2].value(), &mut self.got.parsed.faces.texcoords_w);
        if count >= 3 && (w != 0.0 || !all.is_empty()) {
            all.resize(self.got.counts[1] as usize, 0.0);
            all.push(w);
        }
        self.vertex(1, &numbers[..2])
    }

    fn normal(&mut self) -> Result<bool, FormatError> {
        let (numbers, count) = self.numbers::<3>()?;
        if count < 3 {
            return Err(self.malformed(format!("a normal needs three numbers, here are {count}")));
        }
        self.vertex(2, &numbers)
    }

    fn library(&mut self) -> Result<bool, FormatError> {
        let name = self.lines.rest();
        let libraries = &mut self.got.parsed.libraries;
        if !name.is_empty() && !libraries.contains(&name) {
            libraries.push(name);
        }
        if libraries.len() > MAX_LIBRARIES {
            return Err(self.limit(format!("more than {MAX_LIBRARIES} material libraries")));
        }
        Ok(true)
    }
}
