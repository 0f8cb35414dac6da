//! Points and lines of a scene, which are not simplified and pass through. Those of an OBJ, PLY or
//! STL are kept as statements of an OBJ; a glTF has them in its document.

use crate::far::single;
#[cfg(feature = "import")]
use std::collections::BTreeMap;
use std::fmt::Write;

/// Points and lines, their vertices apart from those of triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Loose {
    /// In the file's own coordinates, however far from the origin.
    pub(crate) positions: Vec<[f64; 3]>,
    /// Empty, or sRGB values for each position.
    pub(crate) colors: Vec<[f32; 3]>,
    pub(crate) points: Vec<u32>,
    /// For each line the vertices that it connects.
    pub(crate) lines: Vec<Vec<u32>>,
}

impl Loose {
    #[cfg(any(feature = "export", test))]
    pub(crate) fn is_empty(&self) -> bool {
        self.points.is_empty() && self.lines.is_empty()
    }

    /// The statements of an OBJ: vertices, points, lines. Indices count from the last vertex, so
    /// that they hold wherever the statements stand.
    pub(crate) fn statements(&self) -> Vec<String> {
        let count = self.positions.len() as i64;
        let mut statements = Vec::with_capacity(self.positions.len() + self.lines.len() + 1);
        for (v, position) in self.positions.iter().enumerate() {
            let mut line = String::from("v");
            position.iter().for_each(|&c| coordinate(&mut line, c));
            self.colors.get(v).into_iter().flatten().for_each(|c| put(&mut line, c));
            statements.push(line);
        }
        let element = |word: &str, vertices: &[u32]| {
            let mut line = word.to_owned();
            vertices.iter().for_each(|&v| put(&mut line, &(i64::from(v) - count)));
            line
        };
        // Chosen by hand: readers limit the length of a line.
        statements.extend(self.points.chunks(64).map(|points| element("p", points)));
        statements.extend(self.lines.iter().map(|line| element("l", line)));
        statements
    }

    /// Reads such statements; what is none is passed over.
    #[cfg(any(feature = "export", test))]
    pub(crate) fn read(statements: &[String]) -> Self {
        let mut loose = Self::default();
        for statement in statements {
            let mut words = statement.split_ascii_whitespace();
            match words.next() {
                Some("v") => {
                    let numbers: Vec<f64> = words.filter_map(|w| w.parse().ok()).collect();
                    let [x, y, z, color @ ..] = &numbers[..] else { continue };
                    if let [r, g, b, ..] = color {
                        loose.colors.resize(loose.positions.len(), [1.0; 3]);
                        loose.colors.push([*r, *g, *b].map(single));
                    }
                    loose.positions.push([*x, *y, *z]);
                }
                Some(word @ ("p" | "l")) => {
                    let count = loose.positions.len() as i64;
                    let vertex = |w: &str| u32::try_from(w.parse::<i64>().ok()? + count).ok();
                    let vertices: Vec<u32> =
                        words.filter_map(vertex).filter(|&v| i64::from(v) < count).collect();
                    match word {
                        "p" => loose.points.extend(vertices),
                        _ => loose.lines.push(vertices),
                    }
                }
                _ => {}
            }
        }
        if !loose.colors.is_empty() {
            loose.colors.resize(loose.positions.len(), [1.0; 3]);
        }
        loose
    }

    /// The lines as pairs of vertices.
    #[cfg(feature = "export")]
    pub(crate) fn segments(&self) -> impl Iterator<Item = [u32; 2]> {
        self.lines.iter().flat_map(|line| line.windows(2).map(|pair| [pair[0], pair[1]]))
    }

    /// Picks points and lines out of a file's positions, whose indices are those of `points` and
    /// `lines`. `exact` is empty or has the positions in double precision, `colors` is empty or has
    /// one for each.
    #[cfg(feature = "import")]
    pub(crate) fn of_file(
        positions: &[[f32; 3]],
        exact: &[[f64; 3]],
        colors: &[[f32; 4]],
        points: &[u32],
        lines: &[Vec<u32>],
    ) -> Self {
        let mut numbers: BTreeMap<u32, u32> = BTreeMap::new();
        let mut loose = Self::default();
        let mut number = |v: &u32| {
            let next = numbers.len() as u32;
            *numbers.entry(*v).or_insert_with(|| {
                let position = exact.get(*v as usize).copied();
                loose
                    .positions
                    .push(position.unwrap_or_else(|| positions[*v as usize].map(f64::from)));
                loose.colors.extend(colors.get(*v as usize).map(|[r, g, b, _]| [*r, *g, *b]));
                next
            })
        };
        let points = points.iter().map(&mut number).collect();
        let lines = lines.iter().map(|line| line.iter().map(&mut number).collect()).collect();
        Self { points, lines, ..loose }
    }
}

/// Writes a coordinate with the digits that it needs: in single precision if that holds it.
fn coordinate(line: &mut String, c: f64) {
    match single(c) {
        short if f64::from(short) == c => put(line, &short),
        _ => put(line, &c),
    }
}

fn put(line: &mut String, value: &dyn std::fmt::Display) {
    write!(line, " {value}").expect("a String takes everything");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_read_back() {
        let loose = Loose {
            positions: vec![[0.0; 3], [1.0, 2.5, -3e-7], [4_649_776.123, 4.0, 1e30]],
            colors: vec![[0.5, 0.25, 1.0]; 3],
            points: vec![2, 0],
            lines: vec![vec![0, 1, 2], vec![2, 0]],
        };
        assert_eq!(Loose::read(&loose.statements()), loose);
        assert_eq!(loose.segments().count(), 3);
        assert!(Loose::read(&[]).is_empty());
    }
}
