use super::*;
use lodc_mesh::SplitMix64;

/// A curve like those of simplified meshes: errors grow as triangles halve.
fn curve(rng: &mut SplitMix64) -> LevelCurve {
    let mut triangles = 200 + rng.below(3000) as u32;
    let mut error = 0.0;
    let mut levels = vec![(0.0, triangles)];
    while triangles > 4 {
        triangles -= 1 + rng.below((triangles / 16 + 1) as usize) as u32;
        error += 1e-4 * (1.0 + rng.below(100) as f64) / f64::from(triangles);
        levels.push((error, triangles));
    }
    LevelCurve::new(&levels, 1.0)
}

fn scene(seed: u64, count: usize) -> SceneManager {
    let mut rng = SplitMix64::new(seed);
    let curves: Vec<LevelCurve> = (0..8).map(|_| curve(&mut rng)).collect();
    let coordinate = |rng: &mut SplitMix64| rng.below(2000) as f32 / 10.0 - 100.0;
    let instances = (0..count)
        .map(|_| Instance {
            curve: rng.below(8) as u32,
            position: [coordinate(&mut rng), 0.0, coordinate(&mut rng)],
            scale: 0.5 + rng.below(100) as f32 / 50.0,
        })
        .collect();
    SceneManager::new(curves, instances)
}

/// Pixels that the error of a level takes.
fn pixels(manager: &SceneManager, instance: usize, level: &CurveLevel) -> f32 {
    level.error / manager.per_pixel[instance]
}

/// Coarsens, one level at a time, the instance whose next level is least visible, until the
/// triangles fit. Returns the largest error, in pixels.
fn greedy(manager: &SceneManager, levels: &[Vec<CurveLevel>], budget: u64) -> f32 {
    let count = manager.instances.len();
    let mut current = vec![0; count];
    let levels = |i: usize| &levels[manager.instances[i].curve as usize];
    let mut total: u64 = (0..count).map(|i| u64::from(levels(i)[0].triangles)).sum();
    let mut largest = 0.0_f32;
    while total > budget {
        let coarsened = (0..count).filter(|&i| current[i] + 1 < levels(i).len());
        let errors = coarsened.map(|i| (pixels(manager, i, &levels(i)[current[i] + 1]), i));
        let Some((error, i)) = errors.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        total -= u64::from(levels(i)[current[i]].triangles - levels(i)[current[i] + 1].triangles);
        current[i] += 1;
        largest = largest.max(error);
    }
    largest
}

#[test]
fn a_budget_is_met_as_well_as_by_a_greedy_choice() {
    for seed in 0..10 {
        let mut manager = scene(seed, 60);
        let all: u64 = (0..60).map(|i| u64::from(manager.level(i).triangles)).sum();
        let distinct = |curve: &LevelCurve| {
            let mut levels: Vec<CurveLevel> = (0..=LAST_STEP).map(|step| *curve.at(step)).collect();
            levels.dedup_by_key(|level| level.index);
            levels
        };
        let levels: Vec<Vec<CurveLevel>> = manager.curves.iter().map(distinct).collect();
        for share in [2, 5, 20] {
            let mut fresh = manager.clone();
            let view = View::new([3.0, 2.0, 1.0], 60.0, 1080.0);
            let shown = fresh.frame(&view, Goal::Triangles(all / share));
            assert!(shown <= all / share);
            let seen = (0..60).map(|i| pixels(&fresh, i, fresh.level(i))).fold(0.0, f32::max);
            let best = greedy(&fresh, &levels, all / share);
            assert!(seen <= best * 1.02, "seed {seed}, 1/{share}: {seen} against {best}");
            assert_eq!((0..60).map(|i| u64::from(fresh.level(i).triangles)).sum::<u64>(), shown);
        }
        manager.frame(&View::new([0.0; 3], 60.0, 1080.0), Goal::Pixels(1.0));
        assert!((0..60).all(|i| pixels(&manager, i, manager.level(i)) <= 1.0));
    }
}

/// Objects with errors and triangles of all levels: from ten to thousands of triangles, with errors
/// that grow early or late.
fn unlike(rng: &mut SplitMix64) -> Vec<Vec<(f64, u32)>> {
    let one = |rng: &mut SplitMix64| {
        let (all, growth) = (10 + rng.below(4000) as u32, 0.2 + rng.below(30) as f64 / 10.0);
        let (mut left, mut levels) = (all, vec![(0.0, all)]);
        while left > 2 {
            left -= (1 + rng.below(left as usize / 20 + 1) as u32).min(left - 1);
            let share = f64::from(all - left) / f64::from(all);
            levels.push(((share / (1.02 - share)).powf(growth) * 0.01, left));
        }
        levels
    };
    (0..3 + rng.below(9)).map(|_| one(rng)).collect()
}

