//! Shortcuts through long chains of collapses.

/// For each vertex one further vertex down its chain of collapses, chosen so that any chain is
/// walked in a logarithmic number of moves (the skew-binary jump pointers of Myers 1983).
#[derive(Clone, Debug)]
pub struct Shortcuts(Vec<u32>);

impl Shortcuts {
    /// Makes the shortcuts of a sequence in linear time: `targets` has the vertex that each becomes
    /// but the last, always a larger one.
    #[must_use]
    pub fn new(targets: &[u32]) -> Self {
        let last = targets.len();
        let mut further = vec![last as u32; last + 1];
        let mut depth = vec![0u32; last + 1];
        for v in (0..last).rev() {
            let next = targets[v] as usize;
            let far = further[next] as usize;
            let farther = further[far] as usize;
            depth[v] = depth[next] + 1;
            let even = depth[next] - depth[far] == depth[far] - depth[farther];
            further[v] = if even { farther } else { next } as u32;
        }
        Self(further)
    }

    /// Returns the first vertex of the chain from `vertex` on that `is_left`, which holds for all
    /// behind one for which it holds, and for the last one.
    #[must_use]
    pub fn first(&self, targets: &[u32], vertex: u32, is_left: impl Fn(u32) -> bool) -> u32 {
        let mut at = vertex;
        while !is_left(at) {
            let far = self.0[at as usize];
            at = if is_left(far) { targets[at as usize] } else { far };
        }
        at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shortcuts_lead_where_single_collapses_lead() {
        for spread in [1, 2, 7, 300] {
            let last = 300u32;
            let targets: Vec<u32> =
                (0..last).map(|v| (v + 1 + v * 7919 % spread).min(last)).collect();
            let shortcuts = Shortcuts::new(&targets);
            for v in 0..=last {
                for lod in 0..=last {
                    let mut slow = v;
                    while slow < lod {
                        slow = targets[slow as usize];
                    }
                    let found = shortcuts.first(&targets, v, |v| v >= lod);
                    assert_eq!(found, slow, "vertex {v}, LOD {lod}");
                }
            }
        }
    }
}
