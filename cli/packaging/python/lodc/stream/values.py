"""Values of new vertices: prediction and residuals (docs/STREAM.md, section 6)."""

import math

from .numbers import MOST, LEAST, to_f32


def wrap(index):
    """An i32."""
    return (index + (1 << 31) & 0xFFFFFFFF) - (1 << 31)


class Layout:
    """The streams of a vertex: of each its first channel, channels, prediction and system."""

    def __init__(self, attributes, systems):
        self.streams, first = [], 0
        kinds = [(3, "smooth")] + [(a.components, _prediction(a)) for a in attributes]
        for (channels, prediction), system in zip(kinds, systems):
            self.streams.append((first, channels, prediction, system))
            first += channels
        self.channels = first


def _prediction(attribute):
    if attribute.meaning in ("joints", "weights", "custom"):
        return "parent"
    direction = attribute.meaning in ("normal", "tangent") and attribute.dtype.kind == "f"
    if direction and attribute.components >= 3 and attribute.morph_target is None:
        return "direction"
    return "smooth"


def code_values(coder, contexts, layout, indices, parent, wedge, link):
    """Decodes the indices of a vertex. ``indices`` has those of all vertices before."""
    out = []
    for s, (first, channels, prediction, systems) in enumerate(layout.streams):
        if s == 0 and wedge is not None:
            out += indices[wedge][:3]
            continue
        slot = s if s < 8 else 0
        if s > 0:
            before = contexts.previous_repeats[slot]
            repeats = coder.bit(contexts.repeats[slot][before])
            contexts.previous_repeats[slot] = int(repeats)
            if repeats:
                out += indices[parent][first : first + channels]
                continue
        smooth = prediction != "parent" and bool(link)
        accuracy, decoded = 0, []
        for channel in range(channels):
            at, used = first + channel, min(channel, 3)
            system = systems[channel]
            guess = indices[parent][at]
            mean_bits = (contexts.mean_bits[slot][used] + 8) // 16
            expected = mean_bits
            if smooth:
                around = [indices[v][at] for v in link]
                guess = _mean(system, around, guess)
                if len(link) > 1:
                    expected = (max(around) - min(around)).bit_length()
                if prediction == "direction" and channel == 2:
                    x, y = decoded
                    square = 1.0 - x * x - y * y
                    if square >= 0:
                        root = to_f32(math.sqrt(square))
                        guess = system.index(-root if system.value(guess) < 0 else root)
                        expected = mean_bits
            context = contexts.residual[slot][used][accuracy]
            residual, length = coder.residual(context, min(expected, 32))
            mean = contexts.mean_bits[slot][used]
            contexts.mean_bits[slot][used] = (15 * mean + 16 * length + 8) // 16
            accuracy = 0 if length + 2 < expected else 1 if length < expected else 2
            index = wrap(guess + residual)
            if prediction == "direction" and channel < 2:
                decoded.append(system.value(index))
            out.append(index)
    return out


def _mean(system, around, parent):
    """The index of the mean over the link."""
    if system.is_even(min(around), max(around)):
        k = len(around)
        offset = sum(around) - k * parent
        if k <= 32:
            offset = offset * ((1 << 24) // k) + (1 << 23) >> 24
        else:
            offset = abs(offset) // k * (1 if offset >= 0 else -1)
        return min(max(parent + offset, LEAST), MOST)
    total = -0.0
    for index in around:
        total += system.value(index)
    mean = to_f32(total / len(around))
    return system.index(mean) if math.isfinite(mean) else parent
