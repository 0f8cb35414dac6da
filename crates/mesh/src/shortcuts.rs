//! Jump pointers through long chains of collapses, so that any chain is followed in logarithmic
//! time.

/// For each vertex a later vertex of its chain of collapses, chosen so that any chain is followed
/// in a logarithmic number of jumps (the skew-binary jump pointers of Myers 1983).
#[derive(Clone, Debug)]
pub struct Shortcuts(Vec<u32>);

impl Shortcuts {
    /// Makes the shortcuts of a sequence in linear time. `targets` has the vertex that each vertex
    /// but the last becomes, always a larger one.
    #[must_use]
    pub fn new(targets: &[u32]) -> Self {
        let last = targets.len();
        let mut jumps = vec![last as u32; last + 1];
        let mut depth = vec![0u32; last + 1];
        for v in (0..last).rev() {
            let next = targets[v] as usize;
            let jump = jumps[next] as usize;
            let second_jump = jumps[jump] as usize;
            depth[v] = depth[next] + 1;
            let is_balanced = depth[next] - depth[jump] == depth[jump] - depth[second_jump];
            jumps[v] = if is_balanced { second_jump } else { next } as u32;
        }
        Self(jumps)
    }

    /// Returns the first vertex of the chain from `vertex` on for which `has_ended` is true. It
    /// must be true for the last vertex, and for all vertices of a chain after the first such one.
    #[must_use]
    pub fn first(&self, targets: &[u32], vertex: u32, has_ended: impl Fn(u32) -> bool) -> u32 {
        let mut current = vertex;
        while !has_ended(current) {
            let jump = self.0[current as usize];
            current = if has_ended(jump) { targets[current as usize] } else { jump };
        }
        current
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
                    let mut wanted = v;
                    while wanted < lod {
                        wanted = targets[wanted as usize];
                    }
                    let found = shortcuts.first(&targets, v, |v| v >= lod);
                    assert_eq!(found, wanted, "vertex {v}, LOD {lod}");
                }
            }
        }
    }
}
