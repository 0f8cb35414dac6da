//! The sixth step: choose and commit, again and again, until one vertex is left.
//!
//! The input is a numbered mesh; the output is the [`CollapseLog`] of all its collapses. In
//! each round every region collapses what costs at most a common limit, by itself, as far as no
//! other region is touched. Then the groups are shared out anew along a shifted curve, so that what
//! was locked at a border comes to lie inside. Regions follow from the mesh alone, so the result is
//! the same for any number of threads. When few groups are left, one region takes them all; a
//! metric that sees has one region from the start, which keeps the exact order of costs.

mod engine;

pub(crate) use engine::Progress;

use crate::commit::{CollapseLog, Sources, renumber_wedges};
use crate::cut::{DEAD, Home, Region, RegionLists, Round};
use crate::metric::{QuadricOnly, Reevaluate};
use crate::number::Curve;
use crate::price::Context;
use engine::Engine;
use lodc_mesh::{Csr, NONE};
use rayon::prelude::*;
use std::sync::Mutex;

/// Groups of a region, about. Larger regions have fewer groups at borders, smaller ones fit into a
/// second-level cache. With 8,192 the error of mni152 is 1.037 times that of one region; with this
/// it is at most 1.028 on the three large scans.
pub(crate) const REGION_GROUPS: usize = 12288;
/// The least number of regions: a smaller mesh is one region, as sharing its groups out would take
/// as long as is won.
pub(crate) const MIN_REGIONS: usize = 8;
/// The share of live groups whose cost is within the limit of a round. With 0.5 levels are no
/// closer to the input and take a tenth more time; with 0.8 the error at 50 % of the triangles is
/// 1.03 to 1.10 times as large, as too many groups are locked while their neighbours collapse.
const ROUND_SHARE: f64 = 0.65;
/// If a round collapses less than this share of the groups, it is the last. Where most faces meet
/// in one vertex, only its region can go on, and would go too far with the limits of further rounds
/// (it would eat a fan's border from one end; there is a test). Chosen by hand.
const MIN_PROGRESS: f64 = 0.02;
/// Costs that are sampled for a limit, about: the share of all costs within it is [`ROUND_SHARE`]
/// up to 1 % then.
const SAMPLED_COSTS: usize = 4096;
/// The most waves in which new regions are gathered from old ones, which are dropped wave by wave:
/// with 16, old and new regions together take about a sixteenth more memory than one set of them.
/// Chosen by hand.
const MAX_WAVES: usize = 16;
/// The shares of the mesh's extent by which the curve is shifted in successive rounds: chosen by
/// hand so that borders of one round are not those of the round before; not tuned.
const SHIFTS: [f64; 5] = [0.37, 0.11, 0.53, 0.23, 0.71];

/// The state between rounds.
struct Rounds<'a> {
    context: &'a Context<'a>,
    regions: Vec<Region>,
    log: CollapseLog,
    /// Number of groups that are left.
    live_groups: usize,
}

/// Simplifies a mesh in regions of about `size` groups. Returns the log and how many of its steps
/// are legal; those are in order of their stamps only once they are sorted.
pub(crate) fn in_regions(
    context: &Context<'_>,
    size: usize,
    sources: &mut Sources<'_>,
    progress: &Progress<'_>,
) -> (CollapseLog, usize) {
    let mut rounds = Rounds::new(context, size);
    for round in 0.. {
        let collapsed = rounds.run(sources, progress);
        let least = (MIN_PROGRESS * (rounds.live_groups + collapsed) as f64) as usize;
        if rounds.live_groups < size || collapsed <= least {
            break;
        }
        let regions = rounds.live_groups.div_ceil(size);
        rounds.share_out(regions, SHIFTS[round % SHIFTS.len()]);
    }
    rounds.share_out(1, 0.0);
    let Rounds { mut regions, mut log, .. } = rounds;
    let (rest, legal) = finish(context, &mut regions[0], &mut QuadricOnly, sources, progress);
    let legal = log.steps.len() + legal;
    log.append(&rest);
    (log, legal)
}

