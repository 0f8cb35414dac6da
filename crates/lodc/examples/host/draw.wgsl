// Flat-shaded triangles in the view of one eye.

@group(0) @binding(0) var<uniform> camera: mat4x4<f32>;

struct Corner {
    @builtin(position) place: vec4<f32>,
    @location(0) position: vec3<f32>,
}

@vertex
fn vertex(@location(0) position: vec3<f32>) -> Corner {
    return Corner(camera * vec4(position, 1.0), position);
}

@fragment
fn fragment(corner: Corner) -> @location(0) vec4<f32> {
    let normal = normalize(cross(dpdx(corner.position), dpdy(corner.position)));
    let light = 0.35 + 0.6 * abs(dot(normal, normalize(vec3(0.3, 0.8, 0.5))));
    return vec4(vec3(light), 1.0);
}
