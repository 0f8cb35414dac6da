//! The groups that one commit touches, each with a mark.

/// The groups whose faces a commit changed.
#[derive(Default)]
pub(crate) struct Touched {
    pub(crate) groups: Vec<u32>,
    marks: Vec<u32>,
    epoch: u32,
}

impl Touched {
    pub(crate) fn new(groups: usize) -> Self {
        Self { marks: vec![0; groups], ..Self::default() }
    }

    /// Begins a commit: nothing is touched.
    pub(crate) fn start(&mut self) {
        self.groups.clear();
        self.epoch = self.epoch.checked_add(2).unwrap_or_else(|| {
            self.marks.fill(0);
            2
        });
    }

    /// Marks a group besides those that were touched. Returns whether it had no mark since the last
    /// commit.
    #[inline]
    pub(crate) fn mark(&mut self, group: u32) -> bool {
        let is_new = !self.is_marked(group);
        if is_new {
            self.marks[group as usize] = self.epoch + 1;
        }
        is_new
    }

    /// Returns whether a group has been marked or touched since the last commit.
    #[inline]
    pub(crate) fn is_marked(&self, group: u32) -> bool {
        self.marks[group as usize] >= self.epoch
    }

    /// Returns whether the last commit touched a group.
    #[inline]
    pub(crate) fn is_touched(&self, group: u32) -> bool {
        self.marks[group as usize] == self.epoch
    }

    /// Adds a touched group, once.
    #[inline]
    pub(crate) fn add(&mut self, group: u32) {
        if !self.is_marked(group) {
            self.marks[group as usize] = self.epoch;
            self.groups.push(group);
        }
    }
}
