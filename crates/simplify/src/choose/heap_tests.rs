use super::Heap;

#[test]
fn it_pops_in_order_of_cost_then_index_whatever_was_changed() {
    let mut rng = lodc_fixtures::Rng::new(7);
    let mut costs: Vec<f32> = (0..300).map(|_| (rng.below(40) as f32) / 8.0).collect();
    costs[17] = f32::NAN;
    let mut heap = Heap::new(costs.iter().copied());
    let mut present: Vec<bool> = costs.iter().map(|c| !c.is_nan()).collect();
    for round in 0..2000 {
        let g = rng.below(costs.len());
        match round % 3 {
            0 => {
                costs[g] = rng.below(40) as f32 / 8.0;
                heap.set(g as u32, costs[g]);
                present[g] = true;
            }
            1 => {
                heap.remove(g as u32);
                present[g] = false;
            }
            _ => {
                let expected = (0..costs.len())
                    .filter(|&i| present[i])
                    .min_by(|&a, &b| costs[a].total_cmp(&costs[b]).then(a.cmp(&b)));
                assert_eq!(heap.least(), expected.map_or(f32::INFINITY, |i| costs[i]));
                assert_eq!(heap.pop(), expected.map(|i| (i as u32, costs[i])), "round {round}");
                if let Some(i) = expected {
                    present[i] = false;
                }
            }
        }
    }
}
