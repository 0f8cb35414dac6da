// The view-dependent extraction pass (thesis 5.3, algorithm 6), one thread per vertex: chooses a
// LOD, shows what the vertex has become by then, and with `morph` moves it towards where its next
// collapse leads once that is near. Twin: select.rs and mod.rs. All vertices of a wedge group have
// one position and one cone here, so they choose the same LOD and nothing tears.

// Constants of a pipeline: compilers leave out what is not asked for.
// 0: outline, 1: error on the screen, 2: sphere, 3: box, 4: what is on the screen.
override criterion: u32 = 0u;
override morph: bool = false;
// Words of a vertex record.
override stride: u32 = 3u;

struct Parameters {
    vertices: u32,
    // Error on the screen: upper 18 bits of the smallest error that counts, as of a float. What is
    // on the screen: the bits of the tangent of half its height.
    lowest: u32,
    // Outline: the LODs where the surface is seen edge-on and face-on. Regions: inside and outside.
    lod_a: u32,
    lod_b: u32,
    // The eye, or a sphere's centre, or a box's lowest corner.
    x: f32, y: f32, z: f32,
    // A power of two that brings lengths near 1. What is on the screen: the tangent of half its
    // width.
    scale: f32,
    // Outline: LODs per cosine, and the sine of a cone that 1 stands for. Screen: allowed error per
    // scaled distance. Sphere: squared scaled radius. Box: its highest corner.
    // What is on the screen: x, y, z of the unit quaternion that turns places into eye space.
    a: f32, b: f32, c: f32,
    // 0, which the compiler does not know: see `r`.
    zero: u32,
}

@group(0) @binding(0) var<uniform> p: Parameters;
// Position, and a cone of normals: its axis, of any length, and the sine of half its angle times
// 255, 8 bits each.
@group(0) @binding(1) var<storage, read> points: array<vec4<u32>>;
// What each vertex becomes, and the LOD at which it has: the end of the step.
@group(0) @binding(2) var<storage, read> links: array<vec2<u32>>;
const ERRORS = 7168u;
// The coarsest LOD for each error from the lowest on, 512 of them from one power of two to the
// next.
@group(0) @binding(3) var<storage, read> by_error: array<u32>;
// Records of the mesh, and as they are drawn.
@group(0) @binding(4) var<storage, read> source: array<u32>;
@group(0) @binding(5) var<storage, read_write> vertices: array<u32>;

// Keeps the compiler from joining or reordering what is rounded in between.
fn r(v: f32) -> f32 { return bitcast<f32>(bitcast<u32>(v) ^ p.zero); }

fn dot3(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return r(r(r(a.x * b.x) + r(a.y * b.y)) + r(a.z * b.z));
}

// One step of Newton's method.
fn nearer(y: f32, half: f32) -> f32 { return r(y * r(1.5 - r(r(half * y) * y))); }

fn rsqrt(x: f32) -> f32 {
    let half = r(0.5 * x);
    return nearer(nearer(bitcast<f32>(0x5f3759dfu - (bitcast<u32>(x) >> 1u)), half), half);
}

// The sine to a cosine and the other way round, both from 0 to 1.
fn complement(cosine: f32) -> f32 {
    let rest = max(r(1.0 - r(cosine * cosine)), 1e-20);
    return r(rest * rsqrt(rest));
}

// From 0, seen edge-on somewhere in the cone, to 1, face-on everywhere.
fn facing(cone: u32, to_eye: vec3<f32>, square: f32) -> f32 {
    let bytes = vec3<u32>(cone << 24u, cone << 16u, cone << 8u);
    let axis = vec3<f32>(vec3<i32>(bytes) >> vec3<u32>(24u));
    let sine = r(f32(cone >> 24u) * p.b);
    let angle = min(r(abs(dot3(axis, to_eye)) * rsqrt(r(dot3(axis, axis) * square))), 1.0);
    return max(r(r(angle * complement(sine)) - r(complement(angle) * sine)), 0.0);
}

fn cross3(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(
        r(r(a.y * b.z) - r(a.z * b.y)),
        r(r(a.z * b.x) - r(a.x * b.z)),
        r(r(a.x * b.y) - r(a.y * b.x)),
    );
}

// Ahead of the eye and within the screen.
fn on_screen(position: vec3<f32>) -> bool {
    let d = vec3<f32>(r(position.x - p.x), r(position.y - p.y), r(position.z - p.z));
    let rotation = vec3<f32>(p.a, p.b, p.c);
    let rest = max(r(1.0 - dot3(rotation, rotation)), 1e-20);
    let w = r(rest * rsqrt(rest));
    let doubled = 2.0 * cross3(rotation, d);
    let second = cross3(rotation, doubled);
    let x = r(r(d.x + r(w * doubled.x)) + second.x);
    let y = r(r(d.y + r(w * doubled.y)) + second.y);
    let z = r(r(d.z + r(w * doubled.z)) + second.z);
    return abs(x) <= r(-z * p.scale) && abs(y) <= r(-z * bitcast<f32>(p.lowest));
}

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
    // At the viewpoint itself: as fine as can be.
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

// The share of its move that a vertex which disappears at the end of some step (`leaves`) has
// made at a LOD before it, in 1/65536: it begins to move n/8 records before, n vertices staying
// longer.
// Integers, because division of integers is exact; both fit 16 bits after the shift.
fn morph_progress(leaves: u32, lod: u32) -> u32 {
    let length = min(leaves, (p.vertices - min(leaves, p.vertices)) / 8u + 1u);
    let records_gone = lod - min(lod, leaves - length);
    let shift = 16u - min(16u, countLeadingZeros(length));
    return min(((records_gone >> shift) << 16u) / (length >> shift), 65535u);
}

@compute @workgroup_size(WORKGROUP)
fn main(thread: Thread) {
    let v = number_of(thread);
    if (v >= p.vertices) { return; }
    let lod = wanted_lod(points[v]);
    // As far as the collapses go whose steps are over.
    var entry = v;
    while (entry < lod) {
        let link = links[entry];
        if (link.y > lod) { break; }
        entry = link.x;
    }
    // From the record: all points of a group have the position of its first one, which may have
    // zeros of another sign.
    var position = entry_position(entry);
    if (morph) {
        // To where its target is, which may be on its way too.
        var current = entry;
        var share = 1.0;
        var position_now = bitcast<vec3<f32>>(position);
        loop {
            let link = links[current];
            let records_gone = morph_progress(link.y, lod);
            if (records_gone == 0u) { break; }
            share = r(share * (f32(records_gone) * (1.0 / 65536.0)));
            // Too small to change the result, as is all that follows.
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
        // Exactly where it was: its bits, also those of a zero.
        position = select(bitcast<vec3<u32>>(position_now), position, current == entry);
    }
    let to_record = v * stride;
    vertices[to_record] = position.x;
    vertices[to_record + 1u] = position.y;
    vertices[to_record + 2u] = position.z;
    // Whatever else a record has.
    let from_record = entry * stride;
    for (var word = 3u; word < stride; word++) {
        vertices[to_record + word] = source[from_record + word];
    }
}
