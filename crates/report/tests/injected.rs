//! A verification that cannot fail proves nothing: defects are injected into files whose checksums
//! are right, and each is reported, with the sentence that names it.
//!
//! Changes after which a file is still right, so that no check can find them, are listed in
//! [`EQUIVALENT`].

use lodc_formats::import::{ImportOptions, import};
use lodc_formats::lodc::{LodFile, MadeFrom, StoredModel, read, write};
use lodc_formats::{Document, GltfDocument, Limits};
use lodc_lod::ModelKind;
use lodc_mesh::{CollapseSequence, Mesh, MeshParts, PoseKey, Semantic, SequenceParts, Simplified};
use lodc_report::{check_errors_again, check_models, check_source};
use lodc_simplify::MetricKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A file of one object, taken apart.
struct Parts {
    file: LodFile<StoredModel>,
    mesh: MeshParts,
    sequence: SequenceParts,
}

impl Parts {
    fn of(bytes: &[u8]) -> Self {
        let mut file = read(bytes, &ModelKind::ALL.map(ModelKind::name)).expect("a sound file");
        let empty = Mesh::try_from(MeshParts::default()).expect("a mesh of nothing");
        let none = CollapseSequence::try_from(SequenceParts::default()).expect("no records");
        let empty = Arc::new(Simplified::new(empty, none).expect("both are empty"));
        let whole = std::mem::replace(&mut file.objects[0].simplified, empty);
        let (mesh, sequence) = Arc::unwrap_or_clone(whole).into_parts();
        Self { file, mesh: mesh.into_parts(), sequence: sequence.into_parts() }
    }

    /// The bytes of the file with everything put back; an error if the types themselves refuse it.
    fn bytes(self) -> Result<Vec<u8>, String> {
        let Self { mut file, mesh, sequence } = self;
        let mesh = Mesh::try_from(mesh).map_err(|e| e.to_string())?;
        let sequence = CollapseSequence::try_from(sequence).map_err(|e| e.to_string())?;
        let whole = Simplified::new(mesh, sequence).map_err(|e| e.to_string())?;
        if let Some(object) = file.objects.first_mut() {
            object.simplified = Arc::new(whole);
        }
        Ok(write(&file, |model, _| model.clone()))
    }

    /// A step in the middle of those that change what is seen: triangles die in it.
    fn step(&self) -> usize {
        let triangles = &self.sequence.step_triangles;
        let half = triangles.partition_point(|&t| t > self.sequence.triangles / 2);
        (half..triangles.len()).find(|&i| triangles[i] < triangles[i - 1]).expect("they all die")
    }

    /// The first record of that step.
    fn record(&self) -> usize {
        self.sequence.step_ends[self.step() - 1] as usize
    }

    /// A step of several records before that one.
    fn long_step(&self) -> usize {
        let ends = &self.sequence.step_ends;
        (1..ends.len()).find(|&i| ends[i] > ends[i - 1] + 1).expect("a seam")
    }

    /// The array of a model.
    fn array(&mut self, model: &str, array: &str) -> &mut Vec<u8> {
        let models = &mut self.file.objects[0].models;
        let model = models.iter_mut().find(|m| m.name == model).expect("all models are there");
        let array = model.arrays.iter_mut().find(|a| a.name == array);
        &mut array.expect("an array of that name").bytes
    }

    fn scale_errors(&mut self, by: f32) {
        let finite = self.sequence.step_errors.iter_mut().filter(|error| error.is_finite());
        finite.for_each(|error| *error *= by);
        self.scale_rms(1.0);
    }

    /// No root mean square distance is above the error.
    fn scale_rms(&mut self, by: f32) {
        for (rms, &error) in self.sequence.step_rms.iter_mut().zip(&self.sequence.step_errors) {
            *rms = if rms.is_finite() { (*rms * by).min(error) } else { *rms };
        }
    }

    fn attribute(&mut self, semantic: &Semantic) -> &mut lodc_mesh::Attribute {
        let all = &mut self.mesh.attributes;
        all.iter_mut().find(|a| a.semantic == *semantic).expect("a stream of that meaning")
    }

