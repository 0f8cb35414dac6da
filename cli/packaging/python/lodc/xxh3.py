"""XXH3 with 64 bits (Collet), as its specification describes it; long inputs by NumPy."""

import numpy as np

M64 = (1 << 64) - 1
P32 = (0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D)
P64 = (
    0x9E3779B185EBCA87,
    0xC2B2AE3D27D4EB4F,
    0x165667B19E3779F9,
    0x85EBCA77C2B2AE63,
    0x27D4EB2F165667C5,
)
SECRET = bytes.fromhex(
    "b8fe6c3923a44bbe7c01812cf721ad1cded46de9839097db7240a4a4b7b3671f"
    "cb79e64eccc0e578825ad07dccff7221b8084674f743248ee03590e6813a264c"
    "3c2852bb91c300cb88d0658b1b532ea371644897a20df94e3819ef46a9deacd8"
    "a8fa763fe39c343ff9dcbbc7c70b4f1d8a51e04bcdb45931c89f7ec9d9787364"
    "eac5ac8334d3ebc3c581a0fffa1363eb170ddd51b7f0da49d316552629d4689e"
    "2b16be587d47a1fc8ff8b8d17ad031ce45cb3a8f95160428afd7fbcabb4b407e"
)


def _u32(data, at):
    return int.from_bytes(data[at : at + 4], "little")


def _u64(data, at):
    return int.from_bytes(data[at : at + 8], "little")


def _swap64(x):
    return int.from_bytes(x.to_bytes(8, "little"), "big")


def _rotate(x, n):
    return (x << n | x >> (64 - n)) & M64


def _fold(a, b):
    product = a * b
    return (product & M64) ^ (product >> 64)


def _avalanche(h):
    h = (h ^ h >> 37) * 0x165667919E3779F9 & M64
    return h ^ h >> 32


def _avalanche64(h):
    h = (h ^ h >> 33) * P64[1] & M64
    h = (h ^ h >> 29) * P64[2] & M64
    return h ^ h >> 32


def xxh3_64(data, seed=0):
    """Returns the hash of ``data``."""
    data = bytes(data)
    n = len(data)
    if n > 240:
        return _long(data, seed)
    if n > 128:
        return _to_240(data, seed)
    if n > 16:
        return _to_128(data, seed)
    return _to_16(data, seed)


def _to_16(data, seed):
    n = len(data)
    if n > 8:
        low = (_u64(SECRET, 24) ^ _u64(SECRET, 32)) + seed & M64
        high = (_u64(SECRET, 40) ^ _u64(SECRET, 48)) - seed & M64
        low, high = _u64(data, 0) ^ low, _u64(data, n - 8) ^ high
        return _avalanche(n + _swap64(low) + high + _fold(low, high) & M64)
    if n > 3:
        seed ^= int.from_bytes((seed & 0xFFFFFFFF).to_bytes(4, "little"), "big") << 32
        key = (_u64(SECRET, 8) ^ _u64(SECRET, 16)) - seed & M64
        h = (_u32(data, n - 4) + (_u32(data, 0) << 32)) ^ key
        h ^= _rotate(h, 49) ^ _rotate(h, 24)
        h = h * 0x9FB21C651E98DF25 & M64
        h = (h ^ (h >> 35) + n) * 0x9FB21C651E98DF25 & M64
        return h ^ h >> 28
    if n > 0:
        word = data[0] << 16 | data[n >> 1] << 24 | data[n - 1] | n << 8
        key = (_u32(SECRET, 0) ^ _u32(SECRET, 4)) + seed & M64
        return _avalanche64(word ^ key)
    return _avalanche64(seed ^ _u64(SECRET, 56) ^ _u64(SECRET, 64))


def _mix16(data, at, secret, seed):
    low = _u64(data, at) ^ (_u64(SECRET, secret) + seed & M64)
    high = _u64(data, at + 8) ^ (_u64(SECRET, secret + 8) - seed & M64)
    return _fold(low, high)


def _to_128(data, seed):
    n = len(data)
    h = n * P64[0] & M64
    for i in reversed(range((n - 1) // 32 + 1)):
        h += _mix16(data, 16 * i, 32 * i, seed) + _mix16(data, n - 16 * (i + 1), 32 * i + 16, seed)
    return _avalanche(h & M64)


def _to_240(data, seed):
    n = len(data)
    h = n * P64[0] & M64
    for i in range(8):
        h += _mix16(data, 16 * i, 16 * i, seed)
    h = _avalanche(h & M64)
    for i in range(8, n // 16):
        h += _mix16(data, 16 * i, 16 * (i - 8) + 3, seed)
    h += _mix16(data, n - 16, 136 - 17, seed)
    return _avalanche(h & M64)


def _long(data, seed):
    secret = SECRET
    if seed:
        words = [_u64(SECRET, 8 * i) + (-seed if i & 1 else seed) & M64 for i in range(24)]
        secret = b"".join(word.to_bytes(8, "little") for word in words)
    n = len(data)
    blocks = (n - 1) // 1024
    lanes = [P32[2], P64[0], P64[1], P64[2], P64[3], P32[1], P64[4], P32[0]]
    lanes = np.array(lanes, dtype=np.uint64)
    sums = _accumulate(data[: 1024 * blocks], secret, 16)
    key = np.frombuffer(secret, dtype="<u8", count=8, offset=128)
    prime = np.uint64(P32[0])
    shift = np.uint64(47)
    for block in sums:
        lanes = lanes + block
        lanes = (lanes ^ lanes >> shift ^ key) * prime
    rest = (n - 1 - 1024 * blocks) // 64
    tail = data[1024 * blocks : 1024 * blocks + 64 * rest]
    if rest:
        lanes = lanes + _accumulate(tail, secret, rest)[0]
    last = np.frombuffer(data, dtype="<u8", count=8, offset=n - 64)
    key = np.frombuffer(secret, dtype="<u8", count=8, offset=192 - 64 - 7)
    lanes = lanes + _stripe(last[None, None], key[None])[0]
    lanes = [int(lane) for lane in lanes]
    h = n * P64[0] & M64
    for i in range(4):
        at = 11 + 16 * i
        h += _fold(lanes[2 * i] ^ _u64(secret, at), lanes[2 * i + 1] ^ _u64(secret, at + 8))
    return _avalanche(h & M64)


def _stripe(words, keys):
    """Sums what stripes of 8 words add to the lanes; the axes are blocks, stripes, lanes."""
    mixed = words ^ keys
    low = mixed & np.uint64(0xFFFFFFFF)
    swapped = words.reshape(*words.shape[:-1], 4, 2)[..., ::-1].reshape(words.shape)
    return (low * (mixed >> np.uint64(32)) + swapped).sum(axis=1, dtype=np.uint64)


def _accumulate(data, secret, stripes):
    """For each block of ``stripes`` stripes what it adds to the lanes."""
    words = np.frombuffer(data, dtype="<u8").reshape(-1, stripes, 8)
    keys = np.stack([np.frombuffer(secret, "<u8", 8, 8 * i) for i in range(stripes)])
    return _stripe(words, keys)
