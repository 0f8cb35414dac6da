//! A verification that cannot fail proves nothing: every injected fault is found, in every buffer
//! and every kernel.

use crate::support::{device, models, reference};
use lodc_fixtures as fixtures;
use lodc_gpu::{Device, replay};
use lodc_lod::AnyModel;
use lodc_mesh::Mesh;
use lodc_model::Model;
use lodc_plan::{Contents, Plan, schedule};
use lodc_verify::Reference;
use std::sync::Arc;

/// Meshes with seams and several submeshes, in whose triangles no number is round.
fn everything() -> Vec<AnyModel> {
    let part = fixtures::named("machine_part").expect("a named shape");
    let odd = |mesh: &Mesh| mesh.submeshes().get(1).is_some_and(|s| s.first_triangle % 8 == 7);
    let random = (0..).map(fixtures::random).find(odd).expect("there are seeds for everything");
    [part, random]
        .into_iter()
        .flat_map(|mesh| models(fixtures::random_collapse(&mesh, 1)))
        .collect()
}

fn plans<'a>(model: &'a AnyModel, reference: &'a Reference<'_>) -> Vec<Plan<'a>> {
    let stops = schedule(model.simplified().collapses(), 12, 6, 1);
    model.replays(&stops, reference).expect("a small mesh")
}

/// Buffers that only hold what passes put there and that are not compared themselves: what is made
/// of them is.
const SCRATCH: &[&str] = &["sums of blocks", "live", "values", "strips", "strip_states"];

/// One bit of one word wrong, or a word lost, in whatever is uploaded.
#[test]
fn a_flipped_bit_in_any_uploaded_buffer_is_found() {
    let Some(device) = device() else { return };
    let mut injected = 0;
    for model in &everything()[..3] {
        injected += flip(&device, model);
    }
    assert!(injected >= 60, "only {injected} faults");
}

fn flip(device: &Device, model: &AnyModel) -> usize {
    let mut injected = 0;
    let reference = reference(model.simplified());
    let plans = || plans(model, &reference);
    for which in 0..plans().len() {
        let buffers = plans()[which].program.buffers.len();
        for buffer in 0..buffers {
            for place in [0, 1, 2] {
                let mut plan = plans().swap_remove(which);
                let name = plan.program.buffers[buffer].name;
                let Contents::Words(words) = &plan.program.buffers[buffer].contents else {
                    continue;
                };
                let mut damaged = words.to_vec();
                let at = (damaged.len() - 1) * place / 2;
                // High enough for every float and low enough for every index to stay a number.
                damaged[at] ^= 1;
                plan.program.buffers[buffer].contents = Contents::Words(Arc::from(damaged));
                let done = replay(device, plan).expect("the device goes on");
                assert!(
                    done.difference.is_some(),
                    "word {at} of {name} is wrong and nobody sees it"
                );
                injected += 1;
            }
        }
    }
    injected
}