/// Simplifies a mesh as one region, in the exact order of costs. Returns the log and how many of
/// its steps are legal.
pub(crate) fn as_one<M: Reevaluate>(
    context: &Context<'_>,
    metric: impl FnOnce(&Region) -> M,
    sources: &mut Sources<'_>,
    progress: &Progress<'_>,
) -> (CollapseLog, usize) {
    let mut region = Region::whole(context.input, context.is_bare());
    if M::REPRICES {
        region.mesh.keep_facets();
    }
    let mut metric = metric(&region);
    finish(context, &mut region, &mut metric, sources, progress)
}

/// Collapses the region that holds all that is left of the mesh, down to one vertex.
fn finish(
    context: &Context<'_>,
    region: &mut Region,
    metric: &mut impl Reevaluate,
    sources: &mut Sources<'_>,
    progress: &Progress<'_>,
) -> (CollapseLog, usize) {
    let (mut log, legal) = Engine::new(context, region, metric).run_all(progress);
    sources.number_fakes(region, &mut log);
    (log, legal)
}

impl<'a> Rounds<'a> {
    /// Cuts a mesh into regions and prices all collapses.
    fn new(context: &'a Context<'a>, size: usize) -> Self {
        let input = context.input;
        let groups = input.groups();
        let count = groups.div_ceil(size);
        let bound = |region: usize| (groups * region / count) as u32;
        // The region of a group, whose numbers are those of regions in order.
        let mut region_of = vec![0u32; groups];
        for region in 0..count {
            region_of[bound(region) as usize..bound(region + 1) as usize].fill(region as u32);
        }
        let at_triangle = |t: u32| {
            let [a, b, c] = input.mesh.triangles()[t as usize]
                .map(|v| region_of[input.group_of[v as usize] as usize]);
            let second = (b != a).then_some(b);
            let third = (c != a && c != b).then_some(c);
            std::iter::once(a).chain(second).chain(third).map(move |r| (r, t))
        };
        let triangles = input.mesh.triangles().len() as u32;
        let rows = Csr::new(count, (0..triangles).flat_map(at_triangle));
        let bare = context.is_bare();
        let regions = (0..count)
            .into_par_iter()
            .with_max_len(1)
            .map(|r| {
                let range = bound(r)..bound(r + 1);
                let row = rows.row(r as u32).iter().copied();
                let mut region = Region::new(input, range, row, bare);
                Engine::new(context, &mut region, &mut QuadricOnly).rank_all();
                region
            })
            .collect();
        Self { context, regions, log: CollapseLog::default(), live_groups: groups }
    }

    /// Runs one round. Returns how many groups collapsed.
    fn run(&mut self, sources: &mut Sources<'_>, progress: &Progress<'_>) -> usize {
        let limit = self.limit();
        let context = self.context;
        let mut logs: Vec<CollapseLog> = self
            .regions
            .par_iter_mut()
            .with_max_len(1)
            .map(|region| {
                let mut metric = QuadricOnly;
                let engine = Engine::new(context, region, &mut metric);
                let mut log = engine.run_round(limit, progress);
                if region.wedges.new_fakes() == 0 {
                    renumber_wedges(region, &mut log);
                }
                log
            })
            .collect();
        for (region, log) in self.regions.iter_mut().zip(&mut logs) {
            if region.wedges.new_fakes() > 0 {
                sources.number_fakes(region, log);
            }
        }
        let before = self.log.steps.len();
        for log in &logs {
            self.log.append(log);
        }
        let collapsed = self.log.steps.len() - before;
        self.live_groups = self
            .regions
            .par_iter()
            .map(|r| r.mesh.flags[..r.own_groups()].iter().filter(|&f| f & DEAD == 0).count())
            .sum();
        progress.end_round(collapsed as u64);
        collapsed
    }

    /// The cost that about [`ROUND_SHARE`] of all live groups do not exceed.
    fn limit(&self) -> f32 {
        let step = (self.live_groups / SAMPLED_COSTS).max(1);
        let mut costs: Vec<f32> = self
            .regions
            .iter()
            .flat_map(|r| &r.choices)
            .step_by(step)
            .map(|c| c.cost)
            .filter(|c| !c.is_nan())
            .collect();
        let at = (ROUND_SHARE * costs.len() as f64) as usize;
        if at >= costs.len() {
            return f32::INFINITY;
        }
        *costs.select_nth_unstable_by(at, f32::total_cmp).1
    }