    fn json(&mut self, from: &str, to: &str) {
        let Document::Gltf(document) = &mut self.file.document else {
            panic!("the fixture is a glTF")
        };
        let json = document.json();
        assert!(json.contains(from), "{from} is not in {json}");
        *document = GltfDocument::new(json.replacen(from, to, 1), document.blob().to_vec());
    }
}

/// The name of a defect, the function that injects it, and a part of a sentence that reports it; of
/// equivalent changes the reason why none can.
type Defect = (&'static str, fn(&mut Parts), &'static str);

/// In `machine_part.glb` (three submeshes, seams, normals and texture coordinates), without models:
/// the facts of a sequence have to be seen without them.
const SEQUENCE: &[Defect] = &[
    (
        "a target beyond the neighbours",
        |p| {
            let k = p.record();
            p.sequence.targets[k] = p.sequence.targets.len() as u32;
        },
        "LOD 120 has 242 triangles, 240 are stored",
    ),
    (
        "a target that is the next vertex",
        |p| {
            let k = p.record();
            p.sequence.targets[k] = k as u32 + 1;
        },
        "triangle 46 gets a vertex of another submesh at LOD 120",
    ),
    (
        "the targets of two records exchanged",
        |p| {
            let k = p.long_step();
            let first = p.sequence.step_ends[k - 1] as usize;
            p.sequence.targets.swap(first - 1, first);
        },
        "the mesh is torn at LOD 122",
    ),
    (
        "a wedge that stays behind its group",
        |p| {
            let i = p.long_step();
            let k = p.sequence.step_ends[i] as usize - 1;
            p.sequence.targets[k] = p.sequence.step_ends[i];
        },
        "record 121 leaves or reaches another position than its step",
    ),
    (
        "a corner that goes to another submesh",
        |p| {
            let (mesh, targets) = (&p.mesh, &mut p.sequence.targets);
            let other = |k: usize| {
                let target = targets[k] as usize;
                let same = |v: &usize| mesh.positions[*v] == mesh.positions[target];
                let submesh = |v: usize| mesh.vertex_submesh[v];
                (k + 1..mesh.positions.len()).filter(same).find(|&v| submesh(v) != submesh(target))
            };
            let (k, v) =
                (0..targets.len()).find_map(|k| Some((k, other(k)?))).expect("submeshes meet");
            targets[k] = v as u32;
        },
        "triangle 40 gets a vertex of another submesh at LOD 1",
    ),
    (
        "the end of a step one record later",
        |p| {
            let i = p.long_step() - 1;
            p.sequence.step_ends[i] += 1;
        },
        "record 120 leaves or reaches another position than its step",
    ),
    (
        "two steps that are one",
        |p| {
            let i = p.step();
            p.sequence.step_ends.remove(i);
            p.sequence.step_errors.remove(i);
            p.sequence.step_rms.remove(i);
            p.sequence.step_triangles.remove(i);
        },
        "record 120 leaves or reaches another position than its step",
    ),
    (
        "a step that is two",
        |p| {
            let i = p.long_step();
            let end = p.sequence.step_ends[i] - 1;
            p.sequence.step_ends.insert(i, end);
            for curve in [&mut p.sequence.step_errors, &mut p.sequence.step_rms] {
                let value = curve[i];
                curve.insert(i, value);
            }
            let triangles = p.sequence.step_triangles[i];
            p.sequence.step_triangles.insert(i, triangles);
        },
        "the mesh is torn at LOD 121",
    ),
    (
        "a triangle that dies a step later",
        |p| {
            let i = p.step();
            p.sequence.step_triangles[i] += 1;
        },
        "LOD 120 has 240 triangles, 241 are stored",
    ),
    (
        "a triangle that dies a step earlier",
        |p| {
            let i = p.step() - 1;
            p.sequence.step_triangles[i] = p.sequence.step_triangles[i + 1];
        },
        "LOD 119 has 242 triangles, 240 are stored",
    ),
    (
        "a fake that nothing becomes",
        |p| {
            let mut used = vec![false; p.mesh.positions.len()];
            p.mesh.triangles.as_flattened().iter().for_each(|&v| used[v as usize] = true);
            let fake = (0..used.len()).find(|&v| !used[v]).expect("fakes");
            let next = p.sequence.targets[fake];
            let onto = p.sequence.targets.iter_mut().filter(|t| **t as usize == fake);
            onto.for_each(|target| *target = next);
        },
        "vertex 344, unused at LOD 0, is not made by a collapse",
    ),
    (
        "a triangle that is the last one of its submesh",
        |p| {
            let last = p.mesh.submeshes[0].triangles().end - 1;
            p.mesh.triangles.swap(0, last);
        },
        "triangle 1 comes after one that dies before it",
    ),
    ("a triangle that shows its back", |p| p.mesh.triangles[0].swap(1, 2), "is only in the source"),
];

