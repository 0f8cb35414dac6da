//! A file in a window, with its triangles' edges; W and S walk nearer and away:
//! `cargo run --features window --example window -- part.lodc`

use bevy::pbr::wireframe::{WireframeConfig, WireframePlugin};
use bevy::prelude::*;
use lodc_bevy::{LevelOfDetail, LodEye, Lodc, LodcPlugin};

#[derive(Resource)]
struct Shown(Handle<Lodc>);

fn main() {
    let path = std::env::args().nth(1).expect("usage: window FILE.lodc");
    let path = std::fs::canonicalize(path).expect("the file is there");
    let folder = path.parent().expect("a file lies in a folder").to_string_lossy().into_owned();
    let name = path.file_name().expect("a file has a name").to_string_lossy().into_owned();
    let assets = AssetPlugin { file_path: folder, ..default() };
    App::new()
        .add_plugins((DefaultPlugins.set(assets), WireframePlugin::default(), LodcPlugin))
        .insert_resource(WireframeConfig { global: true, ..default() })
        .add_systems(Startup, move |mut commands: Commands, server: Res<AssetServer>| {
            commands.insert_resource(Shown(server.load(name.clone())));
            let eye = LodEye { pixels: 4.0, ..default() };
            commands.spawn((Camera3d::default(), eye, Transform::from_xyz(0.0, 0.0, 5.0)));
            commands.spawn((
                DirectionalLight::default(),
                Transform::from_rotation(Quat::from_rotation_x(-0.7)),
            ));
        })
        .add_systems(Update, (spawn, walk))
        .run();
}

/// Spawns the scene as soon as it has come, in front of the camera.
fn spawn(
    mut commands: Commands,
    shown: Res<Shown>,
    files: Res<Assets<Lodc>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    bare: Query<Entity, (With<LevelOfDetail>, Without<MeshMaterial3d<StandardMaterial>>)>,
    mut camera: Single<&mut Transform, With<Camera3d>>,
    mut done: Local<bool>,
) {
    for entity in &bare {
        let material = materials.add(Color::srgb(0.8, 0.75, 0.7));
        commands.entity(entity).insert(MeshMaterial3d(material));
    }
    if let Some(file) = files.get(&shown.0).filter(|_| !*done) {
        file.spawn(&shown.0, &mut commands);
        let first = &file.objects[0];
        camera.translation = first.centre + Vec3::Z * 3.0 * first.radius;
        *done = true;
    }
}

/// Walks along the view, as fast as the object is far away.
fn walk(
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time>,
    mut camera: Single<&mut Transform, With<Camera3d>>,
) {
    let ahead = f32::from(keys.pressed(KeyCode::KeyW)) - f32::from(keys.pressed(KeyCode::KeyS));
    let step = ahead * time.delta_secs() * camera.translation.length();
    camera.translation.z -= step;
}
