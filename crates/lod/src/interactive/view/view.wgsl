// The view-dependent extraction pass (thesis of Ripollés, 5.3, algorithm 6), one thread per
// vertex: chooses a LOD by a criterion, writes the vertex record (position and attributes) of what
// the vertex has become at that LOD, and with `morph` moves it towards its next target some time
// before that collapse. A wedge group is the vertices of one position that collapse together; all
// of them have one entry in `points`, so they choose the same LOD and the surface does not tear.
// CPU code that does the same, in the same order of operations: select.rs and mod.rs.
// `Thread`, `number_of` and `WORKGROUP` are in prelude.wgsl.

// Constants of a pipeline, so that compilers leave out the code of other criteria.
// 0: outline (finer where the surface is seen edge-on), 1: error on the screen, 2: sphere, 3: box,
// 4: what is on the screen.
override criterion: u32 = 0u;
override morph: bool = false;
// Words of a vertex record; the first three are the position.
override stride: u32 = 3u;

struct Parameters {
    vertices: u32,
    // Criterion 1: the upper 18 bits of the error, a float, of the first word of `by_error`.
    // Criterion 4: the bits of a float, the tangent of half the screen's height.
    lowest: u32,
    // Criterion 0: the LODs where the surface is seen edge-on (a) and face-on (b). Criteria 2 to 4:
    // the LODs inside (a) and outside (b).
    lod_a: u32,
    lod_b: u32,
    // The eye; criterion 2: the sphere's centre; criterion 3: the box's lowest corner.
    x: f32, y: f32, z: f32,
    // A power of two by which lengths are multiplied to bring them near 1. Criterion 4: the tangent
    // of half the screen's width.
    scale: f32,
    // Criterion 0: a: LODs per unit of `facing`, b: the factor from the stored sine of a cone to
    // its sine. Criterion 1: a: allowed error per scaled distance. Criterion 2: a: the squared
    // scaled radius. Criterion 3: the box's highest corner. Criterion 4: x, y, z of the unit
    // quaternion that rotates the world into eye space.
    a: f32, b: f32, c: f32,
    // Always 0, which the compiler does not know: see `r`.
    zero: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// For each vertex x, y, z: the bits of its position at LOD 0, w: a cone that holds the normals
// around it, in bytes from the lowest: its axis (three signed bytes, of any length), and the sine
// of half its angle times 255.
@group(0) @binding(1) var<storage, read> points: array<vec4<u32>>;
// For each vertex x: its target, y: the LOD from which on the target is shown in its place, the end
// of a step (all records of one collapse).
@group(0) @binding(2) var<storage, read> links: array<vec2<u32>>;
// The coarsest LOD for each of `ERRORS` errors in rising order.
@group(0) @binding(3) var<storage, read> by_error: array<u32>;
// Vertex records of LOD 0.
@group(0) @binding(4) var<storage, read> source: array<u32>;
// Vertex records as they are drawn.
@group(0) @binding(5) var<storage, read_write> vertices: array<u32>;

// Words of `by_error`: 14 powers of two, 512 errors of each (`ByError` in select.rs).
const ERRORS = 7168u;

// Returns its argument, in a way that keeps the compiler from fusing or reordering the operations
// before and after: each is rounded by itself, as on the CPU.
fn r(v: f32) -> f32 { return bitcast<f32>(bitcast<u32>(v) ^ p.zero); }

fn dot3(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return r(r(r(a.x * b.x) + r(a.y * b.y)) + r(a.z * b.z));
}

// One step of Newton's method towards the inverse square root of x, from an estimate y; `half` is
// x / 2.
fn newton_step(y: f32, half: f32) -> f32 { return r(y * r(1.5 - r(r(half * y) * y))); }

// 1 / sqrt(x), the same on every device, which the built-in `inverseSqrt` need not be. The constant
// is the usual first estimate by the bits of a float.
fn rsqrt(x: f32) -> f32 {
    let half = r(0.5 * x);
    let estimate = bitcast<f32>(0x5f3759dfu - (bitcast<u32>(x) >> 1u));
    return newton_step(newton_step(estimate, half), half);
}

// The sine of an angle from its cosine, or the cosine from its sine; both from 0 to 1.
fn complement(cosine: f32) -> f32 {
    let squared = max(r(1.0 - r(cosine * cosine)), 1e-20);
    return r(squared * rsqrt(squared));
}

// From 0, where some normal of the cone is seen edge-on, to 1, where all are seen face-on. `square`
// is the squared length of `to_eye`.
fn facing(cone: u32, to_eye: vec3<f32>, square: f32) -> f32 {
    let bytes = vec3<u32>(cone << 24u, cone << 16u, cone << 8u);
    let axis = vec3<f32>(vec3<i32>(bytes) >> vec3<u32>(24u));
    let sine = r(f32(cone >> 24u) * p.b);
    let cosine = min(r(abs(dot3(axis, to_eye)) * rsqrt(r(dot3(axis, axis) * square))), 1.0);
    return max(r(r(cosine * complement(sine)) - r(complement(cosine) * sine)), 0.0);
}

fn cross3(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        r(r(a.y * b.z) - r(a.z * b.y)),
        r(r(a.z * b.x) - r(a.x * b.z)),
        r(r(a.x * b.y) - r(a.y * b.x)),
    );
}