/// In the same file with all its models.
const DEFECTS: &[Defect] = &[
    // The mesh.
    (
        "a triangle turned over",
        |p| p.mesh.triangles[0].swap(1, 2),
        "speed: extra triangle (47, 48, 314) of submesh 0 at LOD 0",
    ),
    (
        "two triangles of one submesh turned over",
        |p| {
            p.mesh.triangles[0].swap(1, 2);
            p.mesh.triangles[1].swap(1, 2);
        },
        "masking: extra triangle (47, 48, 314) of submesh 0 at LOD 0",
    ),
    (
        "every triangle turned over",
        |p| {
            p.mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        },
        "masking: missing triangle (0, 1, 180) of submesh 0 at LOD 0",
    ),
    (
        "a triangle twice, and another gone",
        |p| p.mesh.triangles[1] = p.mesh.triangles[0],
        "LOD 358 has 3 triangles, 2 are stored",
    ),
    (
        "a corner that is another vertex",
        |p| {
            let [a, b, c] = p.mesh.triangles[0];
            let other = |&v: &u32| {
                p.mesh.vertex_submesh[v as usize] == p.mesh.vertex_submesh[a as usize]
                    && [a, b, c]
                        .iter()
                        .all(|&w| p.mesh.positions[w as usize] != p.mesh.positions[v as usize])
            };
            let v = (0..p.mesh.positions.len() as u32)
                .find(other)
                .expect("a submesh has more vertices");
            p.mesh.triangles[0][0] = v;
        },
        "triangle 0 gets a vertex of another submesh at LOD 345",
    ),
    ("a vertex that moved", |p| p.mesh.positions[0][1] += 0.25, "is only in the source"),
    (
        "a vertex that moved by the last bit",
        |p| {
            let x = &mut p.mesh.positions[0][0];
            *x = f32::from_bits(x.to_bits() ^ 1);
        },
        "is only in the source",
    ),
    (
        "a mesh of twice the size",
        |p| {
            p.mesh.positions.as_flattened_mut().iter_mut().for_each(|x| *x *= 2.0);
        },
        "errors hold: LOD",
    ),
    (
        "a normal's lowest bit",
        |p| p.attribute(&Semantic::Normal).bytes[0] ^= 1,
        "is only in the source",
    ),
    (
        "normals that say they are tangents",
        |p| {
            p.attribute(&Semantic::Normal).semantic = Semantic::Custom("_NORMAL".to_owned());
        },
        "the file [TexCoord(0), Custom(\"_NORMAL\")]",
    ),
    (
        "texture coordinates gone",
        |p| {
            p.mesh.attributes.retain(|a| a.semantic == Semantic::Normal);
            let count = p.mesh.attributes.len() as u32;
            p.mesh.submeshes.iter_mut().for_each(|s| s.attributes.retain(|&a| a < count));
        },
        "the source has the streams [Normal, TexCoord(0)], the file [Normal]",
    ),
    (
        "the normals of two vertices exchanged",
        |p| {
            let normals = p.attribute(&Semantic::Normal);
            let other =
                (1..normals.bytes.len() as u32 / 12).find(|&v| normals.at(v) != normals.at(0));
            let other = other.expect("normals differ") as usize;
            for byte in 0..12 {
                normals.bytes.swap(byte, 12 * other + byte);
            }
        },
        "is only in the file",
    ),
    (
        "a stream that counts from 0 to 1",
        |p| {
            let normals = p.attribute(&Semantic::Normal);
            normals.component = lodc_mesh::Component::U32;
        },
        "the source has the streams",
    ),
    // Curves.
    ("errors that are 0", |p| p.scale_errors(0.0), "the error is 0, but 0."),
    ("errors of half the size", |p| p.scale_errors(0.5), "errors hold: LOD"),
    ("errors of 0.9 of the size", |p| p.scale_errors(0.9), "errors measured again: LOD"),
    ("errors of 1.5 times the size", |p| p.scale_errors(1.5), "errors measured again: LOD"),
    ("errors of four times the size", |p| p.scale_errors(4.0), "no point is farther than 0."),
    ("errors of ten times the size", |p| p.scale_errors(10.0), "no point is farther than 0."),
    (
        "the errors of three steps as large as that of a later one",
        |p| {
            let i = p.step();
            let later = p.sequence.step_errors[i + 3];
            p.sequence.step_errors[i..i + 3].fill(later);
        },
        "errors measured again: LOD 120: the error is 0.07",
    ),
    (
        "the error of one step as small as that before it",
        |p| {
            let errors = &mut p.sequence.step_errors;
            let rises = |i: &usize| errors[*i].is_finite() && errors[*i] > errors[i - 1];
            let i = (1..errors.len()).rfind(rises).expect("errors rise");
            errors[i] = errors[i - 1];
            p.scale_rms(1.0);
        },
        "errors hold: LOD 358: the error is 2.6",
    ),
    (
        "errors a step later",
        |p| {
            let i =
                p.sequence.step_errors.iter().rposition(|e| e.is_finite()).expect("finite ones");
            p.sequence.step_errors.copy_within(0..i, 1);
            p.scale_rms(1.0);
        },
        "LOD 122: the error is 0, measured again",
    ),
    (
        "root mean squares that are 0",
        |p| p.scale_rms(0.0),
        "the root mean square distance is 0, but 0.0",
    ),
    (
        "root mean squares of 0.5 of the size",
        |p| p.scale_rms(0.5),
        "the root mean square distance is",
    ),
    ("root mean squares of 0.9 of the size", |p| p.scale_rms(0.9), "errors measured again: LOD"),
    (
        "root mean squares of twelve times the size",
        |p| p.scale_rms(12.0),
        "the root mean square distance is",
    ),
    ("root mean squares that are the errors", |p| p.scale_rms(f32::MAX), "errors hold: LOD"),
    // Models.
    (
        "a vertex of a Speed strip",
        |p| {
            let bytes = p.array("speed", "strips");
            let last = bytes.len() - 2;
            bytes[last] ^= 1;
        },
        "the array \"strips\" has a vertex that does not exist",
    ),
    (
        "an edit of a Speed strip",
        |p| {
            let bytes = p.array("speed", "removals");
            let middle = bytes.len() / 2;
            bytes[middle] ^= 4;
        },
        "the array \"removals\" removes what is not there",
    ),
    (
        "a vertex of a Masking strip",
        |p| {
            let bytes = p.array("masking", "strips");
            let last = bytes.len() - 2;
            bytes[last] ^= 1;
        },
        "missing triangle",
    ),
    (
        "the strips of another model",
        |p| {
            let strips = p.array("masking", "strips").clone();
            *p.array("speed", "strips") = strips;
        },
        "the array \"removals\" ends early",
    ),
    (
        "the end of an array gone",
        |p| {
            p.array("masking", "strips").pop();
        },
        "the array \"strips\" has another length than its strips",
    ),
    (
        "two vertices of a Masking strip exchanged",
        |p| {
            let bytes = p.array("masking", "strips");
            let end = bytes.len();
            // Two bytes each; the first and third corner of the last triangle.
            bytes.swap(end - 2, end - 6);
            bytes.swap(end - 1, end - 5);
        },
        "masking, fine to coarse: masking: ",
    ),
    // What is around the meshes.
    (
        "an object of another name",
        |p| "other".clone_into(&mut p.file.objects[0].info.name),
        "an object is named other, in the source mesh0",
    ),
    (
        "a submesh of another primitive",
        |p| {
            let submeshes = &mut p.file.objects[0].info.submeshes;
            let first = submeshes[0].document_primitive;
            submeshes[0].document_primitive = submeshes[1].document_primitive;
            submeshes[1].document_primitive = first;
        },
        "mesh0: other names, materials or places in the document",
    ),
    (
        "another world scale",
        |p| p.file.objects[0].info.world_scale *= 2.0,
        "the world scale is 2, of the source 1",
    ),
    (
        "a material's colour",
        |p| p.json("\"baseColorFactor\":[", "\"baseColorFactor\":[0,"),
        "materials[0].pbrMetallicRoughness.baseColorFactor: is",
    ),
    (
        "a material's name",
        |p| p.json("\"materials\":[{\"name\":\"", "\"materials\":[{\"name\":\"un"),
        "materials[0].name: is",
    ),
    (
        "a node that moved",
        |p| p.json("\"nodes\":[{", "\"nodes\":[{\"translation\":[0,1,0],"),
        "nodes[0].translation: is new",
    ),
    ("an object gone", |p| p.file.objects.clear(), "the source has 1 objects, the file 0"),
];