#[test]
fn a_budget_of_unlike_objects_takes_the_fewest_pixels_from_any_eye() {
    for seed in 0..20 {
        let mut rng = SplitMix64::new(seed);
        let objects = unlike(&mut rng);
        let curves = objects.iter().map(|levels| LevelCurve::new(levels, 0.5)).collect();
        let mut coordinate = || rng.below(20_000) as f32 / 10.0 - 1000.0;
        let places: Vec<[f32; 3]> =
            (0..2 * objects.len()).map(|_| [coordinate(), coordinate(), 0.0]).collect();
        let instances: Vec<Instance> = places
            .into_iter()
            .zip((0..objects.len()).cycle())
            .map(|(position, object)| {
                let scale = [0.01, 0.1, 1.0, 10.0, 100.0][rng.below(5)];
                Instance { curve: object as u32, position, scale }
            })
            .collect();
        let levels = |i: usize| &objects[instances[i].curve as usize];
        let all: u32 = (0..instances.len()).map(|i| levels(i)[0].1).sum();
        let manager = SceneManager::new(curves, instances.clone());
        for eye in [[0.0, 0.0, 3.0], [1500.0, -200.0, 400.0], [-300.0, 500.0, 20.0]] {
            for share in [0.6, 0.5, 0.4, 0.3, 0.1] {
                let budget = (f64::from(all) * share) as u64;
                let mut shown = manager.clone();
                assert!(
                    shown.frame(&View::new(eye, 60.0, 1080.0), Goal::Triangles(budget)) <= budget
                );
                let per_pixel = |i: usize| f64::from(shown.per_pixel[i]);
                let seen = |i: usize| levels(i)[shown.level(i).index as usize].0 / per_pixel(i);
                let most = (0..instances.len()).map(seen).fold(0.0, f64::max);
                // The least bound, of all that levels have, under which the triangles fit.
                let fits = |bound: f64| {
                    let within = |i: usize| {
                        let fitting = levels(i).iter().rev().find(|l| l.0 <= bound * per_pixel(i));
                        u64::from(fitting.expect("the finest has no error").1)
                    };
                    (0..instances.len()).map(within).sum::<u64>() <= budget
                };
                let pixels = |i: usize| levels(i).iter().map(move |l| l.0 / per_pixel(i));
                let mut bounds: Vec<f64> = (0..instances.len()).flat_map(pixels).collect();
                bounds.sort_by(f64::total_cmp);
                let least = bounds[bounds.partition_point(|&b| !fits(b * (1.0 + 1e-9)))];
                assert!(most <= 1.1 * least, "seed {seed}, {eye:?}, {share}: {most} for {least}");
            }
        }
    }
}

#[test]
fn a_small_move_changes_no_level_and_the_budget_holds_on_the_way() {
    let mut manager = scene(3, 500);
    let all: u64 = (0..500).map(|i| u64::from(manager.level(i).triangles)).sum();
    let goal = Goal::Triangles(all / 8);
    let view = |x: f32| View::new([x, 2.0, 0.0], 60.0, 1080.0);
    manager.frame(&view(0.0), goal);
    manager.frame(&view(0.0), goal);
    let levels = |m: &SceneManager| (0..500).map(|i| m.level(i).index).collect::<Vec<_>>();
    let before = levels(&manager);
    manager.frame(&view(0.001), goal);
    let changed = levels(&manager).iter().zip(&before).filter(|(a, b)| a != b).count();
    assert!(changed <= 2, "{changed} of 500");
    for frame in 0..200 {
        let x = frame as f32 * 0.5 - 50.0;
        assert!(manager.frame(&view(x), goal) <= all / 8, "{frame}");
    }
}

#[test]
fn later_frames_add_up_a_few_times_only() {
    let mut manager = scene(5, 2000);
    let view = |x: f32| View::new([x, 2.0, 0.0], 60.0, 1080.0);
    manager.frame(&view(0.0), Goal::Triangles(300_000));
    let first = manager.sums();
    for frame in 1..=100 {
        manager.frame(&view(frame as f32 * 0.1), Goal::Triangles(300_000));
    }
    let later = (manager.sums() - first) / 100;
    assert!(later <= 8, "{first} at first, then {later} a frame");
}

#[test]
fn what_is_behind_the_eye_has_its_coarsest_level() {
    let curve = LevelCurve::new(&[(0.0, 100), (0.1, 10)], 1.0);
    let at = |z: f32| Instance { curve: 0, position: [0.0, 0.0, z], scale: 1.0 };
    let mut manager = SceneManager::new(vec![curve], vec![at(-2.0), at(-0.5), at(2.0)]);
    let view = View::new([0.0; 3], 60.0, 1080.0).towards([0.0, 0.0, 1.0]);
    manager.frame(&view, Goal::Pixels(0.5));
    assert_eq!([0, 1, 2].map(|i| manager.level(i).triangles), [10, 100, 100]);
}

#[test]
fn a_budget_below_the_coarsest_levels_shows_these() {
    let mut manager = scene(7, 50);
    let view = View::new([0.0; 3], 60.0, 1080.0);
    let least: u64 = (0..50).map(|i| u64::from(manager.curve(i).at(LAST_STEP).triangles)).sum();
    assert_eq!(manager.frame(&view, Goal::Triangles(1)), least);
    assert_eq!(SceneManager::new(vec![], vec![]).frame(&view, Goal::Triangles(1)), 0);
}
