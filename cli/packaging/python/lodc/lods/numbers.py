"""Number systems: an index stands for each value (docs/STREAM.md, section 6)."""

import math
import struct

import numpy as np

LEAST, MOST = -(1 << 31), (1 << 31) - 1


def to_f32(x):
    """The nearest f32, as a Python float."""
    try:
        return struct.unpack("<f", struct.pack("<f", x))[0]
    except OverflowError:
        return math.copysign(math.inf, x)


def _bits(x):
    return struct.unpack("<I", struct.pack("<f", x))[0]


def _clamp(i):
    return min(max(i, LEAST), MOST)


def _power(k):
    if k <= 22:
        return 10.0**k
    if k <= 44:
        return 1e22 * 10.0 ** (k - 22)
    return 1e22 * 1e22 * 10.0 ** (min(k, 66) - 44)


def _scaled(w, e):
    return w * _power(e) if e >= 0 else w / _power(-e)


def _floor(x):
    """The floor as an i32; NaN becomes 0."""
    if math.isnan(x):
        return 0
    return _clamp(math.floor(x)) if math.isfinite(x) else (MOST if x > 0 else LEAST)


class Float:
    """The bits of a float."""

    def value(self, index):
        number = struct.unpack("<f", struct.pack("<I", (index if index >= 0 else ~index) & MOST))[
            0
        ]
        return number if index >= 0 else -number

    def index(self, x):
        bits = _bits(abs(x))
        return ~bits if math.copysign(1, x) < 0 else bits

    def is_even(self, least, most):
        return least >> 23 == most >> 23


class Decimal:
    """Whole numbers of 10^-n."""

    def __init__(self, digits):
        self.scale = 10.0**digits

    def value(self, index):
        number = to_f32((index if index >= 0 else ~index) / self.scale)
        return number if index >= 0 else -number

    def index(self, x):
        index = _floor(abs(x) * self.scale + 0.5)
        return ~index if math.copysign(1, x) < 0 else index

    def is_even(self, least, most):
        return True


class Significant:
    """Numbers of n significant decimal digits."""

    def __init__(self, digits):
        self.digits, self.least, self.span = digits, 10 ** (digits - 1), 9 * 10 ** (digits - 1)

    def value(self, index):
        m = (index if index >= 0 else ~index) - 1
        if m < 0:
            number = 0.0
        else:
            exponent, mantissa = divmod(m, self.span)
            number = to_f32(_scaled(float(self.least + mantissa), exponent - 45 - self.digits))
        return number if index >= 0 else -number

    def index(self, x):
        index = self._index(min(abs(x), 3.4028234663852886e38))
        return ~index if math.copysign(1, x) < 0 else index

    def _index(self, v):
        if v == 0 or math.isnan(v):
            return 0
        d = (math.frexp(v)[1] - 1) * 1233 >> 12
        if _scaled(1.0, d + 1) <= v:
            d += 1
        elif _scaled(1.0, d) > v:
            d -= 1
        w = _floor(_scaled(v, self.digits - 1 - d) + 0.5)
        if w >= 10 * self.least:
            w, d = self.least, d + 1
        w = max(w, self.least)
        return _clamp((d + 46) * self.span + w - self.least + 1)

    def is_even(self, least, most):
        if least > 0:
            return (least - 1) // self.span == (most - 1) // self.span
        return most < -1 and (~least - 1) // self.span == (~most - 1) // self.span


class Integer:
    """Integers as they are."""

    def value(self, index):
        return index

    def index(self, x):
        return _floor(x)

    def is_even(self, least, most):
        return True


class Grid:
    """Points of a grid: origin + index × step."""

    def __init__(self, origin, step):
        self.origin, self.step = origin, step

    def value(self, index):
        return to_f32(self.origin + index * self.step)

    def index(self, x):
        return _floor((x - self.origin) / self.step + 0.5)

    def is_even(self, least, most):
        return True


class Octahedral:
    """One of the two numbers of a direction: the number itself."""

    def __init__(self, bits):
        self.steps = float((1 << bits) - 2)

    def value(self, index):
        return index

    def index(self, x):
        return _floor(x)

    def is_even(self, least, most):
        return True

    def direction(self, u, v):
        """The unit vector of two indices."""
        x, y = u * 2.0 / self.steps - 1.0, v * 2.0 / self.steps - 1.0
        z = 1.0 - abs(x) - abs(y)
        if z < 0:
            x, y = _folded(x, y)
        length = math.sqrt(x * x + y * y + z * z)
        return x / length, y / length, z / length

    def indices(self, x, y, z):
        """The two indices of a direction of any length."""
        size = abs(x) + abs(y) + abs(z)
        if not (size > 0 and math.isfinite(size)):
            x = y = z = 0.0
        else:
            x, y = x / size, y / size
            if z < 0:
                x, y = _folded(x, y)
        return [nearest((c + 1.0) / 2.0 * self.steps) for c in (x, y)]


def _folded(x, y):
    sign = lambda c: -1.0 if c < 0 else 1.0
    return (1.0 - abs(y)) * sign(x), (1.0 - abs(x)) * sign(y)


def nearest(x):
    """A number rounded half up."""
    return _floor(x + 0.5)


def directions(system, u, v):
    """The three components of many directions."""
    three = [system.direction(int(a), int(b)) for a, b in zip(u, v)]
    return list(np.array(three, np.float64).reshape(-1, 3).astype(np.float32).T)


def values(system, indices, dtype):
    """The values of many indices as an array."""
    indices = np.asarray(indices, np.int64)
    if isinstance(system, Integer):
        return (indices & 0xFFFFFFFF).astype(np.uint32).astype(dtype)
    positive = np.where(indices >= 0, indices, ~indices)
    if isinstance(system, Float):
        numbers = positive.astype(np.uint32).view(np.float32)
    elif isinstance(system, Decimal):
        with np.errstate(over="ignore"):
            numbers = (positive / system.scale).astype(np.float32)
    elif isinstance(system, Grid):
        with np.errstate(over="ignore"):
            return (system.origin + indices * system.step).astype(np.float32)
    else:
        unique, inverse = np.unique(positive, return_inverse=True)
        numbers = np.array([system.value(int(i)) for i in unique], np.float32)[inverse]
    return np.where(indices >= 0, numbers, -numbers)
