// Shaders of the WebGL 2 renderer: glTF's metallic-roughness material under a studio sky.

// mode: 0 the material, 1 painted colours of vertices, 2 baseColour alone. textureSets: the set of
// texture coordinates of base colour, metallic-roughness, normal and occlusion; -1 for no texture.
// copy: offset of a crowd's copy, and its turn about y in w. Constants of light are tuned by eye.

export const VERTEX = `#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv0;
layout(location = 3) in vec2 uv1;
layout(location = 4) in vec4 colour;
layout(location = 5) in vec4 joints;
layout(location = 6) in vec4 weights;
layout(location = 7) in vec4 paint;
layout(location = 8) in vec4 copy;
uniform mat4 world, viewProjection;
uniform vec3 centre;
uniform bool skinned;
uniform highp sampler2D jointMatrices;
out vec3 place, direction;
out vec2 first, second;
out vec4 tint, painted;

mat4 joint(float number) {
  int row = int(number);
  return mat4(
    texelFetch(jointMatrices, ivec2(0, row), 0), texelFetch(jointMatrices, ivec2(1, row), 0),
    texelFetch(jointMatrices, ivec2(2, row), 0), texelFetch(jointMatrices, ivec2(3, row), 0));
}

void main() {
  mat4 matrix = world;
  if (skinned) {
    matrix = joint(joints.x) * weights.x + joint(joints.y) * weights.y
      + joint(joints.z) * weights.z + joint(joints.w) * weights.w;
  }
  vec3 p = (matrix * vec4(position, 1.0)).xyz;
  mat3 linear = mat3(matrix);
  // Cofactors: normals stay right where a matrix mirrors or scales unevenly.
  vec3 n = mat3(cross(linear[1], linear[2]), cross(linear[2], linear[0]),
    cross(linear[0], linear[1])) * normal * sign(determinant(linear));
  float c = cos(copy.w), s = sin(copy.w);
  mat3 turn = mat3(c, 0.0, -s, 0.0, 1.0, 0.0, s, 0.0, c);
  place = turn * (p - centre) + centre + copy.xyz;
  direction = turn * n;
  first = uv0;
  second = uv1;
  tint = colour;
  painted = paint;
  gl_Position = viewProjection * vec4(place, 1.0);
}`;

