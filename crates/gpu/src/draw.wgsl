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
    @location(0) place: vec3<f32>,
}

@vertex
fn vertex(@location(0) position: vec3<f32>) -> Corner {
    let p = (position - scene.centre) * scene.scale;
    // Rotated by 22.5 degrees (cosine 0.924, sine 0.383) about y, then about x.
    let across = vec3<f32>(0.924 * p.x + 0.383 * p.z, p.y, 0.924 * p.z - 0.383 * p.x);
    let y = 0.924 * across.y - 0.383 * across.z;
    let seen = vec3<f32>(across.x, y, 0.924 * across.z + 0.383 * across.y);
    return Corner(vec4<f32>(seen.xy, 0.5 - 0.5 * seen.z, 1.0), seen);
}

@fragment
fn fragment(corner: Corner) -> @location(0) vec4<f32> {
    // The normal of the triangle: how the position changes from pixel to pixel.
    let normal = normalize(cross(dpdx(corner.place), dpdy(corner.place)));
    return vec4<f32>(vec3<f32>(abs(normal.z)), 1.0);
}
