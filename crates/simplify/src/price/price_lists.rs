//! A cache of the prices of groups whose faces have not changed.
//!
//! A group that was refused is searched again and again, mostly because one of its neighbours
//! changed. What its collapses cost has not changed by that, but for the cost stored at the target.

use crate::cut::WorkingMesh;

/// A priced collapse, without the target's own cost.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Priced {
    /// The cost by the group's own quadric and by attributes.
    pub(super) own_cost: f64,
    pub(crate) to: u32,
}

impl Priced {
    /// The whole cost as of now, not NaN.
    #[inline]
    pub(crate) fn cost(&self, mesh: &WorkingMesh) -> f64 {
        let target_cost = f64::from(mesh.group_positions[self.to as usize].target_cost);
        let cost = self.own_cost + target_cost;
        if cost.is_nan() { f64::INFINITY } else { cost }
    }
}

/// The block of a group's list in [`PriceLists::blocks`]; its capacity is a power of two.
#[derive(Clone, Copy)]
struct Slot {
    start: u32,
    /// `NO_LIST` if there is none.
    len: u8,
    /// The block's capacity; zero without a block.
    capacity: u8,
}

/// The length that says that there is no list.
const NO_LIST: u8 = u8::MAX;
const NO_SLOT: Slot = Slot { start: 0, len: NO_LIST, capacity: 0 };
/// The capacities of the smallest and the largest blocks, as exponents of two. A group on a seam,
/// the usual case here, has two to four candidates; longer lists than 128 are not kept. Chosen by
/// hand.
const MIN_BITS: u32 = 2;
const MAX_BITS: u32 = 7;

/// The lists of one region.
#[derive(Default)]
pub(crate) struct PriceLists {
    /// By group.
    slots: Vec<Slot>,
    /// The prices of all blocks.
    blocks: Vec<Priced>,
    /// The starts of free blocks of each size, the smallest first.
    free: [Vec<u32>; (MAX_BITS - MIN_BITS + 1) as usize],
}

impl PriceLists {
    /// Empty lists of a region, given its number of groups. The default keeps no list at all.
    pub(crate) fn new(groups: usize) -> Self {
        // Four prices each. Memory that is reserved but not written takes no pages.
        let blocks = Vec::with_capacity(groups << MIN_BITS);
        Self { slots: vec![NO_SLOT; groups], blocks, ..Self::default() }
    }

    /// Drops all lists.
    pub(crate) fn clear(&mut self) {
        self.slots.fill(NO_SLOT);
        self.blocks.clear();
        self.free.iter_mut().for_each(Vec::clear);
    }

    /// The prices of a group, if they are still right.
    #[inline]
    pub(crate) fn get(&self, group: u32) -> Option<&[Priced]> {
        let slot = self.slots.get(group as usize).filter(|slot| slot.len != NO_LIST)?;
        Some(&self.blocks[slot.start as usize..][..usize::from(slot.len)])
    }

    /// Drops the list of a group whose faces changed.
    #[inline]
    pub(crate) fn forget(&mut self, group: u32) {
        if let Some(slot) = self.slots.get_mut(group as usize) {
            slot.len = NO_LIST;
        }
    }

    /// Gives back the block of a group that is gone.
    pub(crate) fn release(&mut self, group: u32) {
        let Some(slot) = self.slots.get_mut(group as usize) else { return };
        let slot = std::mem::replace(slot, NO_SLOT);
        if slot.capacity > 0 {
            self.free[size_of(usize::from(slot.capacity))].push(slot.start);
        }
    }

    /// Keeps a list until the group's faces change. Very long ones are not kept.
    pub(crate) fn keep(&mut self, group: u32, list: &[Priced]) {
        let Some(&slot) = self.slots.get(group as usize) else { return };
        if list.len() > usize::from(slot.capacity) {
            self.release(group);
            if list.len() > 1 << MAX_BITS {
                return;
            }
            let size = size_of(list.len());
            let capacity = 1 << (MIN_BITS + size as u32);
            let start = self.free[size].pop().unwrap_or_else(|| {
                self.blocks.resize(self.blocks.len() + capacity, Priced::default());
                (self.blocks.len() - capacity) as u32
            });
            self.slots[group as usize] = Slot { start, len: NO_LIST, capacity: capacity as u8 };
        }
        let slot = &mut self.slots[group as usize];
        slot.len = list.len() as u8;
        self.blocks[slot.start as usize..][..list.len()].copy_from_slice(list);
    }
}

/// The size of the least block that holds a list of this length.
fn size_of(len: usize) -> usize {
    (len.next_power_of_two().trailing_zeros().max(MIN_BITS) - MIN_BITS) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(of: u32, len: usize) -> Vec<Priced> {
        (0..len as u32).map(|to| Priced { to: 1000 * of + to, ..Priced::default() }).collect()
    }

    #[test]
    fn lists_stay_until_they_are_forgotten() {
        let mut lists = PriceLists::new(200);
        let mut lens: Vec<Option<usize>> = vec![None; 200];
        for step in 0..4000usize {
            let (group, len) = (step * 7919 % 200, step * 104_729 % 130);
            match step % 5 {
                0 => lists.forget(group as u32),
                1 => lists.release(group as u32),
                _ => lists.keep(group as u32, &list(group as u32, len)),
            }
            lens[group] = (step % 5 > 1 && len <= 128).then_some(len);
            for (other, &len) in (0..).zip(&lens) {
                let got = lists.get(other).map(|l| l.iter().map(|p| p.to).collect::<Vec<_>>());
                let want = len.map(|l| list(other, l).iter().map(|p| p.to).collect::<Vec<_>>());
                assert_eq!(got, want, "group {other} at step {step}");
            }
        }
        assert!(lists.blocks.len() <= 200 * 128 * 2, "{}", lists.blocks.len());
        lists.clear();
        assert!((0..200).all(|g| lists.get(g).is_none()));
    }

    #[test]
    fn the_default_keeps_none() {
        let mut lists = PriceLists::default();
        lists.keep(0, &list(0, 3));
        assert!(lists.get(0).is_none());
    }
}
