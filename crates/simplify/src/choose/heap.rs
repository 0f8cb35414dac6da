//! An indexed 4-ary heap: the cheapest group first, ties by index, with the cost of any group
//! changeable in place.

/// The slot of a group that is not in the heap.
const ABSENT: u32 = u32::MAX;
/// Children of a node: half the levels of a binary heap, and the four keys lie in one cache line.
const ARITY: usize = 4;

/// Groups ordered by cost. Cost and group share one integer (costs are not negative, so their bits
/// order as they do), which makes a comparison one instruction and the order total.
pub(crate) struct Heap {
    /// Cost and group of each node, the cost in the upper half.
    keys: Vec<u64>,
    /// The node of each group, or [`ABSENT`].
    slot: Vec<u32>,
}

fn key(group: u32, cost: f32) -> u64 {
    u64::from(cost.to_bits()) << 32 | u64::from(group)
}

fn group_of(key: u64) -> u32 {
    key as u32
}

impl Heap {
    /// A heap of all groups whose cost is not NaN, given the cost of each.
    pub(crate) fn new(costs: impl ExactSizeIterator<Item = f32>) -> Self {
        let mut slot = vec![ABSENT; costs.len()];
        let mut keys: Vec<u64> = Vec::with_capacity(costs.len());
        keys.extend(
            (0..).zip(costs).filter(|(_, cost)| !cost.is_nan()).map(|(g, cost)| key(g, cost)),
        );
        for (i, &k) in keys.iter().enumerate() {
            slot[group_of(k) as usize] = i as u32;
        }
        let mut heap = Self { keys, slot };
        for i in (0..heap.keys.len().div_ceil(ARITY)).rev() {
            heap.sift_down(i);
        }
        heap
    }

    /// The cheapest cost, infinite when empty.
    pub(crate) fn least(&self) -> f32 {
        self.keys.first().map_or(f32::INFINITY, |&k| f32::from_bits((k >> 32) as u32))
    }

    /// The cheapest group.
    pub(crate) fn first(&self) -> Option<u32> {
        self.keys.first().map(|&k| group_of(k))
    }

    /// Takes the cheapest group out.
    pub(crate) fn pop(&mut self) -> Option<(u32, f32)> {
        let &k = self.keys.first()?;
        self.remove(group_of(k));
        Some((group_of(k), f32::from_bits((k >> 32) as u32)))
    }

    /// Puts a group in, or changes its cost.
    pub(crate) fn set(&mut self, group: u32, cost: f32) {
        let new = key(group, cost);
        let slot = self.slot[group as usize];
        if slot == ABSENT {
            self.keys.push(new);
            self.sift_up(self.keys.len() - 1, new);
        } else if new < self.keys[slot as usize] {
            self.sift_up(slot as usize, new);
        } else {
            self.keys[slot as usize] = new;
            self.sift_down(slot as usize);
        }
    }

    /// Takes a group out, if it is in.
    pub(crate) fn remove(&mut self, group: u32) {
        let slot = self.slot[group as usize];
        if slot == ABSENT {
            return;
        }
        self.slot[group as usize] = ABSENT;
        let Some(last) = self.keys.pop() else { return };
        let slot = slot as usize;
        if slot < self.keys.len() {
            if last < self.keys[slot] {
                self.sift_up(slot, last);
            } else {
                self.keys[slot] = last;
                self.sift_down(slot);
            }
        }
    }

    fn sift_up(&mut self, mut i: usize, k: u64) {
        while i > 0 {
            let parent = (i - 1) / ARITY;
            if self.keys[parent] <= k {
                break;
            }
            self.set_slot(i, self.keys[parent]);
            i = parent;
        }
        self.set_slot(i, k);
    }

    fn sift_down(&mut self, mut i: usize) {
        let k = self.keys[i];
        loop {
            let first = ARITY * i + 1;
            let children =
                &self.keys[first.min(self.keys.len())..(first + ARITY).min(self.keys.len())];
            let Some((child, &least)) = children.iter().enumerate().min_by_key(|&(_, &c)| c) else {
                break;
            };
            if least >= k {
                break;
            }
            self.set_slot(i, least);
            i = first + child;
        }
        self.set_slot(i, k);
    }

    fn set_slot(&mut self, i: usize, k: u64) {
        self.keys[i] = k;
        self.slot[group_of(k) as usize] = i as u32;
    }
}

#[cfg(test)]
mod tests {
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
}
