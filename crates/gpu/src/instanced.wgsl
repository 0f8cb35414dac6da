// Flat-shaded instances of meshes, for timing draws of a crowd. An instance is rotated about the
// vertical axis (y) and moved.

// From world space, relative to the camera's centre, to clip space.
@group(0) @binding(0) var<uniform> camera: mat4x4<f32>;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    // In world space, relative to the camera's centre.
    @location(0) position: vec3<f32>,
}

@vertex
fn vertex(
    @location(0) position: vec3<f32>,
    // Of the instance: where its origin is relative to the camera's centre, and the cosine and sine
    // of its angle.
    @location(1) origin: vec3<f32>,
    @location(2) rotation: vec2<f32>,
) -> Corner {
    let x = rotation.x * position.x + rotation.y * position.z;
    let z = rotation.x * position.z - rotation.y * position.x;
    let p = origin + vec3<f32>(x, position.y, z);
    return Corner(camera * vec4<f32>(p, 1.0), p);
}

@fragment
fn fragment(corner: Corner) -> @location(0) vec4<f32> {
    // The normal of the triangle: how the position changes from pixel to pixel.
    let normal = normalize(cross(dpdx(corner.position), dpdy(corner.position)));
    return vec4<f32>(vec3<f32>(abs(normal.y)) * 0.9 + 0.1, 1.0);
}
