// Corners as they come, three to a triangle; lit by lamps that stand with the camera.

struct Shot {
    matrix: mat4x4<f32>,
    right: vec4<f32>,
    up: vec4<f32>,
    // Towards the camera; w: 1 with perspective.
    toward: vec4<f32>,
    eye: vec4<f32>,
    world_up: vec4<f32>,
    // Colour of edges and, in w, their width in pixels of this picture.
    wire: vec4<f32>,
    // Colour of back faces, and their treatment: 0 as the material says, 1 shown, 2 hidden, 3 this
    // colour.
    back: vec4<f32>,
}

struct Material {
    colour: vec4<f32>,
    // Two rows: from texture coordinates to those of this material.
    u: vec4<f32>,
    v: vec4<f32>,
    // Cut-off of opacity (below 0: none), and whether back faces are drawn, light does not matter,
    // opacity counts.
    flags: vec4<f32>,
}

@group(0) @binding(0) var<uniform> shot: Shot;
@group(1) @binding(0) var<uniform> material: Material;
@group(1) @binding(1) var base: texture_2d<f32>;
@group(1) @binding(2) var base_sampler: sampler;

struct Varying {
    @builtin(position) @invariant clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) colour: vec4<f32>,
    @location(4) corner: vec3<f32>,
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
    let at = vec3<f32>(uv, 1.0);
    out.uv = vec2<f32>(dot(material.u.xyz, at), dot(material.v.xyz, at));
    out.colour = colour;
    let k = index % 3u;
    out.corner = vec3<f32>(f32(k == 0u), f32(k == 1u), f32(k == 2u));
    return out;
}

// A key lamp at the upper left, a weak one at the right, light from the sky and some from the
// ground.
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
    // Sampled before anything is thrown away: neighbours tell how far away the texture is.
    let texel = textureSample(base, base_sampler, in.uv);
    let spread = fwidth(in.corner);
    let mode = u32(shot.back.w);
    if (!front && (mode == 2u || (mode == 0u && material.flags.y < 0.5))) {
        discard;
    }
    var colour = material.colour * in.colour * texel;
    if (colour.a < material.flags.x) {
        discard;
    }
    if (material.flags.w < 0.5) {
        colour.a = 1.0;
    }
    if (!front && mode == 3u) {
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
    var shown = colour.rgb;
    if (material.flags.z < 0.5) {
        shown = lit(colour.rgb, normal, toward_eye);
    }
    if (shot.wire.w > 0.0) {
        // Distance from the nearest edge in pixels. Where triangles are hardly larger than the
        // line, it fades.
        let away = in.corner / max(spread, vec3<f32>(1e-6));
        let nearest = min(away.x, min(away.y, away.z));
        let half_width = 0.5 * shot.wire.w;
        let line = 1.0 - smoothstep(half_width - 0.5, half_width + 0.5, nearest);
        let largest = max(spread.x, max(spread.y, spread.z));
        let fade = clamp(1.6 - 2.4 * half_width * largest, 0.25, 1.0);
        shown = mix(shown, shot.wire.rgb, line * fade * 0.85);
        colour.a = max(colour.a, line * fade);
    }
    shown = min(shown, vec3<f32>(1.0));
    return vec4<f32>(shown * colour.a, colour.a);
}