// Whether a position is ahead of the eye and within the screen.
fn on_screen(position: vec3<f32>) -> bool {
    let d = vec3<f32>(r(position.x - p.x), r(position.y - p.y), r(position.z - p.z));
    let rotation = vec3<f32>(p.a, p.b, p.c);
    let squared = max(r(1.0 - dot3(rotation, rotation)), 1e-20);
    let w = r(squared * rsqrt(squared));
    // Rotated by the unit quaternion (rotation, w).
    let doubled = 2.0 * cross3(rotation, d);
    let second = cross3(rotation, doubled);
    let x = r(r(d.x + r(w * doubled.x)) + second.x);
    let y = r(r(d.y + r(w * doubled.y)) + second.y);
    let z = r(r(d.z + r(w * doubled.z)) + second.z);
    return abs(x) <= r(-z * p.scale) && abs(y) <= r(-z * bitcast<f32>(p.lowest));
}

// The LOD that the criterion asks for at a point.
fn wanted_lod(point: vec4<u32>) -> u32 {
    let position = bitcast<vec3<f32>>(point.xyz);
    if (criterion == 4u) { return select(p.lod_b, p.lod_a, on_screen(position)); }
    if (criterion == 3u) {
        let inside = position.x >= p.x && position.y >= p.y && position.z >= p.z
            && position.x <= p.a && position.y <= p.b && position.z <= p.c;
        return select(p.lod_b, p.lod_a, inside);
    }
    let d = vec3<f32>(
        r(r(p.x - position.x) * p.scale),
        r(r(p.y - position.y) * p.scale),
        r(r(p.z - position.z) * p.scale),
    );
    let square = dot3(d, d);
    if (criterion == 2u) { return select(p.lod_b, p.lod_a, square <= p.a); }
    // At the eye itself directions have no meaning: the finest LOD of the criterion.
    let away_from_eye = square >= 1e-30;
    if (criterion == 1u) {
        let error = bitcast<u32>(r(r(square * rsqrt(square)) * p.a)) >> 14u;
        let lod = by_error[clamp(error, p.lowest, p.lowest + ERRORS - 1u) - p.lowest];
        return select(0u, lod, away_from_eye);
    }
    let span = p.lod_b - p.lod_a;
    let rise = min(r(facing(point.w, d, square) * p.a), f32(span));
    return p.lod_a + select(0u, min(u32(rise), span), away_from_eye);
}

// The bits of a vertex's position.
fn entry_position(v: u32) -> vec3<u32> {
    let first = v * stride;
    return vec3<u32>(source[first], source[first + 1u], source[first + 2u]);
}

// The part of its move, in 1/65536, that a vertex has made at a LOD. It disappears at
// `removal_lod`, the end of a step, and begins to move n/8 records before, n being the number of
// vertices that remain longer.
//
// Integers, because division of integers is exact; both fit 16 bits after the shift.
fn morph_progress(removal_lod: u32, lod: u32) -> u32 {
    let length = min(removal_lod, (p.vertices - min(removal_lod, p.vertices)) / 8u + 1u);
    let records_moved = lod - min(lod, removal_lod - length);
    let shift = 16u - min(16u, countLeadingZeros(length));
    return min(((records_moved >> shift) << 16u) / (length >> shift), 65535u);
}

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let v = number_of(thread);
    if (v >= p.vertices) { return; }
    let lod = wanted_lod(points[v]);
    // Follows the collapses whose steps are complete at the LOD.
    var entry = v;
    while (entry < lod) {
        let link = links[entry];
        if (link.y > lod) { break; }
        entry = link.x;
    }
    // From the record, not from `points`: all of a group have the position of its first vertex
    // there, whose zeros may have another sign.
    var position = entry_position(entry);
    if (morph) {
        // Towards its target, which may be moving towards its own target, and so on.
        var current = entry;
        var share = 1.0;
        var position_now = bitcast<vec3<f32>>(position);
        loop {
            let link = links[current];
            let progress = morph_progress(link.y, lod);
            if (progress == 0u) { break; }
            share = r(share * (f32(progress) * (1.0 / 65536.0)));
            // Too small to change the result, as are all moves that follow.
            if (share < 1e-7) { break; }
            let a = bitcast<vec3<f32>>(entry_position(current));
            let b = bitcast<vec3<f32>>(entry_position(link.x));
            position_now = vec3<f32>(
                r(position_now.x + r(share * r(b.x - a.x))),
                r(position_now.y + r(share * r(b.y - a.y))),
                r(position_now.z + r(share * r(b.z - a.z))),
            );
            current = link.x;
        }
        // A vertex that has not moved keeps its bits, also the sign of a zero.
        position = select(bitcast<vec3<u32>>(position_now), position, current == entry);
    }
    let to_record = v * stride;
    vertices[to_record] = position.x;
    vertices[to_record + 1u] = position.y;
    vertices[to_record + 2u] = position.z;
    // The attributes.
    let from_record = entry * stride;
    for (var word = 3u; word < stride; word++) {
        vertices[to_record + word] = source[from_record + word];
    }
}
