"""Reads values one after another out of bytes."""

import struct

from .errors import FormatError


class Cursor:
    """The rest of some bytes."""

    def __init__(self, data, place):
        self.data, self.place, self.at = data, place, 0

    def take(self, length):
        """The next bytes."""
        if length > len(self.data) - self.at:
            raise FormatError(self.place, "is truncated")
        self.at += length
        return self.data[self.at - length : self.at]

    def _number(self, form, length):
        return struct.unpack("<" + form, self.take(length))[0]

    def u8(self):
        return self.take(1)[0]

    def u32(self):
        return self._number("I", 4)

    def u64(self):
        return self._number("Q", 8)

    def u128(self):
        return int.from_bytes(self.take(16), "little")

    def f32(self):
        return self._number("f", 4)

    def f64(self):
        return self._number("d", 8)

    def boolean(self):
        """0 or 1."""
        value = self.u8()
        if value > 1:
            raise FormatError(self.place, "has a truth value that is neither 0 nor 1")
        return value == 1

    def string(self):
        try:
            return bytes(self.take(self.u64())).decode("utf-8")
        except UnicodeDecodeError:
            raise FormatError(self.place, "has text that is not UTF-8") from None

    def many(self, read):
        """A list: its length, then each entry as ``read`` reads it."""
        count = self.u64()
        if count > len(self.data) - self.at:
            raise FormatError(self.place, "has a list that is longer than the bytes that are left")
        return [read() for _ in range(count)]

    def optional(self, read):
        return read() if self.boolean() else None

    def record(self, read):
        """A record; what follows its known fields belongs to later versions."""
        length = self.u64()
        end = self.at + length
        if end > len(self.data):
            raise FormatError(
                self.place, "has a record that is longer than the bytes that are left"
            )
        value = read()
        if self.at > end:
            raise FormatError(self.place, "has a record that is shorter than its fields")
        self.at = end
        return value

    def varint(self, most=(1 << 32) - 1):
        """Seven bits in each byte, the lowest first, in the fewest bytes."""
        number = shift = 0
        while True:
            byte = self.u8()
            number |= (byte & 127) << shift
            if byte < 128:
                break
            shift += 7
            if shift > 63:
                raise FormatError(self.place, "has a number that is too large")
        if number > most or byte == 0 and shift:
            raise FormatError(self.place, "has a number that is not written as it should be")
        return number
