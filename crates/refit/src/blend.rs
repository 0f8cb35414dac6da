//! Interpolates attribute values between the corners of a triangle, stream by stream, and stores
//! them in the stream's number type.

use lodc_mesh::{Attribute, Component, Semantic};

/// Lengths below this are none: directions of the corners cancel out. Chosen by hand.
const MIN_LENGTH: f64 = 1e-6;

/// A point of the input's surface: the vertices of a triangle, and barycentric coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source {
    pub(crate) vertices: [u32; 3],
    pub(crate) weights: [f64; 3],
}

/// Replaces the values of a stream by those of the input at each vertex's source, if it has one.
///
/// Joints and weights belong together and are left to [`crate::skin`]; streams whose meaning is not
/// known keep the value of the level's own vertex.
pub(crate) fn blend(stream: &mut Attribute, from: &Attribute, sources: &[Option<Source>]) {
    if matches!(stream.semantic, Semantic::Joints(_) | Semantic::Weights(_) | Semantic::Custom(_)) {
        return;
    }
    let (components, is_unit) = (usize::from(stream.components), is_direction(stream));
    for (v, source) in sources.iter().enumerate() {
        let Some(Source { vertices, weights }) = source else { continue };
        let mut value = [0.0f64; 16];
        for (&vertex, weight) in vertices.iter().zip(weights) {
            for (k, sum) in value[..components].iter_mut().enumerate() {
                *sum += weight * f64::from(from.value(vertex, k));
            }
        }
        if is_unit && components >= 3 {
            let length = value[..3].iter().map(|x| x * x).sum::<f64>().sqrt();
            if length < MIN_LENGTH {
                continue;
            }
            value[..3].iter_mut().for_each(|x| *x /= length);
        }
        if stream.semantic == Semantic::Tangent && stream.morph_target.is_none() && components == 4
        {
            // Handedness is one of two values: that of the nearest corner.
            let nearest = (0..3).max_by(|&a, &b| weights[a].total_cmp(&weights[b])).unwrap_or(0);
            value[3] = f64::from(from.value(vertices[nearest], 3));
        }
        store(stream, v, &value[..components]);
    }
}

/// Returns whether the first three components are a unit vector.
fn is_direction(stream: &Attribute) -> bool {
    stream.morph_target.is_none() && matches!(stream.semantic, Semantic::Normal | Semantic::Tangent)
}

/// Stores the components of one vertex in the stream's type.
pub(crate) fn store(stream: &mut Attribute, vertex: usize, values: &[f64]) {
    let (size, stride) = (stream.component.size(), stream.stride());
    for (k, &value) in values.iter().enumerate() {
        let bytes = encode(stream.component, stream.normalized, value);
        stream.bytes[vertex * stride + k * size..][..size].copy_from_slice(&bytes[..size]);
    }
}

/// Returns a number in the bytes of a component type, rounded to what that can hold; the first ones
/// count.
fn encode(component: Component, normalized: bool, value: f64) -> [u8; 4] {
    let (min_value, max_value) = match component {
        Component::I8 => (-127.0, 127.0),
        Component::U8 => (0.0, 255.0),
        Component::I16 => (-32767.0, 32767.0),
        Component::U16 => (0.0, 65535.0),
        Component::U32 => (0.0, f64::from(u32::MAX)),
        Component::F32 => return (value as f32).to_le_bytes(),
    };
    let scaled = if normalized { value * max_value } else { value };
    // Two's complement: the low bytes of a wider integer are those of a narrow one.
    (scaled.round().clamp(min_value, max_value) as i64 as u32).to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stream(semantic: Semantic, component: Component, n: u8, values: &[&[f64]]) -> Attribute {
        let normalized = component != Component::F32;
        let mut stream = Attribute {
            semantic,
            morph_target: None,
            component,
            components: n,
            normalized,
            bytes: vec![0; values.len() * component.size() * usize::from(n)],
        };
        for (v, value) in values.iter().enumerate() {
            store(&mut stream, v, value);
        }
        stream
    }

    #[test]
    fn values_are_between_those_of_the_corners() {
        let from =
            stream(Semantic::TexCoord(0), Component::F32, 2, &[&[0., 0.], &[1., 0.], &[0., 1.]]);
        let mut level = from.clone();
        let source = Source { vertices: [0, 1, 2], weights: [0.5, 0.25, 0.25] };
        blend(&mut level, &from, &[None, Some(source), None]);
        assert_eq!([0, 1].map(|k| level.value(1, k)), [0.25, 0.25]);
        assert_eq!(level.at(2), from.at(2));
    }

    #[test]
    fn directions_keep_their_length_and_handedness() {
        let (x, y) = ([1.0, 0.0, 0.0, -1.0], [0.0, 1.0, 0.0, 1.0]);
        let from = stream(Semantic::Tangent, Component::I8, 4, &[&x, &y, &y]);
        let mut level = from.clone();
        let source = Source { vertices: [0, 1, 2], weights: [0.6, 0.2, 0.2] };
        blend(&mut level, &from, &[Some(source), None, None]);
        let length = (0..3).map(|k| level.value(0, k).powi(2)).sum::<f32>().sqrt();
        assert!((length - 1.0).abs() < 0.01 && level.value(0, 3) == -1.0);
    }

    #[test]
    fn integers_round_and_stay_in_range() {
        let bytes = |component, value| encode(component, true, value);
        assert_eq!(bytes(Component::I8, -2.0)[0] as i8, -127);
        assert_eq!(bytes(Component::U8, 0.5)[0], 128);
        let wide = bytes(Component::I16, -0.5);
        assert_eq!(i16::from_le_bytes([wide[0], wide[1]]), -16384);
        assert_eq!(encode(Component::U16, false, 700.4)[..2], 700u16.to_le_bytes());
    }
}