/// In `morphing_sphere.glb`, whose errors are the largest over poses.
const POSED: &[Defect] = &[
    ("poses gone", |p| p.file.objects[0].info.poses.clear(), "LOD 1: the error is 0.0"),
    (
        "another morph target's pose",
        |p| {
            for pose in &mut p.file.objects[0].info.poses {
                if let PoseKey::Target(number) = pose {
                    *number += 1;
                }
            }
        },
        "measured again",
    ),
    (
        "a pose gone",
        |p| {
            p.file.objects[0].info.poses.pop();
        },
        "LOD 1: the error is 0.0",
    ),
    (
        "a morph target's offsets",
        |p| {
            let all = &mut p.mesh.attributes;
            let target = all.iter_mut().find(|a| a.morph_target.is_some()).expect("a target");
            target.bytes[3] ^= 1;
        },
        "is only in the source",
    ),
];

/// In `skinned_tube_u8.glb`, which has joints.
const MOVING: &[Defect] = &[
    (
        "a moment of an animation that is not there",
        |p| {
            p.file.objects[0].info.poses.push(PoseKey::Moment { animation: 7, seconds: 0.5 });
        },
        "pose 1 is of an animation that is not there",
    ),
    ("a joint's weight", |p| p.attribute(&Semantic::Weights(0)).bytes[0] ^= 1, "is only in"),
];

