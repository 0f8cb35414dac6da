// Flat-shaded triangles, for timing draws.

struct Scene { centre: vec3<f32>, scale: f32 }

@group(0) @binding(0) var<uniform> scene: Scene;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) place: vec3<f32>,
}

@vertex
fn vertex(@location(0) position: vec3<f32>) -> Corner {
    let p = (position - scene.centre) * scene.scale;
    // Turned by a quarter of a right angle about two axes.
    let across = vec3<f32>(0.924 * p.x + 0.383 * p.z, p.y, 0.924 * p.z - 0.383 * p.x);
    let y = 0.924 * across.y - 0.383 * across.z;
    let seen = vec3<f32>(across.x, y, 0.924 * across.z + 0.383 * across.y);
    return Corner(vec4<f32>(seen.xy, 0.5 - 0.5 * seen.z, 1.0), seen);
}

@fragment
fn fragment(corner: Corner) -> @location(0) vec4<f32> {
    let normal = normalize(cross(dpdx(corner.place), dpdy(corner.place)));
    return vec4<f32>(vec3<f32>(abs(normal.z)), 1.0);
}
