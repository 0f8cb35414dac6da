//! Lists of a few corners for each vertex, side by side in memory: a vertex is looked at in one
//! place.

/// Corners that a vertex holds itself; more are kept elsewhere.
pub(super) const OWN: usize = 11;

#[derive(Clone, Copy, Debug)]
struct List {
    count: u32,
    /// The corners; if there are more than fit, the first is the number of a list in `many`.
    own: [u32; OWN],
}

/// The corners of all vertices.
#[derive(Clone, Debug, Default)]
pub(super) struct Fans {
    lists: Vec<List>,
    /// Long lists, and which of them are free.
    many: Vec<Vec<u32>>,
    free: Vec<u32>,
}

impl Fans {
    /// One more vertex, without corners.
    pub(super) fn add(&mut self) {
        self.lists.push(List { count: 0, own: [0; OWN] });
    }

    /// The corners of a vertex.
    #[inline]
    pub(super) fn of(&self, vertex: u32) -> &[u32] {
        let list = &self.lists[vertex as usize];
        match list.own.get(..list.count as usize) {
            Some(own) => own,
            None => &self.many[list.own[0] as usize],
        }
    }

    /// Replaces the corners of a vertex.
    #[inline]
    pub(super) fn set(&mut self, vertex: u32, corners: &[u32]) {
        let list = &mut self.lists[vertex as usize];
        let was_long = list.count as usize > OWN;
        list.count = corners.len() as u32;
        if corners.len() <= OWN {
            let long = list.own[0];
            list.own[..corners.len()].copy_from_slice(corners);
            if was_long {
                self.many[long as usize] = Vec::new();
                self.free.push(long);
            }
            return;
        }
        if !was_long {
            list.own[0] = self.free.pop().unwrap_or_else(|| {
                self.many.push(Vec::new());
                self.many.len() as u32 - 1
            });
        }
        let long = &mut self.many[list.own[0] as usize];
        long.clear();
        long.extend_from_slice(corners);
    }

    /// How many corners a vertex has.
    pub(super) fn count(&self, vertex: u32) -> u32 {
        self.lists[vertex as usize].count
    }

    /// The place for so many corners of a vertex, which has and will have no more than [`OWN`]. All
    /// have to be said anew.
    #[inline]
    pub(super) fn own(&mut self, vertex: u32, count: usize) -> &mut [u32; OWN] {
        let list = &mut self.lists[vertex as usize];
        list.count = count as u32;
        &mut list.own
    }

    /// Puts a corner into the list of a vertex: behind or before another one, or at the end.
    #[inline]
    pub(super) fn insert(&mut self, vertex: u32, corner: u32, beside: Option<(u32, bool)>) {
        let list = &mut self.lists[vertex as usize];
        let count = list.count as usize;
        let place = |corners: &[u32]| match beside {
            Some((other, behind)) => corners
                .iter()
                .position(|&c| c == other)
                .map_or(corners.len(), |i| i + usize::from(behind)),
            None => corners.len(),
        };
        match (count < OWN, beside) {
            (true, Some((other, true))) => {
                // The usual case: what stands further back moves on at once.
                let mut at = count;
                while at > 0 && list.own[at - 1] != other {
                    list.own[at] = list.own[at - 1];
                    at -= 1;
                }
                list.own[at] = corner;
                list.count += 1;
            }
            (true, _) => {
                let at = place(&list.own[..count]);
                list.own.copy_within(at..count, at + 1);
                list.own[at] = corner;
                list.count += 1;
            }
            (false, _) if count > OWN => {
                let long = &mut self.many[list.own[0] as usize];
                long.insert(place(long), corner);
                list.count += 1;
            }
            _ => {
                let mut long = list.own.to_vec();
                long.insert(place(&long), corner);
                self.set(vertex, &long);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_grow_and_shrink_like_any_others() {
        let mut random = crate::testing::Random(4);
        let mut fans = Fans::default();
        let mut plain: Vec<Vec<u32>> = vec![Vec::new(); 20];
        (0..20).for_each(|_| fans.add());
        for corner in 0..20_000 {
            let vertex = random.below(20);
            let list = &mut plain[vertex];
            if random.below(40) == 0 {
                list.truncate(random.below(30));
                fans.set(vertex as u32, list);
            }
            let beside = if list.is_empty() || random.below(3) == 0 {
                None
            } else {
                Some((list[random.below(list.len())], random.below(2) == 0))
            };
            let at = beside.map_or(list.len(), |(other, behind)| {
                list.iter().position(|&c| c == other).expect("it is there") + usize::from(behind)
            });
            list.insert(at, corner);
            fans.insert(vertex as u32, corner, beside);
            assert_eq!(fans.of(vertex as u32), list);
        }
    }
}
