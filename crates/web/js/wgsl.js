// Shaders of the WebGPU renderer: those of glsl.js in WGSL, so that both draw the same picture.

export const SHADERS = `
diagnostic(off, derivative_uniformity);

struct Frame {
  viewProjection: mat4x4<f32>,
  eye: vec3<f32>, padA: f32,
  centre: vec3<f32>, padB: f32,
  keyLight: vec3<f32>, padC: f32,
  cameraRight: vec3<f32>, padD: f32,
  cameraUp: vec3<f32>, padE: f32,
}

struct Draw {
  world: mat4x4<f32>,
  uvTransform: mat3x3<f32>,
  baseColour: vec4<f32>,
  emissive: vec3<f32>, alphaCutoff: f32,
  metallic: f32, roughness: f32, normalScale: f32, occlusionStrength: f32,
  // Sets of texture coordinates of base colour, metal and roughness, normals, occlusion; -1: none.
  sets: vec4<i32>,
  emissiveSet: i32, mode: u32, skinned: u32, flags: u32,
}

const FLAT = 1u;
const EDGY = 2u;
const UNLIT = 4u;

@group(0) @binding(0) var<uniform> f: Frame;
@group(0) @binding(1) var<uniform> d: Draw;
@group(1) @binding(0) var baseMap: texture_2d<f32>;
@group(1) @binding(1) var metalMap: texture_2d<f32>;
@group(1) @binding(2) var normalMap: texture_2d<f32>;
@group(1) @binding(3) var occlusionMap: texture_2d<f32>;
@group(1) @binding(4) var emissiveMap: texture_2d<f32>;
@group(1) @binding(5) var baseLook: sampler;
@group(1) @binding(6) var metalLook: sampler;
@group(1) @binding(7) var normalLook: sampler;
@group(1) @binding(8) var occlusionLook: sampler;
@group(1) @binding(9) var emissiveLook: sampler;
@group(2) @binding(0) var<storage, read> joints: array<mat4x4<f32>>;

struct Corner {
  @builtin(position) clip: vec4<f32>,
  @location(0) place: vec3<f32>,
  @location(1) direction: vec3<f32>,
  @location(2) uvs: vec4<f32>,
  @location(3) tint: vec4<f32>,
  @location(4) painted: vec4<f32>,
}

@vertex fn vertex(
  @location(0) position: vec3<f32>, @location(1) normal: vec3<f32>, @location(2) uvs: vec4<f32>,
  @location(3) colour: vec4<f32>, @location(4) joint: vec4<f32>, @location(5) weights: vec4<f32>,
  @location(6) paint: vec4<f32>, @location(7) copied: vec4<f32>,
) -> Corner {
  var matrix = d.world;
  if (d.skinned != 0u) {
    matrix = joints[u32(joint.x)] * weights.x + joints[u32(joint.y)] * weights.y
      + joints[u32(joint.z)] * weights.z + joints[u32(joint.w)] * weights.w;
  }
  let p = (matrix * vec4(position, 1.0)).xyz;
  let linear = mat3x3(matrix[0].xyz, matrix[1].xyz, matrix[2].xyz);
  let n = mat3x3(cross(linear[1], linear[2]), cross(linear[2], linear[0]),
    cross(linear[0], linear[1])) * normal * sign(determinant(linear));
  let c = cos(copied.w);
  let s = sin(copied.w);
  let turn = mat3x3(c, 0.0, -s, 0.0, 1.0, 0.0, s, 0.0, c);
  let place = turn * (p - f.centre) + f.centre + copied.xyz;
  return Corner(f.viewProjection * vec4(place, 1.0), place, turn * n, uvs, colour, paint);
}

fn coordinates(uvs: vec4<f32>, number: i32) -> vec2<f32> {
  return (d.uvTransform * vec3(select(uvs.xy, uvs.zw, number == 1), 1.0)).xy;
}

fn toLinear(c: vec3<f32>) -> vec3<f32> { return pow(c, vec3(2.2)); }

// A bright ceiling, a light floor and two soft boxes; rougher surfaces see them blurred.
fn sky(ray: vec3<f32>, blur: f32) -> vec3<f32> {
  let soft = mix(0.25, 1.1, blur);
  let light = mix(vec3(0.16, 0.155, 0.15), vec3(0.80, 0.84, 0.92), smoothstep(-soft, soft, ray.y));
  let wide = mix(0.10, 0.85, blur);
  let key = normalize(f.keyLight + f.cameraRight * 0.35);
  let box = smoothstep(1.0 - wide, 1.0, dot(ray, key));
  let side = smoothstep(1.0 - wide, 1.0, dot(ray, normalize(f.cameraUp * 0.3 - f.cameraRight)));
  return light + mix(5.0, 0.55, blur) * box + mix(1.6, 0.22, blur) * side;
}

fn surfaceNormal(in: Corner, front: bool) -> vec3<f32> {
  // Rows go down here, and up in WebGL.
  let px = dpdx(in.place);
  let py = -dpdy(in.place);
  let flatNormal = normalize(cross(px, py));
  if ((d.flags & FLAT) != 0u) { return flatNormal; }
  var n = normalize(in.direction);
  if (!front) { n = -n; }
  // Made normals are round; where a face turns far away from them there is a sharp edge.
  if ((d.flags & EDGY) != 0u) {
    n = normalize(mix(flatNormal, n, smoothstep(0.72, 0.86, dot(n, flatNormal))));
  }
  if (d.sets.z < 0 || d.mode != 0u) { return n; }
  let uv = coordinates(in.uvs, d.sets.z);
  let ux = dpdx(uv);
  let uy = -dpdy(uv);
  let a = cross(py, n);
  let b = cross(n, px);
  let t = a * ux.x + b * uy.x;
  let s = a * ux.y + b * uy.y;
  let size = inverseSqrt(max(max(dot(t, t), dot(s, s)), 1e-30));
  let m = textureSample(normalMap, normalLook, uv).xyz * 2.0 - 1.0;
  return normalize(t * size * m.x * d.normalScale - s * size * m.y * d.normalScale + n * m.z);
}

fn shaded(
  place: vec3<f32>, colour: vec3<f32>, n: vec3<f32>, metal: f32, rough: f32, open: f32,
) -> vec3<f32> {
  let v = normalize(f.eye - place);
  let l = normalize(f.keyLight);
  let h = normalize(l + v);
  let nv = max(dot(n, v), 1e-3);
  let nl = max(dot(n, l), 0.0);
  let nh = max(dot(n, h), 0.0);
  let a = max(rough * rough, 2e-3);
  let a2 = a * a;
  let f0 = mix(vec3(0.04), colour, metal);
  let fresnel = f0 + (1.0 - f0) * pow(1.0 - max(dot(v, h), 0.0), 5.0);
  let q = nh * nh * (a2 - 1.0) + 1.0;
  let lobe = a2 / (3.14159 * q * q) * 0.25 / mix(nl * nv, 1.0, 0.5 * a + 0.02);
  let diffuse = colour * (1.0 - metal);
  let direct = (diffuse * 0.32 + fresnel * min(lobe, 12.0)) * nl * 1.9;
  // Environment after Karis, "Physically based shading on mobile" (2014).
  let r = rough * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
  let e = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
  let scale = vec2(-1.04, 1.04) * e + r.zw;
  let around = diffuse * sky(n, 1.0) * 0.42
    + (f0 * scale.x + scale.y) * sky(reflect(-v, n), rough);
  return direct + around * open;
}

// Compresses highlights only (Khronos PBR Neutral).
fn displayed(linear: vec3<f32>) -> vec3<f32> {
  let low = min(linear.r, min(linear.g, linear.b));
  var c = linear - select(0.04, low - 6.25 * low * low, low < 0.08);
  let peak = max(c.r, max(c.g, c.b));
  if (peak > 0.76) {
    let next = 1.0 - 0.0576 / (peak - 0.52);
    c = mix(c * next / peak, vec3(next), 1.0 - 1.0 / (0.15 * (peak - next) + 1.0));
  }
  return pow(max(c, vec3(0.0)), vec3(1.0 / 2.2));
}

@fragment fn fragment(in: Corner, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
  if (d.mode == 2u) { return d.baseColour; }
  let n = surfaceNormal(in, front);
  if (d.mode == 1u) {
    return vec4(displayed(shaded(in.place, toLinear(in.painted.rgb), n, 0.0, 0.62, 1.0)), 1.0);
  }
  var base = d.baseColour * in.tint;
  if (d.sets.x >= 0) {
    let texel = textureSample(baseMap, baseLook, coordinates(in.uvs, d.sets.x));
    base *= vec4(toLinear(texel.rgb), texel.a);
  }
  var metal = d.metallic;
  var rough = d.roughness;
  var open = 1.0;
  if (d.sets.y >= 0) {
    let texel = textureSample(metalMap, metalLook, coordinates(in.uvs, d.sets.y));
    metal *= texel.b;
    rough *= texel.g;
  }
  if (d.sets.w >= 0) {
    let texel = textureSample(occlusionMap, occlusionLook, coordinates(in.uvs, d.sets.w));
    open += d.occlusionStrength * (texel.r - 1.0);
  }
  var glow = d.emissive;
  if (d.emissiveSet >= 0) {
    glow *= toLinear(textureSample(emissiveMap, emissiveLook,
      coordinates(in.uvs, d.emissiveSet)).rgb);
  }
  if (base.a < d.alphaCutoff) { discard; }
  var colour = base.rgb;
  if ((d.flags & UNLIT) == 0u) { colour = shaded(in.place, base.rgb, n, metal, rough, open); }
  return vec4(displayed(colour + glow), select(1.0, base.a, d.alphaCutoff < 0.0));
}`;