/// In `machine_part.glb`, made by another program, whose numbers need not be those of this one:
/// independent samples see them.
const FOREIGN: &[Defect] = &[
    ("errors that are 0", |p| p.scale_errors(0.0), "the error is 0, but"),
    ("errors of half the size", |p| p.scale_errors(0.5), ", but 0."),
    ("errors of four times the size", |p| p.scale_errors(4.0), "no point is farther than"),
    ("errors of ten times the size", |p| p.scale_errors(10.0), "no point is farther than"),
    (
        "root mean squares that are 0",
        |p| p.scale_rms(0.0),
        "the root mean square distance is 0, but",
    ),
    (
        "root mean squares of a tenth of the size",
        |p| p.scale_rms(0.1),
        "the root mean square distance is",
    ),
    (
        "root mean squares of twelve times the size",
        |p| p.scale_rms(12.0),
        "the root mean square distance is",
    ),
];

/// Changes after which a file is still right, and why.
const EQUIVALENT: &[Defect] = &[
    (
        "estimates in the place of errors",
        |p| {
            p.sequence.step_rms.clear();
            p.sequence.step_errors.iter_mut().for_each(|e| *e *= 0.9);
        },
        "the file says that it knows less, and promises nothing",
    ),
    (
        "another last legal level",
        |p| {
            p.sequence.last_legal_lod = p
                .sequence
                .step_ends
                .first()
                .map_or(p.sequence.last_legal_lod, |&e| lodc_mesh::Lod(e));
        },
        "what the simplifier says of its way; no level depends on it",
    ),
    (
        "another number of changes of topology",
        |p| p.sequence.topology_changes += 1,
        "what the simplifier says of its way; no level depends on it",
    ),
    (
        "another key of what it was made from",
        |p| {
            p.file.made_from.as_mut().expect("it is known").key ^= 1;
        },
        "it says whether the file is up to date, not what is in it",
    ),
    (
        "another hash of the source",
        |p| p.file.source.content_hash ^= 1,
        "the mesh is compared itself; where it is looked for by its hash it is not assert_reported",
    ),
    (
        "two triangles that die together exchanged",
        |p| {
            let last = p.mesh.submeshes[0].triangles().end - 1;
            p.mesh.triangles.swap(last - 1, last);
        },
        "the order of triangles that die in one step carries no meaning",
    ),
    (
        "indices of four bytes",
        |p| p.file.layout = lodc_formats::lodc::Layout::Gpu,
        "the same numbers in another width",
    ),
];

