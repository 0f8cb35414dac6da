"""All contexts of a stream (docs/STREAM.md, section 3)."""

from .coder import Bit, Gamma, Symbol


def table(make, *sizes):
    """Contexts by one or more indices."""
    if not sizes:
        return make()
    return [table(make, *sizes[1:]) for _ in range(sizes[0])]


class Values:
    """Contexts of values, and states that go on in the same way."""

    def __init__(self):
        self.source = table(Symbol, 8, 4, 4, 5)
        self.which = table(Symbol, 2, 8)
        self.residual = table(Symbol, 9, 4, 3, 2)
        self.last_source = [3] * 8
        self.mean_bits = [[256] * 4 for _ in range(9)]
        self.mode_bits = [64 * 48] * 3


class Contexts:
    """They start once and go on from block to block and from object to object."""

    def __init__(self):
        self.first_index = Gamma()
        self.parent = Symbol()
        self.object = Gamma()
        self.goes_on = Bit()
        self.expected_object = 0
        self.wedge_distance = table(Symbol, 2)
        self.batch = Gamma()
        self.splits = table(Bit, 8, 8, 10)
        self.same_submesh = Bit()
        self.continues = table(Bit, 4, 4)
        self.is_named = Bit()
        self.named = Gamma()
        self.pattern = table(Symbol, 4, 2, 5)
        self.count = table(Symbol, 2)
        self.more = Gamma()
        self.detached = table(Bit, 3, 4)
        self.left = table(Bit, 3, 4)
        self.in_link = table(Bit, 4)
        self.place = table(Symbol, 3, 17)
        self.transferred = table(Bit, 4, 3)
        self.repeats_target = Bit()
        self.same_position = Bit()
        self.values = Values()
        self.point_count = Gamma()
        self.point_wedge = table(Bit, 2)
        self.point_continues = Bit()
        self.point_in_last = Bit()
        self.point_parent = Gamma()
        self.point_next_parent = Gamma()
        self.point_submesh = Bit()
        self.point_values = Values()
        self.error_falls = Bit()
        self.error_drop = Gamma()
        self.rms_falls = Bit()
        self.rms_drop = Gamma()
