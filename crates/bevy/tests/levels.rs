//! An app without a window: a file is loaded, an eye walks away, levels change; meshes are those
//! that `lodc extract --no-refit` writes. `LODC` names the program; without it the library writes
//! them.

use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, AssetServer, Assets, Handle, LoadState};
use bevy_ecs::entity::Entity;
use bevy_ecs::system::RunSystemOnce;
use bevy_ecs::system::{Commands, Res};
use bevy_math::Vec3;
use bevy_mesh::{Indices, Mesh, Mesh3d, MeshVertexAttribute, VertexAttributeValues};
use bevy_transform::TransformPlugin;
use bevy_transform::components::{GlobalTransform, Transform};
use lodc::formats::import::{ImportOptions, import};
use lodc::mesh::Semantic;
use lodc_bevy::{LevelOfDetail, LevelTarget, LodEye, Lodc, LodcPlugin, LodcSettings};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A folder that is gone when the test is.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("lodc-bevy-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder can be made");
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn fixture_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures").join(name)
}

/// An app that has loaded a file made of a fixture.
fn app(folder: &Folder, fixture: &str, settings: LodcSettings) -> (App, Handle<Lodc>) {
    let file = lodc::build(fixture_path(fixture)).run().expect("a fixture");
    file.write(folder.0.join("part.lodc")).expect("it can be written");
    loaded(folder, |server| {
        let load =
            server.load_builder().with_settings(move |s: &mut LodcSettings| *s = settings.clone());
        load.load("part.lodc")
    })
}

/// An app that has loaded something out of a folder.
fn loaded(folder: &Folder, load: impl FnOnce(&AssetServer) -> Handle<Lodc>) -> (App, Handle<Lodc>) {
    let mut app = App::new();
    let file_path = folder.0.to_string_lossy().into_owned();
    let assets = AssetPlugin { file_path, ..AssetPlugin::default() };
    app.add_plugins((TaskPoolPlugin::default(), assets, TransformPlugin, LodcPlugin));
    let server = app.world().resource::<AssetServer>().clone();
    let handle = load(&server);
    for _ in 0..10_000 {
        app.update();
        match server.load_state(&handle) {
            LoadState::Loaded => return (app, handle),
            LoadState::Failed(why) => panic!("{why}"),
            _ => std::thread::sleep(std::time::Duration::from_millis(1)),
        }
    }
    panic!("the file does not come");
}

type Rows = Vec<Vec<u32>>;

/// Triangles as the bits of their corners' values, the smallest corner first, sorted.
fn rows(triangles: impl Iterator<Item = [Vec<f32>; 3]>) -> Rows {
    let turned = |t: [Vec<f32>; 3]| {
        let mut corners = t.map(|c| c.into_iter().map(|v| (v + 0.0).to_bits()).collect::<Vec<_>>());
        let first = (0..3).min_by_key(|&i| corners[i].clone()).expect("three corners");
        corners.rotate_left(first);
        corners.concat()
    };
    let mut all: Rows = triangles.map(turned).collect();
    all.sort_unstable();
    all
}

/// The triangles of an asset: places, normals and texture coordinates of their corners.
fn asset(mesh: &Mesh, with: &[MeshVertexAttribute]) -> Rows {
    let Some(Indices::U32(indices)) = mesh.indices() else { panic!("no indices") };
    let value = |name: &MeshVertexAttribute, v: usize| match mesh.attribute(*name) {
        Some(VertexAttributeValues::Float32x3(all)) => all[v].to_vec(),
        Some(VertexAttributeValues::Float32x2(all)) => all[v].to_vec(),
        other => panic!("{other:?}"),
    };
    let corner =
        |&v: &u32| with.iter().flat_map(|name| value(name, v as usize)).collect::<Vec<_>>();
    rows(indices.as_chunks::<3>().0.iter().map(|t| t.each_ref().map(corner)))
}

