"""XXH32 (Collet), as its specification describes it."""

import struct

P1, P2, P3, P4, P5 = 0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D, 0x27D4EB2F, 0x165667B1
M = 0xFFFFFFFF


def _rotl(x, n):
    return (x << n | x >> (32 - n)) & M


def xxh32(data, seed=0):
    """The hash of bytes, as an integer."""
    data = bytes(data)
    lanes, at = [(seed + P1 + P2) & M, (seed + P2) & M, seed & M, (seed - P1) & M], 0
    if len(data) < 16:
        h = (seed + P5) & M
    else:
        at = len(data) & ~15
        for stripe in struct.iter_unpack("<4I", data[:at]):
            lanes = [
                _rotl((v + x * P2) & M, 13) * P1 & M for v, x in zip(lanes, stripe, strict=True)
            ]
        h = sum(_rotl(v, n) for v, n in zip(lanes, (1, 7, 12, 18), strict=True)) & M
    h = (h + len(data)) & M
    while at + 4 <= len(data):
        h = _rotl((h + int.from_bytes(data[at : at + 4], "little") * P3) & M, 17) * P4 & M
        at += 4
    for byte in data[at:]:
        h = _rotl((h + byte * P5) & M, 11) * P1 & M
    h = (h ^ h >> 15) * P2 & M
    h = (h ^ h >> 13) * P3 & M
    return h ^ h >> 16
