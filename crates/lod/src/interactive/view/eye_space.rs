//! The rotation from the space of the scene to that of an eye that looks along its negative z axis,
//! as a quaternion.

/// Returns the vector part of the unit quaternion that rotates positions around the eye into eye
/// space; its scalar part is not negative. The y axis is up or, where the eye looks along it, the z
/// axis. Without a direction nothing is rotated. Exact to about a third of a thousandth: for half a
/// turn the scalar part, which kernels compute from the others, depends on their last bits alone.
pub(super) fn rotation(eye: [f32; 3], target: [f32; 3]) -> [f32; 3] {
    let Some(forward) = unit(std::array::from_fn(|i| f64::from(target[i]) - f64::from(eye[i])))
    else {
        return [0.0; 3];
    };
    let right = unit(cross(forward, [0.0, 1.0, 0.0]));
    let right = right.or_else(|| unit(cross(forward, [0.0, 0.0, 1.0])));
    let Some(right) = right else { return [0.0; 3] };
    let rotation = quaternion([right, cross(right, forward), forward.map(|c| -c)]);
    let sign = if rotation[3] < 0.0 { -1.0 } else { 1.0 };
    [0, 1, 2].map(|i| (sign * rotation[i]) as f32)
}

/// The quaternion x, y, z, w of a rotation by its rows, from its largest part on (Shepperd): square
/// roots alone, the same on every machine.
fn quaternion([x, y, z]: [[f64; 3]; 3]) -> [f64; 4] {
    let squares = [
        1.0 + x[0] - y[1] - z[2],
        1.0 - x[0] + y[1] - z[2],
        1.0 - x[0] - y[1] + z[2],
        1.0 + x[0] + y[1] + z[2],
    ];
    let largest = (0..4).max_by(|&a, &b| squares[a].total_cmp(&squares[b])).unwrap_or(3);
    let root = squares[largest].max(0.0).sqrt();
    let (largest_part, divisor) = (0.5 * root, 0.5 / root);
    let [xy, xz, yz] = [x[1] + y[0], x[2] + z[0], y[2] + z[1]].map(|sum| sum * divisor);
    let [wx, wy, wz] =
        [z[1] - y[2], x[2] - z[0], y[0] - x[1]].map(|difference| difference * divisor);
    match largest {
        0 => [largest_part, xy, xz, wx],
        1 => [xy, largest_part, yz, wy],
        2 => [xz, yz, largest_part, wz],
        _ => [wx, wy, wz, largest_part],
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
}

/// A vector of length 1; none of one that is shorter than rounding errors.
fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    (length > 1e-12 && length.is_finite()).then(|| v.map(|c| c / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turned(q: [f64; 3], d: [f64; 3]) -> [f64; 3] {
        let w = (1.0 - q.iter().map(|c| c * c).sum::<f64>()).max(0.0).sqrt();
        let twice = cross(q, d).map(|c| 2.0 * c);
        let further = cross(q, twice);
        std::array::from_fn(|i| d[i] + w * twice[i] + further[i])
    }

    #[test]
    fn the_target_is_ahead_and_the_y_axis_up() {
        let eyes = [
            [0.0, 0.0, 5.0],
            [0.5, -0.25, -4.0],
            [4.0, 1.5, 3.0],
            [-3.0, 0.1, -2.0],
            [0.5, 7.0, 0.125],
            [0.5, -7.0, 0.126],
        ];
        for eye in eyes {
            let target = [0.5, -0.25, 0.125];
            let q = rotation(eye, target).map(f64::from);
            let to = std::array::from_fn(|i| f64::from(target[i]) - f64::from(eye[i]));
            let [x, y, z] = turned(q, unit(to).expect("apart"));
            assert!(x.abs() < 5e-4 && y.abs() < 5e-4 && z < -0.999, "{eye:?}: {x} {y} {z}");
            let [x, y, _] = turned(q, [0.0, 1.0, 0.0]);
            assert!(x.abs() < 5e-4 && y > -5e-4, "{eye:?}: {x} {y}");
        }
    }
}