/// A kernel, a piece of it, and something else in its place.
const FAULTS: &[(&str, &str, &str)] = &[
    // Construction.
    ("lists_length", "length = 1u;", "length = 2u;"),
    ("lists_length", "entry >= p.coarsest", "entry + 1u >= p.coarsest"),
    ("lists_length", "length >= p.longest", "length + 1u >= p.longest"),
    ("lists_fill", "current[v] = first;", "current[v] = first + 1u;"),
    ("lists_fill", "entries[i] = entry;", "entries[i] = v;"),
    ("scan", "distance < 256u", "distance < 128u"),
    ("scan", "inclusive_sums[local] - sum + before[k]", "inclusive_sums[local] + before[k]"),
    // Continuous extraction.
    ("extract", "v >= p.touched", "v + 1u >= p.touched"),
    (
        "extract",
        "while (at < last && entries[at] < p.lod)",
        "if (at < last && entries[at] < p.lod)",
    ),
    (
        "extract",
        "while (at > first && entries[at - 1u] >= p.lod)",
        "while (at > first && entries[at - 1u] > p.lod)",
    ),
    ("extract", "while (at > first && entries[at - 1u] >= p.lod) { at--; }", ""),
    ("extract", "current[v] = at;", ""),
    ("extract", "word < p.stride", "word < 4u"),
    ("extract", "source[from_record + 2u]", "source[from_record + 1u]"),
    ("live", "middle + 1u", "middle + 2u"),
    ("live", "same(a, b) || same(b, c)", "same(a, b)"),
    ("live", "draws[5u * s + 2u] = 3u * first", "draws[5u * s + 2u] = first"),
    // Masking Strips.
    ("masks", "collapse_to[entries[next].x]", "entries[next].x + collapse_to[0]"),
    ("masks", "entries[next - 1u].x >= p.lod", "entries[next - 1u].x > p.lod"),
    ("masks", "put(base, entries[next].y & 0xffffu, entries[next].x);", ""),
    ("masks", "mask = entries[next - 1u].y >> 16u", "mask = entries[next].y >> 16u"),
    ("masks", "count + select(0u, 1u, count > 0u)", "count"),
    ("masks_write", "firstTrailingBit(bits)", "firstLeadingBit(bits)"),
    ("masks_write", "0xffffffffu", "0xfffffffeu"),
    ("strip_draws", "draws[5u * s + 2u] = first", "draws[5u * s + 2u] = 0u"),
    // Speed Strips.
    ("edits", "collapse_to[e.x]", "collapse_to[e.x] + 1u"),
    ("edits", "strips[base + changes[i]] = e.x", "strips[base + changes[i]] = e.x + 1u"),
    ("edits", "read - period + k % period", "read - period"),
    ("edits", "changes[ends_end + k]", "changes[ends_end]"),
    ("edits", "ends_end -= size_of(r);", ""),
    ("edits", "return write;", "return length;"),
    ("values", "v < limit", "v <= limit"),
    ("rewrite", "index_removal_lods[i] > limit", "index_removal_lods[i] >= limit"),
    ("rewrite", "entries[middle].x < p.lod", "entries[middle].x <= p.lod"),
    ("lengths", "strip_states[s].y + 1u", "strip_states[s].y"),
    ("lengths", "p.lod < removal_lods[s]", "p.lod <= removal_lods[s]"),
    ("pack", "i + 1u < end", "i + 2u < end"),
    // Views.
    ("view", "if (link.y > lod) { break; }", ""),
    ("view", "while (entry < lod)", "while (entry < lod && entry == v)"),
    ("view", ">> 14u", ">> 15u"),
    ("view", "- r(complement(cosine) * sine)", ""),
    ("view", "square <= p.a", "square >= p.a"),
    ("view", "position.x <= p.a", "position.x > p.a"),
    ("view", "return select(p.lod_b, p.lod_a, inside);", "return p.lod_a;"),
    ("view", "removal_lod - length)", "removal_lod)"),
    ("view", "/ 8u + 1u", "/ 4u + 1u"),
    ("view", "bitcast<vec3<f32>>(entry_position(link.x))", "a"),
    ("view", "current = link.x;", "break;"),
    ("view", "entry_position(entry);", "entry_position(v);"),
    ("view", "r(share * r(b.y - a.y))", "r(share * b.y)"),
    ("view", "word < stride", "word < 4u"),
    ("filter_count", "equal & same(c, c.yzx)", "equal & same(c, c.yyx)"),
    ("filter_count", "drawn(c.yzw) << 3u", "drawn(c.yzw) << 2u"),
    ("filter_count", "countOneBits(bits)", "countOneBits(bits) + 1u"),
    ("filter_write", "3u * drawn_before[i]", "3u * drawn_before[i] + 3u"),
    ("filter_write", "indices[to + 2u]", "indices[to + 1u]"),
    ("filter_write", "bits >> 4u", "bits"),
    ("filter_draws", "draws[5u * s + 2u] = 3u * first", "draws[5u * s + 2u] = first"),
    ("filter_draws", "let rest = triangle % 8u", "let rest = 0u"),
    ("filter_draws", "drawn_before[triangle / 8u]", "drawn_before[0]"),
];

#[test]
fn a_fault_in_any_kernel_is_found() {
    let Some(device) = device() else { return };
    let meshes = everything();
    let references: Vec<_> = meshes.iter().map(|m| reference(m.simplified())).collect();
    let plans = || meshes.iter().zip(&references).flat_map(|(m, reference)| plans(m, reference));
    let (mut kernels, mut unseen): (Vec<&str>, Vec<(&str, &str)>) = (Vec::new(), Vec::new());
    for &(kernel, right, wrong) in FAULTS {
        let mut found = false;
        let concerned = |plan: &Plan<'_>| plan.program.kernels.iter().any(|k| k.name == kernel);
        for mut plan in plans().filter(concerned) {
            if found {
                break;
            }
            for k in plan.program.kernels.iter_mut().filter(|k| k.name == kernel) {
                assert!(k.wgsl.contains(right), "{kernel} has no {right:?}");
                k.wgsl = k.wgsl.replacen(right, wrong, 1);
                kernels.push(kernel);
            }
            found |= match replay(&device, plan) {
                Ok(done) => done.difference.is_some(),
                Err(e) => panic!("{kernel} with {wrong:?}: {e}"),
            };
        }
        if !found {
            unseen.push((kernel, wrong));
        }
    }
    assert!(unseen.is_empty(), "nobody sees {unseen:?}");
    // No kernel is left without a fault (adding up needs more than one block, which another test
    // has).
    for plan in plans() {
        for kernel in &plan.program.kernels {
            assert!(
                kernels.contains(&kernel.name) || kernel.name == "scan_add",
                "no fault was injected in {}",
                kernel.name
            );
        }
    }
}

/// Every buffer that passes write to is compared, or listed above.
#[test]
fn every_buffer_is_compared() {
    let meshes = everything();
    let references: Vec<_> = meshes.iter().map(|m| reference(m.simplified())).collect();
    for mut plan in meshes.iter().zip(&references).flat_map(|(m, reference)| plans(m, reference)) {
        let mut compared: Vec<usize> =
            plan.steps.by_ref().flat_map(|s| s.checks).map(|c| c.buffer.0).collect();
        compared.sort_unstable();
        for (i, buffer) in plan.program.buffers.iter().enumerate() {
            let name = buffer.name;
            assert!(
                compared.binary_search(&i).is_ok() || SCRATCH.contains(&name),
                "{}: {name} is never compared",
                plan.name
            );
        }
    }
}
