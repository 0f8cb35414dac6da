// Which LOD each wedge group gets (after thesis 5.3, algorithm 6), one thread per group. Twin: select.rs.
// A group's vertices all read this one result, so that the surface cannot tear between them.

const SILHOUETTE: u32 = 0u;
const SCREEN: u32 = 1u;
const SPHERE: u32 = 2u;

struct Parameters {
    groups: u32,
    // Number of steps, and of records: the last vertex has the number `records`.
    steps: u32,
    records: u32,
    criterion: u32,
    morph: u32,
    // Silhouette: the LODs where the surface is seen edge-on and face-on. Regions: inside and outside.
    lod_a: u32,
    lod_b: u32,
    // The eye, or a sphere's centre, or a box's lowest corner.
    x: f32, y: f32, z: f32,
    // A power of two that brings lengths near 1.
    scale: f32,
    // Screen: allowed error per scaled distance. Sphere: squared scaled radius. Box: its highest corner.
    a: f32, b: f32, c: f32,
    // 0, which the compiler does not know: see `r`.
    zero: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// Six words per group: position; the axis of its cone of normals and the cosine of half the cone's angle, 16 bits each;
// one vertex of the group.
@group(0) @binding(1) var<storage, read> groups: array<u32>;
// Two words per record: where its step starts and where it ends.
@group(0) @binding(2) var<storage, read> step_of: array<u32>;
// The LOD after each step, and the error after each step.
@group(0) @binding(3) var<storage, read> step_ends: array<u32>;
@group(0) @binding(4) var<storage, read> step_errors: array<u32>;
@group(0) @binding(5) var<storage, read> offsets: array<u32>;
@group(0) @binding(6) var<storage, read> entries: array<u32>;
// The LOD that each group shows.
@group(0) @binding(7) var<storage, read_write> shown: array<u32>;
// Two words per group, with `morph` only: the LOD it moves towards, and how far it is on the way in 1/65536.
@group(0) @binding(8) var<storage, read_write> ways: array<u32>;

// Keeps the compiler from joining or reordering what is rounded in between.
fn r(v: f32) -> f32 { return bitcast<f32>(bitcast<u32>(v) ^ p.zero); }

fn dot3(a: vec3<f32>, b: vec3<f32>) -> f32 { return r(r(r(a.x * b.x) + r(a.y * b.y)) + r(a.z * b.z)); }

fn rsqrt(x: f32) -> f32 {
    var y = bitcast<f32>(0x5f3759dfu - (bitcast<u32>(x) >> 1u));
    let half = r(0.5 * x);
    for (var i = 0; i < 3; i++) {
        let square = r(r(half * y) * y);
        y = r(y * r(1.5 - square));
    }
    return y;
}

// The end of the last step that is over at a LOD: where the step of the next record starts.
fn rounded_down(lod: u32) -> u32 {
    if (lod >= p.records) { return p.records; }
    return step_of[2u * lod];
}

// How many steps have at most this error. Errors are not negative, so their bits sort like they do.
fn steps_within(error: f32) -> u32 {
    let bits = bitcast<u32>(error);
    var low = 0u;
    var high = p.steps;
    while (low < high) {
        let middle = (low + high) / 2u;
        if (step_errors[middle] <= bits) { low = middle + 1u; } else { high = middle; }
    }
    return low;
}

fn sixteen_bits(word: u32) -> vec2<f32> {
    return vec2<f32>(f32(i32(word << 16u) >> 16u), f32(i32(word) >> 16u)) * (1.0 / 32767.0);
}

// The sine to a cosine, both from 0 to 1.
fn other(cosine: f32) -> f32 {
    let rest = max(r(1.0 - r(cosine * cosine)), 1e-20);
    return r(rest * rsqrt(rest));
}

// From 0, seen edge-on somewhere in the cone, to 1, face-on everywhere.
fn facing(i: u32, to_eye: vec3<f32>, square: f32) -> f32 {
    let xy = sixteen_bits(groups[6u * i + 3u]);
    let packed = groups[6u * i + 4u];
    let axis = vec3<f32>(r(xy.x), r(xy.y), r(sixteen_bits(packed).x));
    let half_angle = r(f32(packed >> 16u) * (1.0 / 65536.0));
    let angle = min(r(abs(dot3(axis, to_eye)) * rsqrt(square)), 1.0);
    return max(r(r(angle * half_angle) - r(other(angle) * other(half_angle))), 0.0);
}

fn wanted(i: u32) -> u32 {
    let position = vec3<f32>(bitcast<f32>(groups[6u * i]), bitcast<f32>(groups[6u * i + 1u]), bitcast<f32>(groups[6u * i + 2u]));
    if (p.criterion > SPHERE) {
        let inside = position.x >= p.x && position.y >= p.y && position.z >= p.z
            && position.x <= p.a && position.y <= p.b && position.z <= p.c;
        return select(p.lod_b, p.lod_a, inside);
    }
    let d = vec3<f32>(r(r(p.x - position.x) * p.scale), r(r(p.y - position.y) * p.scale), r(r(p.z - position.z) * p.scale));
    let square = dot3(d, d);
    if (p.criterion == SPHERE) { return select(p.lod_b, p.lod_a, square <= p.a); }
    // In the eye: as fine as can be.
    if (square < 1e-30) { return select(0u, p.lod_a, p.criterion == SILHOUETTE); }
    if (p.criterion == SCREEN) {
        let steps = steps_within(r(r(square * rsqrt(square)) * p.a));
        if (steps == 0u) { return 0u; }
        return step_ends[steps - 1u];
    }
    let span = p.lod_b - p.lod_a;
    return p.lod_a + min(u32(r(facing(i, d, square) * f32(span))), span);
}

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) size: vec3<u32>) {
    let i = id.x + id.y * size.x * 256u;
    if (i >= p.groups) { return; }
    let lod = wanted(i);
    let end = rounded_down(lod);
    shown[i] = end;
    if (p.morph == 0u) { return; }

    // The group's own steps: the one that brought it to where it is at `end`, and the one that takes it away.
    let vertex = groups[6u * i + 5u];
    let first = offsets[vertex];
    var low = first;
    var high = offsets[vertex + 1u] - 1u;
    while (low < high) {
        let middle = (low + high) / 2u;
        if (entries[middle] < end) { low = middle + 1u; } else { high = middle; }
    }
    let entry = entries[low];
    var towards = end;
    var way = 0u;
    if (entry < p.records) {
        var came = 0u;
        if (low > first) { came = step_of[2u * entries[low - 1u] + 1u]; }
        towards = step_of[2u * entry + 1u];
        // Integers, because division of integers is exact. Both fit 16 bits after the shift.
        let shift = 16u - min(16u, countLeadingZeros(towards - came));
        way = min((((lod - came) >> shift) << 16u) / ((towards - came) >> shift), 65535u);
    }
    ways[2u * i] = towards;
    ways[2u * i + 1u] = way;
}