/// A built fixture, as `lodc build` writes it.
fn built(fixture: &str) -> (PathBuf, Vec<u8>) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").join(fixture);
    let file = lodc::build(&path).metric(MetricKind::Quadric).models(&ModelKind::ALL).run();
    let bytes = file.expect("a fixture").to_bytes();
    let mut file = lodc::read(&bytes).expect("a file that was just made");
    let scene = import(&path, &ImportOptions::default()).expect("a fixture");
    file.made_from = MadeFrom::of(&path, &scene.files, "", &[]);
    assert!(file.made_from.as_ref().is_some_and(MadeFrom::is_of_this_version));
    (path, lodc::write(&file))
}

/// Every sentence of `lodc verify FILE --source MESH` about a difference; none if there is none.
fn sentences(bytes: &[u8], source: &Path) -> Vec<String> {
    let file = match lodc::read(bytes) {
        Ok(file) => file,
        Err(refused) => return vec![format!("refused: {refused}")],
    };
    let limits = Limits::DEFAULT;
    let checks = || {
        let mut all = check_models(&file.objects, &file.document, 1, &limits)?;
        all.extend(check_errors_again(&file, &limits)?);
        all.extend(check_source(&file, source, &ImportOptions::default())?);
        Ok(all)
    };
    let checks = checks().map_err(|e: lodc_formats::FormatError| e.to_string());
    match checks {
        Err(refused) => vec![format!("refused: {refused}")],
        Ok(checks) => checks
            .into_iter()
            .filter_map(|check| Some((check.model, check.check, check.first_difference?)))
            .map(|(model, check, what)| format!("{model}, {check}: {what}"))
            .collect(),
    }
}

/// Asserts that each defect, injected in a fixture that `change` has prepared, is reported.
fn assert_reported(defects: &[Defect], fixture: &str, change: fn(&mut Parts)) {
    let (source, bytes) = built(fixture);
    let mut parts = Parts::of(&bytes);
    change(&mut parts);
    let bytes = parts.bytes().expect("a sound file");
    assert_eq!(sentences(&bytes, &source), [""; 0], "nothing is injected");
    let missed = |&(name, inject, sentence): &Defect| {
        let mut parts = Parts::of(&bytes);
        inject(&mut parts);
        let sentences = match parts.bytes() {
            Ok(injected) => {
                assert!(injected != bytes, "{name}: changes nothing");
                sentences(&injected, &source)
            }
            Err(refused) => vec![format!("refused: {refused}")],
        };
        let is_named = sentences.iter().any(|text| text.contains(sentence));
        (!is_named).then(|| format!("{name}: {sentences:#?}"))
    };
    let missed: Vec<String> = defects.iter().filter_map(missed).collect();
    assert!(missed.is_empty(), "{missed:#?}");
}

#[test]
fn what_is_equivalent_passes() {
    let (source, bytes) = built("machine_part.glb");
    for (name, inject, why) in EQUIVALENT {
        let mut parts = Parts::of(&bytes);
        parts.file.objects[0].models.clear();
        inject(&mut parts);
        let injected = parts.bytes().expect("a file that can be read");
        assert_eq!(sentences(&injected, &source), [""; 0], "{name}: {why}");
    }
}

#[test]
fn defects_of_sequences_are_named() {
    assert_reported(SEQUENCE, "machine_part.glb", |p| p.file.objects[0].models.clear());
}

#[test]
fn defects_of_files_are_named() {
    assert_reported(DEFECTS, "machine_part.glb", |_| {});
}

#[test]
fn defects_of_poses_are_named() {
    assert_reported(POSED, "morphing_sphere.glb", |_| {});
    assert_reported(MOVING, "skinned_tube_u8.glb", |_| {});
}

#[test]
fn defects_of_distances_are_named_whoever_made_the_file() {
    assert_reported(FOREIGN, "machine_part.glb", |p| {
        p.file.objects[0].models.clear();
        p.file.made_from = None;
    });
}
