// Flat-shaded triangles: each is lit by its own normal, whichever way it faces.

// From world space to clip space.
@group(0) @binding(0) var<uniform> camera: mat4x4<f32>;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    // In world space.
    @location(0) position: vec3<f32>,
}

@vertex
fn vertex(@location(0) position: vec3<f32>) -> Corner {
    return Corner(camera * vec4(position, 1.0), position);
}

@fragment
fn fragment(corner: Corner) -> @location(0) vec4<f32> {
    // The normal of the triangle: how the position changes from pixel to pixel.
    let normal = normalize(cross(dpdx(corner.position), dpdy(corner.position)));
    // Ambient light, and one lamp from above; chosen by hand.
    let light = 0.35 + 0.6 * abs(dot(normal, normalize(vec3(0.3, 0.8, 0.5))));
    return vec4(vec3(light), 1.0);
}
