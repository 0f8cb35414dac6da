// Draws the triangles of a picture with their materials, lit by lamps that move with the camera,
// and with the edges of triangles if asked for. Vertices are not indexed: three in a row are a
// triangle.

// The camera and the style of a picture, the same for all materials.
struct Shot {
    // From positions to clip space.
    matrix: mat4x4<f32>,
    // Unit vectors of the camera, in the space of positions; w is unused except where it is named.
    right: vec4<f32>,
    up: vec4<f32>,
    // From the scene towards the camera; w: 1 with perspective, else 0.
    toward: vec4<f32>,
    // The position of the camera, and the direction of the sky.
    eye: vec4<f32>,
    world_up: vec4<f32>,
    // Edges of triangles: rgb: their colour, w: their width in pixels, 0 for none.
    wire: vec4<f32>,
    // Back faces: rgb: a colour, w: their treatment: 0 as the material says, 1 drawn, 2 not drawn,
    // 3 drawn in this colour.
    back: vec4<f32>,
}

struct Material {
    // Multiplied by the texture and by the colour of vertices.
    colour: vec4<f32>,
    // The two rows of the transform of texture coordinates (u, v, 1); w is unused.
    u: vec4<f32>,
    v: vec4<f32>,
    // x: the opacity below which nothing is drawn, -1 for none. The others are 0 or 1: y: back
    // faces are drawn, z: unlit, w: opacity is used.
    flags: vec4<f32>,
}

@group(0) @binding(0) var<uniform> shot: Shot;
@group(1) @binding(0) var<uniform> material: Material;
// The texture of base colours.
@group(1) @binding(1) var base: texture_2d<f32>;
@group(1) @binding(2) var base_sampler: sampler;

struct Varying {
    @builtin(position) @invariant clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) colour: vec4<f32>,
    // Barycentric coordinates: each falls from 1 at one corner to 0 at the opposite edge.
    @location(4) barycentric: vec3<f32>,
}

@vertex
fn vertex(
    @builtin(vertex_index) index: u32,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) colour: vec4<f32>,
) -> Varying {
    var out: Varying;
    out.clip = shot.matrix * vec4<f32>(position, 1.0);
    out.position = position;
    out.normal = normal;
    let uv1 = vec3<f32>(uv, 1.0);
    out.uv = vec2<f32>(dot(material.u.xyz, uv1), dot(material.v.xyz, uv1));
    out.colour = colour;
    let k = index % 3u;
    out.barycentric = vec3<f32>(f32(k == 0u), f32(k == 1u), f32(k == 2u));
    return out;
}

// A surface's colour in the light: a key lamp at the upper left, a weak one at the right, light
// from the sky and some from the ground, and a faint highlight. All numbers are chosen by hand.
fn lit(albedo: vec3<f32>, normal: vec3<f32>, toward_eye: vec3<f32>) -> vec3<f32> {
    let key = normalize(0.9 * shot.toward.xyz + 0.75 * shot.up.xyz - 0.6 * shot.right.xyz);
    let fill = normalize(0.6 * shot.toward.xyz + 0.05 * shot.up.xyz + 0.9 * shot.right.xyz);
    let sky = 0.5 + 0.5 * dot(normal, shot.world_up.xyz);
    let light = mix(vec3<f32>(0.13, 0.12, 0.115), vec3<f32>(0.27, 0.28, 0.30), sky)
        + 0.62 * max(dot(normal, key), 0.0)
        + 0.12 * max(dot(normal, fill), 0.0);
    let half_way = normalize(key + toward_eye);
    let shine = 0.03 * pow(max(dot(normal, half_way), 0.0), 32.0);
    return albedo * light + shine;
}

@fragment
fn fragment(in: Varying, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    // Both derivatives need the neighbouring pixels, so they are taken before any pixel is
    // discarded.
    let texel = textureSample(base, base_sampler, in.uv);
    let barycentric_per_pixel = fwidth(in.barycentric);
    let back_faces = u32(shot.back.w);
    if (!front && (back_faces == 2u || (back_faces == 0u && material.flags.y < 0.5))) {
        discard;
    }
    var colour = material.colour * in.colour * texel;
    if (colour.a < material.flags.x) {
        discard;
    }
    if (material.flags.w < 0.5) {
        colour.a = 1.0;
    }
    if (!front && back_faces == 3u) {
        colour = vec4<f32>(shot.back.rgb, 1.0);
    }
    var toward_eye = shot.toward.xyz;
    if (shot.toward.w > 0.5) {
        toward_eye = normalize(shot.eye.xyz - in.position);
    }
    var normal = normalize(in.normal);
    if (!front) {
        normal = -normal;
    }
    var rgb = colour.rgb;
    if (material.flags.z < 0.5) {
        rgb = lit(colour.rgb, normal, toward_eye);
    }
    if (shot.wire.w > 0.0) {
        // Distances from the three edges in pixels.
        let distances = in.barycentric / max(barycentric_per_pixel, vec3<f32>(1e-6));
        let nearest = min(distances.x, min(distances.y, distances.z));
        let half_width = 0.5 * shot.wire.w;
        let line = 1.0 - smoothstep(half_width - 0.5, half_width + 0.5, nearest);
        // Where triangles are hardly larger than the line, it fades, or dense meshes would be all
        // line. The numbers are chosen by hand.
        let largest = max(
            barycentric_per_pixel.x, max(barycentric_per_pixel.y, barycentric_per_pixel.z));
        let fade = clamp(1.6 - 2.4 * half_width * largest, 0.25, 1.0);
        rgb = mix(rgb, shot.wire.rgb, line * fade * 0.85);
        colour.a = max(colour.a, line * fade);
    }
    rgb = min(rgb, vec3<f32>(1.0));
    return vec4<f32>(rgb * colour.a, colour.a);
}