/// The same of each submesh of a GLB that was extracted.
fn extracted(path: &Path, semantics: &[Semantic]) -> Vec<Rows> {
    let scene = import(path, &ImportOptions::default()).expect("a level");
    let mesh = &scene.objects[0].mesh;
    let corner = |&v: &u32| {
        let mut all = mesh.positions()[v as usize].to_vec();
        for semantic in semantics {
            let stream = mesh.attributes().iter().find(|a| a.semantic == *semantic);
            let stream = stream.expect("the attribute");
            all.extend((0..usize::from(stream.components)).map(|i| stream.value(v, i)));
        }
        all
    };
    let of = |s: &lodc::mesh::Submesh| {
        rows(mesh.triangles()[s.triangles()].iter().map(|t| t.each_ref().map(corner)))
    };
    mesh.submeshes().iter().map(of).collect()
}

#[test]
fn meshes_are_those_that_extract_writes() {
    let shares = [1.0, 0.3, 0.1];
    for (fixture, with) in [("machine_part.glb", 1), ("terrain.obj", 2), ("uv_sphere.obj", 2)] {
        let folder = Folder::new(fixture);
        let settings = LodcSettings { levels: shares.map(LevelTarget::Ratio).to_vec() };
        let (app, handle) = app(&folder, fixture, settings);
        let assets = app.world().resource::<Assets<Mesh>>();
        let file = app.world().resource::<Assets<Lodc>>().get(&handle).expect("it is there");
        let names = [Mesh::ATTRIBUTE_POSITION, Mesh::ATTRIBUTE_NORMAL, Mesh::ATTRIBUTE_UV_0];
        let semantics = [Semantic::Normal, Semantic::TexCoord(0)];
        for (level, share) in file.objects[0].levels.iter().zip(shares) {
            let [lodc, glb] = ["part.lodc", "level.glb"].map(|name| folder.0.join(name));
            match std::env::var_os("LODC") {
                Some(program) => {
                    let mut extract = Command::new(program);
                    extract.args(["extract", "--no-refit", "-q"]).arg(&lodc);
                    extract.args(["--ratio", &share.to_string()]);
                    assert!(extract.arg("-o").arg(&glb).status().expect("it runs").success());
                }
                None => {
                    let file = lodc::open(&lodc).expect("a file");
                    let level = file.level(lodc::Select::Ratio(share)).expect("a level");
                    level.write(&glb).expect("it can be written");
                }
            }
            let written = extracted(&glb, &semantics[..with]);
            let meshes = level.meshes.iter().filter(|m| **m != Handle::default());
            let made: Vec<Rows> = meshes
                .map(|m| asset(assets.get(m).expect("it is loaded"), &names[..=with]))
                .collect();
            assert_eq!(made.iter().map(Vec::len).sum::<usize>(), level.triangles as usize);
            assert!(made == written, "{fixture} at {share}");
        }
    }
}

#[test]
fn an_eye_that_walks_away_sees_coarser_levels() {
    let folder = Folder::new("walk");
    let (mut app, handle) = app(&folder, "terrain.glb", LodcSettings::default());
    let spawn = {
        let handle = handle.clone();
        move |mut commands: Commands, files: Res<Assets<Lodc>>| {
            files.get(&handle).expect("it is there").spawn(&handle, &mut commands);
        }
    };
    app.world_mut().run_system_once(spawn).expect("it spawns");
    let eye = app.world_mut().spawn(LodEye::default()).id();
    let world = app.world_mut();
    let shown: Vec<Entity> =
        world.query::<(Entity, &LevelOfDetail)>().iter(world).map(|(entity, _)| entity).collect();
    assert!(!shown.is_empty());
    let mut seen = Vec::new();
    for distance in [0.0, 1.0, 4.0, 16.0, 64.0, 256.0, 1024.0, 1e5] {
        let at = Transform::from_translation(Vec3::new(0.0, 0.0, distance));
        app.world_mut().entity_mut(eye).insert(at);
        app.update();
        let world = app.world();
        let file = world.resource::<Assets<Lodc>>().get(&handle).expect("it is there");
        for &entity in &shown {
            let of = world.get::<LevelOfDetail>(entity).expect("it stays");
            let object = &file.objects[of.object];
            let level = of.level.expect("the file has come");
            let mesh = &world.get::<Mesh3d>(entity).expect("it has one").0;
            assert_eq!(*mesh, object.levels[level].meshes[of.submesh]);
            // What is shown cannot be seen to err, and the next level could.
            let place = world.get::<GlobalTransform>(entity).expect("it has a place");
            let away = place.transform_point(object.centre).distance(at.translation);
            let allowed = LodEye::default().allowed((away - object.radius).max(0.0));
            assert!(object.levels[level].error <= allowed || level == 0, "{distance}");
            let next = object.levels.get(level + 1);
            assert!(next.is_none_or(|next| next.error > allowed), "{distance}");
        }
        seen.push(world.get::<LevelOfDetail>(shown[0]).expect("it stays").level);
    }
    assert!(seen.is_sorted(), "{seen:?}");
    let distinct: std::collections::BTreeSet<_> = seen.iter().collect();
    assert!(seen[0] == Some(0) && distinct.len() >= 4, "{seen:?}");
    // Nothing changes where nothing moves.
    app.update();
    assert_eq!(app.world().get::<LevelOfDetail>(shown[0]).expect("it stays").level, seen[7]);
}

