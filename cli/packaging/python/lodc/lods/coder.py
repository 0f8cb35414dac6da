"""Values out of a substream: asymmetric numeral systems from its front, plain bits from its back.

All numbers here are contracts of the format: docs/STREAM.md, section 2, gives them and the reasons.
"""

# The rate of adaptation after n observations, of 65,536: 1 / (n + 1.6).
RATES = [655360 // (10 * n + 16) for n in range(161)]
MIN_STATE = 1 << 16


class Bit:
    """The adaptive probability of a bit: that it is set, of 65,536."""

    __slots__ = ("count", "probability")

    def __init__(self):
        self.probability, self.count = 32768, 0

    def update(self, is_set):
        """Moves the estimate towards an observed value."""
        rate, p = RATES[self.count], self.probability
        if is_set:
            self.probability = min(p + ((65535 - p) * rate >> 16), 65511)
        else:
            self.probability = max(p - (p * rate >> 16), 24)
        if self.count < 160:
            self.count += 1


class Symbol:
    """The adaptive frequencies of sixteen symbols: for each the sum of those below it, of 32,768
    without the four that every symbol has besides."""

    __slots__ = ("count", "cumulative")

    def __init__(self):
        self.cumulative, self.count = [2044 * i for i in range(16)], 2

    def update(self, value):
        """Moves the estimates towards an observed value. Shifts of negative numbers round down."""
        sums, rate = self.cumulative, RATES[self.count]
        for i in range(value + 1):
            sums[i] += -sums[i] * rate >> 16
        for i in range(value + 1, 16):
            sums[i] += (32704 - sums[i]) * rate >> 16
        if self.count < 160:
            self.count += 1


class Gamma:
    """The contexts of a number of any size: of its length in bits, by quarters, and the rest."""

    def __init__(self):
        self.high, self.low = Symbol(), [Symbol() for _ in range(9)]


class Substream:
    """Decodes one substream."""

    def __init__(self, data):
        self.data = data = bytes(data)
        self.front, self.bits = 0, 0
        self.state = MIN_STATE
        if len(data) >= 4:
            self.state, self.front = int.from_bytes(data[:4], "little"), 4

    def is_finished(self):
        """Whether exactly all of the data was used."""
        return self.state == MIN_STATE and not self.is_exhausted()

    def is_exhausted(self):
        """Whether more data was used than there is."""
        return self.front + (self.bits + 7) // 8 > len(self.data)

    def _advance(self, start, frequency, slot):
        state = frequency * (self.state >> 15) + slot - start
        if state < MIN_STATE:
            word = self.data[self.front : self.front + 2]
            state = state << 16 | (int.from_bytes(word, "little") if len(word) == 2 else 0)
            self.front += 2
        self.state = state

    def bit(self, context):
        """A bit with an adaptive probability."""
        slot = self.state & 32767
        set_frequency = context.probability >> 1
        is_set = slot < set_frequency
        if is_set:
            self._advance(0, set_frequency, slot)
        else:
            self._advance(set_frequency, 32768 - set_frequency, slot)
        context.update(is_set)
        return is_set

    def symbol(self, context):
        """A symbol from 0 to 15 with adaptive frequencies."""
        slot, sums = self.state & 32767, context.cumulative
        value = 15
        while sums[value] + 4 * value > slot:
            value -= 1
        start = sums[value] + 4 * value
        end = 32768 if value == 15 else sums[value + 1] + 4 * (value + 1)
        self._advance(start, end - start, slot)
        context.update(value)
        return value

    def raw(self, bits):
        """A number of ``bits`` plain bits, the lowest first. Bytes are used from the last one
        backwards, the bits of each from the lowest."""
        value, data = 0, self.data
        for i in range(bits):
            at = len(data) - 1 - (self.bits >> 3)
            if at >= 0:
                value |= (data[at] >> (self.bits & 7) & 1) << i
            self.bits += 1
        return value

    def uniform(self, n):
        """A number below ``n``, all as likely: the first ones take a bit less than the others."""
        bits = n.bit_length() - 1
        short = (1 << bits + 1) - n
        value = self.raw(bits)
        return value if value < short else 2 * value + self.raw(1) - short

    def gamma(self, context):
        """A number of any size: its length as two symbols, then all but its highest bit."""
        high = min(self.symbol(context.high), 8)
        length = min(4 * high + self.symbol(context.low[high]) % 4, 32)
        return length if length < 2 else 1 << length - 1 | self.raw(length - 1)

    def bounded(self, context, n):
        """A number below ``n``: how much shorter it is than the longest, then its bits."""
        longest = (n - 1).bit_length()
        saved = self.symbol(context)
        if saved == 15:
            return self.raw(max(longest - 15, 0))
        length = max(longest - saved, 0)
        if length < 2:
            return length
        half = 1 << length - 1
        return half + (self.uniform(n - half) if saved == 0 else self.raw(length - 1))

    def residual(self, context, expected):
        """A signed number whose length in bits is predicted as ``expected``, and its length."""
        symbol = self.symbol(context)
        if symbol == 0:
            return 0, 0
        length = self.uniform(32) + 1 if symbol == 15 else symbol - 10 + expected
        length = min(max(length, 1), 32)
        value = 1 << length - 1 | self.raw(length - 1)
        return (-value if self.raw(1) else value), length

