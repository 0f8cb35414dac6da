//! Colours of surfaces: plain ones, and pictures laid over triangles by texture coordinates.

use glam::{Vec2, Vec3};

/// No texture is more often halved than this.
const LEVELS: usize = 16;

/// The colour of triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paint {
    /// Red, green and blue as shown (not linear), 0 to 1; multiplied with the texture.
    pub colour: Vec3,
    /// Index of the texture.
    pub texture: Option<usize>,
}

/// How a texture goes on beyond an edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// From the start again.
    #[default]
    Repeat,
    /// Backwards.
    Mirror,
    /// With its last texels.
    Clamp,
}

/// A picture that can be read at any place and size. Texture coordinates 0 to 1 span it, with its
/// first row at 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The picture, and what is left of it each time it is halved.
    levels: Vec<Level>,
    wrap: [Wrap; 2],
}

#[derive(Clone, Debug, PartialEq)]
struct Level {
    size: [usize; 2],
    /// Red, green and blue, row by row.
    texels: Vec<[u8; 3]>,
}

impl Texture {
    /// Takes rows of texels, `width` in each. An empty picture is white.
    #[must_use]
    pub fn new(width: usize, texels: Vec<[u8; 3]>, wrap: [Wrap; 2]) -> Self {
        let height = texels.len().checked_div(width).unwrap_or(0);
        let mut level = Level { size: [width, height], texels };
        if height == 0 {
            level = Level { size: [1, 1], texels: vec![[255; 3]] };
        }
        let mut levels = vec![level];
        while levels.len() < LEVELS
            && let Some(last) = levels.last()
            && last.size != [1, 1]
        {
            levels.push(last.halved());
        }
        Self { levels, wrap }
    }

    /// Texels in the whole picture.
    #[must_use]
    pub fn area(&self) -> f32 {
        let [width, height] = self.levels[0].size;
        (width * height) as f32
    }

    /// The colour at a place, 0 to 1, if a pixel is as large as `texels` of the picture. Linear
    /// between texels and between sizes.
    #[must_use]
    pub fn at(&self, place: Vec2, texels: f32) -> Vec3 {
        let (mut level, mut left) = (0, texels);
        while left > 4.0 && level + 2 < self.levels.len() {
            left *= 0.25;
            level += 1;
        }
        let near = self.levels[level].at(place, self.wrap);
        let share = ((left - 1.0) / 3.0).clamp(0.0, 1.0);
        match self.levels.get(level + 1) {
            Some(next) if share > 0.0 => near.lerp(next.at(place, self.wrap), share),
            _ => near,
        }
    }
}

impl Level {
    /// Half as large: means of four.
    fn halved(&self) -> Self {
        let size = self.size.map(|s| s.div_ceil(2));
        let mean = |x: usize, y: usize| {
            let at = |dx: usize, dy: usize| self.texel(2 * x + dx, 2 * y + dy);
            let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
            [0, 1, 2]
                .map(|c| (four.iter().map(|t| u32::from(t[c])).sum::<u32>().midpoint(3) / 2) as u8)
        };
        let texels = (0..size[1])
            .flat_map(|y| (0..size[0]).map(move |x| (x, y)))
            .map(|(x, y)| mean(x, y))
            .collect();
        Self { size, texels }
    }

    fn texel(&self, x: usize, y: usize) -> [u8; 3] {
        self.texels[y.min(self.size[1] - 1) * self.size[0] + x.min(self.size[0] - 1)]
    }

    fn at(&self, place: Vec2, wrap: [Wrap; 2]) -> Vec3 {
        let [x, y] = [0, 1].map(|k| along(place[k], self.size[k], wrap[k]));
        let texel =
            |i: usize, j: usize| Vec3::from(self.texel(x.0[i], y.0[j]).map(f32::from)) / 255.0;
        let row = |j: usize| texel(0, j).lerp(texel(1, j), x.1);
        row(0).lerp(row(1), y.1)
    }
}

/// The two texels beside a place along one axis, and how far it is from the first to the second.
fn along(place: f32, size: usize, wrap: Wrap) -> ([usize; 2], f32) {
    let place = if place.is_finite() { place } else { 0.0 };
    let turns = match wrap {
        Wrap::Repeat => place - place.floor(),
        Wrap::Mirror => 2.0 * (place * 0.5 - (place * 0.5).floor()),
        Wrap::Clamp => place.clamp(0.0, 1.0),
    };
    let at = turns * size as f32 - 0.5;
    let (first, share) = (at.floor(), at - at.floor());
    let index = |i: i64| {
        let size = size as i64;
        (match wrap {
            Wrap::Repeat => i.rem_euclid(size),
            Wrap::Clamp => i.clamp(0, size - 1),
            Wrap::Mirror => {
                let i = i.rem_euclid(2 * size);
                i.min(2 * size - 1 - i)
            }
        }) as usize
    };
    ([index(first as i64), index(first as i64 + 1)], share)
}
