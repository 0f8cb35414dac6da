"""The list of wedge groups that a batch passes through (docs/STREAM.md, section 4)."""


class Groups:
    """The list. A group is named by its first vertex; None is after the last."""

    def __init__(self, points):
        self.next = [*range(1, points), None]
        self.count, self.group, self.splits = points, None, 0
        self.left = self.steps_left = 0
        self.first_new = points

    def begin(self, steps):
        """Begins a batch."""
        self.first_new, self.steps_left = len(self.next), steps
        self.group, self.splits, self.left = 0, 0, self.count

    def advance(self):
        """Goes on to the next group."""
        self.group, self.splits = self.next[self.group], 0
        self.left = max(self.left - 1, 0)

    def split(self):
        """Notes a split of the group at hand."""
        self.splits += 1
        self.steps_left -= 1

    def add_vertex(self, is_group):
        """Adds a vertex: a group behind the one at hand, or one of a group."""
        new = len(self.next)
        self.next.append(None)
        if is_group:
            self.next[new], self.next[self.group] = self.next[self.group], new
            self.count += 1
            self.left += 1

    def context(self, contexts, triangles):
        """The context of whether the group at hand is split, by the triangles of its first
        vertex."""
        ratio = max(self.left.bit_length() - self.steps_left.bit_length(), 0)
        state = min(self.splits, 3) + (4 if self.group >= self.first_new else 0)
        return contexts.splits[min(ratio, 7)][state][min(triangles, 9)]
