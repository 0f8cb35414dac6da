// Flat-shaded triangles of one mesh, seen from one side, for timing draws: cheap, but every pixel
// depends on its triangle.

struct Scene {
    // The centre of the mesh.
    centre: vec3<f32>,
    // From mesh units to clip space.
    scale: f32,
}

@group(0) @binding(0) var<uniform> scene: Scene;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    // Relative to the centre, rotated and scaled.
    @location(0) position: vec3<f32>,
}

@vertex
fn vertex(@location(0) position: vec3<f32>) -> Corner {
    let p = (position - scene.centre) * scene.scale;
    // Rotated by 22.5 degrees (cosine 0.924, sine 0.383) about y, then about x.
    let about_y = vec3<f32>(0.924 * p.x + 0.383 * p.z, p.y, 0.924 * p.z - 0.383 * p.x);
    let y = 0.924 * about_y.y - 0.383 * about_y.z;
    let rotated = vec3<f32>(about_y.x, y, 0.924 * about_y.z + 0.383 * about_y.y);
    return Corner(vec4<f32>(rotated.xy, 0.5 - 0.5 * rotated.z, 1.0), rotated);
}

@fragment
fn fragment(corner: Corner) -> @location(0) vec4<f32> {
    // The normal of the triangle: how the position changes from pixel to pixel.
    let normal = normalize(cross(dpdx(corner.position), dpdy(corner.position)));
    return vec4<f32>(vec3<f32>(abs(normal.z)), 1.0);
}
