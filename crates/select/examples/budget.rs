//! Time of a frame for many instances: `cargo run --release -p lodc-select --example budget`.

#![expect(clippy::print_stdout, reason = "an example that reports")]

use lodc_select::{Goal, Instance, LevelCurve, SceneManager, View};
use std::time::Instant;

fn main() {
    let levels: Vec<(f64, u32)> =
        (0..2000).map(|i| (f64::from(i) * f64::from(i) * 1e-8, 20_000 - i * 10)).collect();
    let curve = LevelCurve::new(&levels, 1.0);
    for count in [100, 1_000, 10_000, 100_000_u32] {
        let side = f64::from(count).sqrt() as u32;
        let at = |i: u32| [(i % side) as f32 * 3.0, 0.0, (i / side) as f32 * 3.0];
        let instances: Vec<Instance> =
            (0..count).map(|i| Instance { curve: 0, position: at(i), scale: 1.0 }).collect();
        let mut manager = SceneManager::new(vec![curve.clone()], instances);
        let budget = Goal::Triangles(u64::from(count) * 1500);
        let mut times: Vec<f64> = Vec::new();
        for frame in 0..200 {
            let view = View::new([frame as f32 * 0.2, 2.0, -5.0], 60.0, 1080.0);
            let start = Instant::now();
            manager.frame(&view, budget);
            times.push(start.elapsed().as_secs_f64() * 1e3);
        }
        let first = times.remove(0);
        times.sort_by(f64::total_cmp);
        println!("{count:7} instances: first {first:.3} ms, then {:.3} ms a frame", times[99]);
    }
}
