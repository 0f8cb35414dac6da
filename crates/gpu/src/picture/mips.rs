//! Smaller and smaller copies of a texture, averaged in linear light; the device has no fixed way
//! to make them.

use super::pixels::{encoded, linear_table};

/// All levels from the picture itself to one texel: width, height, bytes.
pub(super) fn levels(width: u32, height: u32, bytes: Vec<u8>) -> Vec<(u32, u32, Vec<u8>)> {
    let linear = linear_table();
    let mut levels = vec![(width, height, bytes)];
    loop {
        let (w, h, bytes) = levels.last().expect("there is the first");
        if (*w, *h) == (1, 1) {
            return levels;
        }
        let next = half(*w, *h, bytes, &linear);
        levels.push(next);
    }
}

/// One level further. With an odd number of texels the last one counts into the neighbour on its
/// left or above.
fn half(width: u32, height: u32, bytes: &[u8], linear: &[f32; 256]) -> (u32, u32, Vec<u8>) {
    let (w, h) = ((width / 2).max(1), (height / 2).max(1));
    let mut out = Vec::with_capacity(4 * w as usize * h as usize);
    // The texels of the old row or column that a new one is made of.
    let span =
        |i: u32, new: u32, old: u32| if i + 1 == new { 2 * i..old } else { 2 * i..2 * i + 2 };
    for y in 0..h {
        for x in 0..w {
            let (mut sum, mut weight, mut plain, mut texels) =
                ([0.0f32; 3], 0.0f32, [0.0f32; 3], 0.0f32);
            for oy in span(y, h, height) {
                for ox in span(x, w, width) {
                    let start = 4 * (oy as usize * width as usize + ox as usize);
                    let opacity = f32::from(bytes[start + 3]) / 255.0;
                    for c in 0..3 {
                        let light = linear[usize::from(bytes[start + c])];
                        sum[c] += opacity * light;
                        plain[c] += light;
                    }
                    weight += opacity;
                    texels += 1.0;
                }
            }
            // What cannot be seen must not bleed into what can.
            let colour =
                if weight > 0.0 { sum.map(|c| c / weight) } else { plain.map(|c| c / texels) };
            out.extend(colour.map(encoded));
            out.push((weight / texels * 255.0 + 0.5) as u8);
        }
    }
    (w, h, out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_end_at_one_texel_whatever_the_shape() {
        for (w, h) in [(1, 1), (7, 1), (1, 4), (5, 3), (16, 16)] {
            let all = levels(w, h, vec![200; 4 * (w * h) as usize]);
            assert_eq!(all.len() as u32, 32 - w.max(h).leading_zeros());
            assert_eq!(all.last().map(|l| (l.0, l.1)), Some((1, 1)));
            assert!(
                all.iter()
                    .all(|(w, h, b)| b.len() as u32 == 4 * w * h && b.iter().all(|&v| v == 200))
            );
        }
    }

    #[test]
    fn transparent_texels_do_not_bleed() {
        let all = levels(2, 1, vec![255, 0, 0, 255, 0, 255, 0, 0]);
        assert_eq!(all[1].2, [255, 0, 0, 128]);
    }
}