export const FRAGMENT = `#version 300 es
precision highp float;
in vec3 place, direction;
in vec2 first, second;
in vec4 tint, painted;
uniform vec3 eye, keyLight, cameraRight, cameraUp;
uniform int mode;
uniform bool flatShaded, edgy, unlit;
uniform vec4 baseColour;
uniform vec3 emissive;
uniform float metallic, roughness, normalScale, occlusionStrength, alphaCutoff;
uniform ivec4 textureSets;
uniform int emissiveSet;
uniform mat3 uvTransform;
uniform sampler2D baseMap, metalMap, normalMap, occlusionMap, emissiveMap;
out vec4 result;

vec2 coordinates(int set) {
  return (uvTransform * vec3(set == 1 ? second : first, 1.0)).xy;
}

vec3 linear(vec3 c) { return pow(c, vec3(2.2)); }

// A bright ceiling, a light floor and two soft boxes; rougher surfaces see them blurred.
vec3 sky(vec3 d, float blur) {
  float soft = mix(0.25, 1.1, blur);
  vec3 light = mix(vec3(0.16, 0.155, 0.15), vec3(0.80, 0.84, 0.92),
    smoothstep(-soft, soft, d.y));
  float wide = mix(0.10, 0.85, blur);
  float box = smoothstep(1.0 - wide, 1.0, dot(d, normalize(keyLight + cameraRight * 0.35)));
  float side = smoothstep(1.0 - wide, 1.0, dot(d, normalize(cameraUp * 0.3 - cameraRight)));
  return light + mix(5.0, 0.55, blur) * box + mix(1.6, 0.22, blur) * side;
}

vec3 surfaceNormal() {
  vec3 flatNormal = normalize(cross(dFdx(place), dFdy(place)));
  if (flatShaded) return flatNormal;
  vec3 n = normalize(direction);
  if (!gl_FrontFacing) n = -n;
  // Generated normals are smooth; where a face turns far away from them there is a sharp edge.
  if (edgy) n = normalize(mix(flatNormal, n, smoothstep(0.72, 0.86, dot(n, flatNormal))));
  if (textureSets.z < 0 || mode != 0) return n;
  vec2 uv = coordinates(textureSets.z);
  // A tangent frame from derivatives on the screen.
  vec3 px = dFdx(place), py = dFdy(place);
  vec2 ux = dFdx(uv), uy = dFdy(uv);
  vec3 a = cross(py, n), b = cross(n, px);
  vec3 t = a * ux.x + b * uy.x, s = a * ux.y + b * uy.y;
  float size = inversesqrt(max(max(dot(t, t), dot(s, s)), 1e-30));
  vec3 m = texture(normalMap, uv).xyz * 2.0 - 1.0;
  return normalize(t * size * m.x * normalScale - s * size * m.y * normalScale + n * m.z);
}

vec3 shaded(vec3 colour, vec3 n, float metal, float rough, float open) {
  vec3 v = normalize(eye - place);
  vec3 l = normalize(keyLight);
  vec3 h = normalize(l + v);
  float nv = max(dot(n, v), 1e-3), nl = max(dot(n, l), 0.0), nh = max(dot(n, h), 0.0);
  float a = max(rough * rough, 2e-3), a2 = a * a;
  vec3 f0 = mix(vec3(0.04), colour, metal);
  vec3 fresnel = f0 + (1.0 - f0) * pow(1.0 - max(dot(v, h), 0.0), 5.0);
  float q = nh * nh * (a2 - 1.0) + 1.0;
  float lobe = a2 / (3.14159 * q * q) * 0.25
    / mix(nl * nv, 1.0, 0.5 * a + 0.02);
  vec3 diffuse = colour * (1.0 - metal);
  vec3 direct = (diffuse * 0.32 + fresnel * min(lobe, 12.0)) * nl * 1.9;
  // Environment after Karis, "Physically based shading on mobile" (2014).
  vec4 r = rough * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
  float e = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
  vec2 scale = vec2(-1.04, 1.04) * e + r.zw;
  vec3 around = diffuse * sky(n, 1.0) * 0.42
    + (f0 * scale.x + scale.y) * sky(reflect(-v, n), rough);
  return direct + around * open;
}

// Compresses highlights only (Khronos PBR Neutral).
vec3 displayed(vec3 c) {
  float low = min(c.r, min(c.g, c.b));
  c -= low < 0.08 ? low - 6.25 * low * low : 0.04;
  float peak = max(c.r, max(c.g, c.b));
  if (peak > 0.76) {
    float next = 1.0 - 0.0576 / (peak - 0.52);
    c = mix(c * next / peak, vec3(next), 1.0 - 1.0 / (0.15 * (peak - next) + 1.0));
  }
  return pow(max(c, 0.0), vec3(1.0 / 2.2));
}

void main() {
  if (mode == 2) {
    result = baseColour;
    return;
  }
  vec3 n = surfaceNormal();
  if (mode == 1) {
    vec3 colour = shaded(linear(painted.rgb), n, 0.0, 0.62, 1.0);
    result = vec4(displayed(colour), 1.0);
    return;
  }
  vec4 base = baseColour * tint;
  if (textureSets.x >= 0) {
    vec4 texel = texture(baseMap, coordinates(textureSets.x));
    base *= vec4(linear(texel.rgb), texel.a);
  }
  if (base.a < alphaCutoff) discard;
  float metal = metallic, rough = roughness, open = 1.0;
  if (textureSets.y >= 0) {
    vec4 texel = texture(metalMap, coordinates(textureSets.y));
    metal *= texel.b;
    rough *= texel.g;
  }
  if (textureSets.w >= 0) {
    open += occlusionStrength * (texture(occlusionMap, coordinates(textureSets.w)).r - 1.0);
  }
  vec3 glow = emissive;
  if (emissiveSet >= 0) glow *= linear(texture(emissiveMap, coordinates(emissiveSet)).rgb);
  vec3 colour = unlit ? base.rgb : shaded(base.rgb, n, metal, rough, open);
  result = vec4(displayed(colour + glow), alphaCutoff < 0.0 ? base.a : 1.0);
}`;
