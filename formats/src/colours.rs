//! Colours of vertices. In OBJ, PLY and STL they are sRGB values, as of pixels: no specification
//! says so, but every program shows them so. A mesh has linear light, as COLOR_0 of a glTF.

#[cfg(feature = "export")]
use lodc_mesh::{Attribute, Component};
#[cfg(feature = "export")]
use lodc_scene::srgb_value;
use lodc_scene::to_linear;
#[cfg(feature = "import")]
use rayon::prelude::*;
#[cfg(feature = "export")]
use std::collections::HashMap;

/// Converts colours of a file to linear light. Returns true if they were from 0 to 255, as 3D
/// Builder writes them: if one is above 2, which rounding does not explain.
#[cfg(feature = "import")]
pub(crate) fn linear(colours: &[[f32; 4]]) -> (Vec<[f32; 4]>, bool) {
    let is_large = |c: &&[f32; 4]| c[..3].iter().any(|v| *v > 2.0);
    let are_bytes = colours.par_iter().find_any(is_large).is_some();
    let unit = if are_bytes { 255.0 } else { 1.0 };
    let convert = |&[r, g, b, a]: &[f32; 4]| {
        let [r, g, b] = [r, g, b].map(|v| to_linear(v / unit));
        [r, g, b, if are_bytes && a > 1.0 { a / unit } else { a }]
    };
    (colours.par_iter().map(convert).collect(), are_bytes)
}

/// The sRGB values of linear light, remembered: colours repeat.
#[cfg(feature = "export")]
#[derive(Debug, Default)]
pub(crate) struct SrgbValues(HashMap<(u32, Component), f32>);

#[cfg(feature = "export")]
impl SrgbValues {
    /// The sRGB value of a channel of a colour: the one with the fewest digits that an import
    /// turns into the value as it is stored, so that what came from an OBJ or PLY goes back there
    /// unchanged.
    pub(crate) fn of(&mut self, colour: &Attribute, vertex: u32, channel: usize) -> f32 {
        let light = colour.value(vertex, channel);
        let key = (light.to_bits(), colour.component);
        *self.0.entry(key).or_insert_with(|| shortest(light, colour.component))
    }
}

/// See [`SrgbValues::of`].
#[cfg(feature = "export")]
fn shortest(light: f32, component: Component) -> f32 {
    let steps = match component {
        Component::U8 => Some(255.0),
        Component::U16 => Some(65535.0),
        _ => None,
    };
    let stored = |light: f32| match steps {
        Some(steps) => (f64::from(light) * steps).round(),
        None => f64::from(light),
    };
    let value = srgb_value(light);
    let reads_back = |v: &f32| stored(to_linear(*v)) == stored(light);
    let rounded = |v: f64, digits: i32| {
        let power = 10f64.powi(digits);
        ((v * power).round() / power) as f32
    };
    // Light in whole steps was a byte before if that byte rounds to the same step. In 16 bits,
    // where bytes are at least 20 steps apart, the next step counts as well: the byte may have been
    // written with six digits.
    let max_steps = if component == Component::U16 { 1.0 } else { 0.0 };
    let byte = f64::from((value * 255.0).round()) / 255.0;
    let was_byte = (stored(to_linear(byte as f32)) - stored(light)).abs() <= max_steps;
    if steps.is_some() && was_byte {
        return rounded(byte, 6);
    }
    let neighbours = [value, value.next_up(), value.next_down()];
    let mut candidates = (1..9).map(|digits| rounded(value.into(), digits)).chain(neighbours);
    candidates.find(reads_back).unwrap_or(value)
}

#[cfg(all(test, feature = "import", feature = "export"))]
mod tests {
    use super::*;

    #[test]
    fn digits_come_back_as_they_were() {
        for text in ["0.5", "0.501961", "0.2", "1", "0", "0.003922", "0.73", "0.0123", "0.999999"] {
            let v: f32 = text.parse().expect("a number");
            let light = linear(&[[v, v, v, 1.0]]).0[0][0];
            assert_eq!(shortest(light, Component::F32).to_string(), text);
        }
    }

    #[test]
    fn bytes_survive_sixteen_bits() {
        for byte in 0..=255u8 {
            let light = to_linear(f32::from(byte) / 255.0);
            let stored = (light * 65535.0).round() / 65535.0;
            let back = shortest(stored, Component::U16);
            assert_eq!((back * 255.0).round() as u8, byte);
            assert!((back - f32::from(byte) / 255.0).abs() < 1e-6, "{byte}: {back}");
        }
    }

    #[test]
    fn numbers_up_to_255_are_bytes() {
        let (light, are_bytes) = linear(&[[255.0, 128.0, 0.0, 1.0]]);
        assert!(are_bytes);
        assert_eq!(light[0][0], 1.0);
        assert_eq!(shortest(light[0][1], Component::F32), 128.0 / 255.0);
        assert!(!linear(&[[1.001, 0.5, 0.0, 1.0]]).1);
    }
}