    /// Shares the live groups out to `count` regions along a shifted curve.
    fn share_out(&mut self, count: usize, shift: f64) {
        let input = self.context.input;
        let mut homes = vec![Home::NONE; input.groups()];
        let mut live_groups: Vec<u32> = Vec::with_capacity(self.live_groups);
        for (r, region) in (0..).zip(&self.regions) {
            for g in 0..region.own_groups() as u32 {
                if !region.mesh.has(g, DEAD) {
                    let group = region.groups[g as usize];
                    homes[group as usize] = Home { region: r, group: g };
                    live_groups.push(group);
                }
            }
        }
        let (lo, hi) = input.bounds();
        let order = Curve::new(lo, hi, shift)
            .order(live_groups.len(), |i| input.position(live_groups[i] as usize));
        let order: Vec<u32> = order.into_iter().map(|i| live_groups[i as usize]).collect();
        drop(live_groups);
        let mut ranks = vec![NONE; input.groups()];
        for (rank, &group) in (0..).zip(&order) {
            ranks[group as usize] = rank;
        }
        let bound = |r: usize| order.len() * r / count;
        // Wave by wave: an old region that no later wave reads is reused at once, so that there are
        // never two full sets of regions.
        let waves = waves(count);
        let first_of = |wave: usize| (count * wave).div_ceil(waves);
        let last: Vec<u32> = self.regions.par_iter().map(|r| last_read(r, &ranks)).collect();
        let lists = RegionLists::new(&self.regions);
        let mut spent = SpentRegions::default();
        let mut regions = Vec::with_capacity(count);
        for wave in 0..waves {
            let (old, homes, order, ranks) = (&self.regions, &homes, &order, &ranks);
            let round = Round { old, lists, homes, order, ranks };
            let gathered = (first_of(wave)..first_of(wave + 1))
                .into_par_iter()
                .with_max_len(1)
                .map(|r| round.gather(bound(r)..bound(r + 1), spent.take()));
            regions.par_extend(gathered);
            let read = bound(first_of(wave))..bound(first_of(wave + 1));
            let read = |last: &u32| read.contains(&(*last as usize));
            let over = self.regions.iter_mut().zip(&last).filter(|(_, last)| read(last));
            spent.keep(over.map(|(region, _)| std::mem::take(region)), count.div_ceil(waves));
        }
        self.regions = regions;
    }
}

/// The number of waves for a number of regions. Few regions take little memory, so each wave has
/// two for every thread then (with 16 waves, gathering a mesh of ten regions used one thread).
fn waves(regions: usize) -> usize {
    let fewest = if regions < 4 * MAX_WAVES { 2 * rayon::current_num_threads() } else { 1 };
    (regions / fewest).clamp(1, MAX_WAVES)
}

/// Regions that have been read for the last time. New ones are built in their lists: allocating
/// them anew would page in as much memory again.
#[derive(Default)]
struct SpentRegions(Mutex<Vec<Region>>);

impl SpentRegions {
    /// A region with old contents, or an empty one.
    fn take(&self) -> Region {
        self.0.lock().map_or(None, |mut regions| regions.pop()).unwrap_or_default()
    }

    /// Adds regions, of which it then keeps `most` at most.
    fn keep(&mut self, regions: impl Iterator<Item = Region>, most: usize) {
        let Ok(spent) = self.0.get_mut() else { return };
        spent.extend(regions);
        spent.truncate(most);
    }
}

/// The largest rank (index in the new order) of a region's groups and of those next to them: no
/// later group needs the region.
fn last_read(region: &Region, ranks: &[u32]) -> u32 {
    let ranks = region.groups.iter().map(|&g| ranks[g as usize]);
    ranks.filter(|&rank| rank != NONE).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use crate::{Guidance, Options, simplify_with};
    use lodc_fixtures as shapes;

    #[test]
    fn no_vertex_runs_round_the_border_of_a_fan() {
        // All faces meet in one vertex, so only its region can go on.
        let mesh = shapes::fan(8000);
        let simplified =
            simplify_with(&mesh, &Options::DEFAULT, Guidance::default(), 1000, &|_, _| {}).0;
        let collapses = simplified.collapses();
        let mut depth = vec![0u32; collapses.records() as usize + 1];
        for record in (0..mesh.vertex_count() / 2).rev() {
            depth[record] = 1 + depth[collapses.targets()[record] as usize];
        }
        let longest = depth.into_iter().max();
        assert!(
            longest.is_some_and(|most| most < 40),
            "{longest:?} collapses, one after the other"
        );
    }
}
