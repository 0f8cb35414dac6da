"""Values out of a substream: asymmetric numeral systems from its front, plain bits from its back
(docs/STREAM.md, section 2)."""

RATES = [655360 // (10 * n + 16) for n in range(161)]
MIN_STATE = 1 << 16


class Bit:
    """The context of a bit."""

    __slots__ = ("p", "n")

    def __init__(self):
        self.p, self.n = 32768, 0

    def learn(self, is_set):
        """Moves towards a value that was seen."""
        rate = RATES[self.n]
        if is_set:
            self.p = min(self.p + ((65535 - self.p) * rate >> 16), 65511)
        else:
            self.p = max(self.p - (self.p * rate >> 16), 24)
        if self.n < 160:
            self.n += 1


class Symbol:
    """The context of a symbol."""

    __slots__ = ("m", "n")

    def __init__(self):
        self.m, self.n = [2044 * i for i in range(16)], 2

    def learn(self, value):
        """Moves towards a value that was seen."""
        m, rate = self.m, RATES[self.n]
        for i in range(value + 1):
            m[i] += -m[i] * rate >> 16
        for i in range(value + 1, 16):
            m[i] += (32704 - m[i]) * rate >> 16
        if self.n < 160:
            self.n += 1


class Gamma:
    """The contexts of a number of any size."""

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
        """Whether everything was used, and nothing else."""
        return self.state == MIN_STATE and not self.is_exhausted()

    def is_exhausted(self):
        """Whether more was used than there is."""
        return self.front + (self.bits + 7) // 8 > len(self.data)

    def _advance(self, start, frequency, slot):
        state = frequency * (self.state >> 15) + slot - start
        if state < MIN_STATE:
            word = self.data[self.front : self.front + 2]
            state = state << 16 | (int.from_bytes(word, "little") if len(word) == 2 else 0)
            self.front += 2
        self.state = state

    def bit(self, context):
        slot = self.state & 32767
        half = context.p >> 1
        is_set = slot < half
        if is_set:
            self._advance(0, half, slot)
        else:
            self._advance(half, 32768 - half, slot)
        context.learn(is_set)
        return is_set

    def symbol(self, context):
        slot, m = self.state & 32767, context.m
        value = 15
        while m[value] + 4 * value > slot:
            value -= 1
        start = m[value] + 4 * value
        end = 32768 if value == 15 else m[value + 1] + 4 * (value + 1)
        self._advance(start, end - start, slot)
        context.learn(value)
        return value

    def raw(self, bits):
        """Plain bits, the lowest first: from the last byte backwards, of each its lowest first."""
        value, data = 0, self.data
        for i in range(bits):
            at = len(data) - 1 - (self.bits >> 3)
            if at >= 0:
                value |= (data[at] >> (self.bits & 7) & 1) << i
            self.bits += 1
        return value

    def uniform(self, n):
        bits = n.bit_length() - 1
        short = (1 << bits + 1) - n
        value = self.raw(bits)
        return value if value < short else 2 * value + self.raw(1) - short

    def gamma(self, context):
        high = min(self.symbol(context.high), 8)
        length = min(4 * high + self.symbol(context.low[high]) % 4, 32)
        return length if length < 2 else 1 << length - 1 | self.raw(length - 1)

    def bounded(self, context, n):
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