#[test]
fn damage_fails_to_load() {
    let folder = Folder::new("damage");
    let (app, _) = app(&folder, "uv_sphere.glb", LodcSettings::default());
    std::fs::write(folder.0.join("other.lodc"), b"junk").expect("it can be written");
    let server = app.world().resource::<AssetServer>().clone();
    let (mut app, handle) = (app, server.load::<Lodc>("other.lodc"));
    for _ in 0..10_000 {
        app.update();
        if let LoadState::Failed(why) = server.load_state(&handle) {
            assert!(why.to_string().contains("not a .lodc file"), "{why}");
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    panic!("it does not fail");
}

/// Levels of a chain are those that it was told to have, with the errors that it states, and are
/// chosen as those of a `.lodc` file are.
#[cfg(feature = "chain")]
#[test]
fn a_chain_has_the_levels_that_it_states() {
    let program = std::env::var_os("LODC").expect("LODC names the program");
    for (fixture, shape) in [("machine_part.glb", None), ("terrain.glb", Some("--index-ranges"))] {
        let folder = Folder::new(&format!("chain-{fixture}"));
        let glb = folder.0.join("chain.glb");
        let mut chain = Command::new(&program);
        chain.arg("chain").arg(fixture_path(fixture)).arg("-o").arg(&glb).args(shape);
        chain.args(["--levels", "100%,40%,10%,3%", "--json", "-q"]);
        let report = chain.output().expect("it runs").stdout;
        let report: serde_json::Value = serde_json::from_slice(&report).expect("a report");
        let stated = report["levels"].as_array().expect("levels");
        let (app, handle) = loaded(&folder, |server| server.load("chain.glb"));
        let meshes = app.world().resource::<Assets<Mesh>>();
        let file = app.world().resource::<Assets<Lodc>>().get(&handle).expect("it is there");
        let object = &file.objects[0];
        assert_eq!(object.levels.len(), 4, "{fixture}");
        for (level, stated) in object.levels.iter().zip(stated) {
            assert_eq!(Some(u64::from(level.triangles)), stated["triangles"].as_u64(), "{fixture}");
            assert_eq!(
                Some(f64::from(level.error)),
                stated["error"].as_f64().map(|e| f64::from(e as f32))
            );
            assert_eq!(level.meshes.len(), object.materials.len());
            let shown = level.meshes.iter().filter(|mesh| **mesh != Handle::default());
            let triangles: usize =
                shown.map(|mesh| asset(meshes.get(mesh).expect("it is loaded"), &[]).len()).sum();
            assert_eq!(triangles, level.triangles as usize);
        }
        // Near the finest, far away the coarsest.
        let eye = LodEye::default();
        let level_at = |distance: f32| {
            let at = GlobalTransform::from_translation(Vec3::new(0.0, 0.0, distance));
            object.seen(&GlobalTransform::IDENTITY, std::iter::once((&eye, &at)))
        };
        assert_eq!([level_at(0.0), level_at(1e7)], [0, 3], "{fixture}");
        assert!(!file.placements.is_empty());
    }
}
