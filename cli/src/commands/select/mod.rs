//! `lodc select`: which level suits a distance, or every instance of a scene under a budget.

mod model;
mod scene;

use crate::console;
use crate::exit::{Failure, Outcome};
use crate::help::{LEVEL, MORE, OUTPUT, SEEN};
use crate::limits::LimitArgs;
use crate::selector::ScreenArgs;
use crate::views::point;
use clap::Args;
use lodc_report::text::{distance, grouped};
use lodc_report::{ErrorsOver, SCHEMA_VERSION};
use lodc_select::parse::count;
use lodc_select::{Goal, Instance, SceneManager, decimal};
use model::Model;
use serde::Serialize;
use std::path::PathBuf;

/// Options of `select`.
#[derive(Args, Debug)]
#[command(after_help = MORE, after_long_help = EXAMPLES)]
pub(crate) struct SelectArgs {
    /// The .lodc file to choose a level of
    #[arg(required_unless_present = "scene", conflicts_with = "scene")]
    file: Option<PathBuf>,
    /// Pixels that the error may take on the screen
    #[arg(long, value_name = "P", value_parser = positive, help_heading = LEVEL,
          required_unless_present = "budget", conflicts_with = "budget")]
    pixels: Option<f32>,
    /// Distance of the eye from the model's nearest point, in world units
    #[arg(long, value_name = "D", value_parser = positive, help_heading = LEVEL,
          required_unless_present = "scene", conflicts_with = "scene")]
    distance: Option<f32>,
    /// Choose for every instance of a scene, one in each line of FILE
    ///
    /// {"file": PATH, "position": [X, Y, Z], "scale": S}; scale may be left out.
    #[arg(long, value_name = "FILE", requires = "eye", help_heading = LEVEL)]
    scene: Option<PathBuf>,
    /// Triangles that all instances may have together: 5000, 10k, 2m
    ///
    /// The largest error on the screen is as small as it can be, within 2 %. The last level with
    /// triangles is never left.
    #[arg(long, value_name = "N", value_parser = count, requires = "scene", help_heading = LEVEL)]
    budget: Option<u64>,
    /// Place of the eye
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true,
          help_heading = SEEN)]
    eye: Option<[f64; 3]>,
    /// Point looked at; what is wholly behind the eye has its coarsest level
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true,
          requires = "eye", help_heading = SEEN)]
    target: Option<[f64; 3]>,
    #[command(flatten)]
    screen: ScreenArgs,
    /// Print one JSON document on standard output
    #[arg(long, help_heading = OUTPUT)]
    json: bool,
    #[command(flatten)]
    limits: LimitArgs,
}

const EXAMPLES: &str = "\
A file needs --pixels and --distance, a scene --eye and either --budget or --pixels.

Examples:
  lodc select chair.lodc --pixels 1 --distance 20
  lodc select --scene hall.jsonl --eye 0,1.7,0 --target 0,1.7,-5 --budget 500000 --json";

/// `select FILE --json`.
#[derive(Debug, Serialize)]
struct FileReport {
    schema_version: u32,
    #[serde(flatten)]
    level: LevelReport,
    projected_pixels: f64,
}

/// `select --scene --json`.
#[derive(Debug, Serialize)]
struct SceneReport {
    schema_version: u32,
    triangles: u64,
    /// Bound on the projected error of every instance; null if the budget is too small for any.
    pixels: Option<f64>,
    instances: Vec<LevelReport>,
}

/// The level of one instance.
#[derive(Debug, Serialize)]
struct LevelReport {
    /// Null if several objects each have their own: `extract --error` finds them.
    lod: Option<u32>,
    triangles: u32,
    /// In the file's world units.
    error: f64,
    errors_over: ErrorsOver,
}

pub(crate) fn run(args: &SelectArgs) -> Outcome<()> {
    match (&args.file, &args.scene) {
        (Some(file), _) => select_for_file(args, file),
        (None, Some(list)) => select_for_scene(args, list),
        (None, None) => Err(Failure::usage("name a file, or a scene with --scene")),
    }
}

fn select_for_file(args: &SelectArgs, file: &std::path::Path) -> Outcome<()> {
    let model = Model::read(file, &args.limits)?;
    let eye_distance = args.distance.expect("clap requires it with a file");
    let pixels = args.pixels.expect("clap requires it with a file");
    // The distance is to the nearest point of the surface, so the model's sphere has no radius.
    let instance = Instance { curve: 0, position: [0.0, 0.0, eye_distance], scale: 1.0 };
    let mut manager = SceneManager::new(vec![model.curve(0.0)], vec![instance]);
    let view = args.screen.view([0.0; 3]);
    manager.frame(&view, Goal::Pixels(pixels));
    let level = level(&model, &manager, 0);
    let projected_pixels = level.error * f64::from(view.screen) / f64::from(eye_distance);
    if args.json {
        let schema_version = SCHEMA_VERSION;
        return console::json(&FileReport { schema_version, level, projected_pixels });
    }
    console::result(&format!(
        "{}, {projected_pixels:.2} pixels at {}",
        text(&level),
        distance(f64::from(eye_distance))
    ))
}

fn select_for_scene(args: &SelectArgs, list: &std::path::Path) -> Outcome<()> {
    // Everything is about the eye: far from the origin single precision would be too little.
    let eye = args.eye.expect("clap requires it");
    let scene = scene::read(list, eye, &args.limits)?;
    let curves = scene.models.iter().map(|model| model.curve(model.radius)).collect();
    let mut manager = SceneManager::new(curves, scene.instances.clone());
    let view = args.screen.view([0.0; 3]);
    let view = args.target.map_or(view, |target| view.towards(scene::about(eye, target)));
    let goal = match (args.budget, args.pixels) {
        (Some(budget), _) => Goal::Triangles(budget),
        (None, pixels) => Goal::Pixels(pixels.expect("clap requires one of them")),
    };
    let triangles = manager.frame(&view, goal);
    if args.budget.is_some_and(|budget| triangles > budget) {
        let what = format!("the coarsest levels have {} triangles", grouped(triangles));
        console::warning(&list.display().to_string(), &what);
    }
    let model_of = |i: usize| &scene.models[scene.instances[i].curve as usize];
    let instances = (0..scene.instances.len()).map(|i| level(model_of(i), &manager, i));
    let instances: Vec<LevelReport> = instances.collect();
    if args.json {
        let (schema_version, pixels) = (SCHEMA_VERSION, manager.pixels().map(decimal));
        return console::json(&SceneReport { schema_version, triangles, pixels, instances });
    }
    for (number, instance) in instances.iter().enumerate() {
        console::result(&format!("{number}: {}", text(instance)))?;
    }
    console::result(&format!("{} triangles in all", grouped(triangles)))
}

fn level(model: &Model, manager: &SceneManager, instance: usize) -> LevelReport {
    let level = manager.level(instance);
    let lod = model.lod(level.index);
    let (triangles, error) = (level.triangles, decimal(level.error));
    LevelReport { lod, triangles, error, errors_over: model.errors_over }
}

fn text(level: &LevelReport) -> String {
    let lod = level.lod.map_or(String::new(), |lod| format!("LOD {}, ", grouped(u64::from(lod))));
    let triangles = grouped(u64::from(level.triangles));
    format!("{lod}{triangles} triangles, error {}", distance(level.error))
}

fn positive(text: &str) -> Result<f32, String> {
    let value: f32 = text.parse().map_err(|e| format!("{e}"))?;
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err("a number above 0".to_owned()) }
}
