"""XXH3-64 and XXH3-128 with seed 0 and the default secret, for vcd_reader.py (the standard library has neither)."""
import operator
import struct

SECRET = bytes.fromhex(
    "b8fe6c3923a44bbe7c01812cf721ad1cded46de9839097db7240a4a4b7b3671fcb79e64eccc0e578825ad07dccff7221b8084674f743248e"
    "e03590e6813a264c3c2852bb91c300cb88d0658b1b532ea371644897a20df94e3819ef46a9deacd8a8fa763fe39c343ff9dcbbc7c70b4f1d8a"
    "51e04bcdb45931c89f7ec9d9787364eac5ac8334d3ebc3c581a0fffa1363eb170ddd51b7f0da49d316552629d4689e2b16be587d47a1fc8ff8"
    "b8d17ad031ce45cb3a8f95160428afd7fbcabb4b407e")
M32, M64 = 2 ** 32 - 1, 2 ** 64 - 1
P32_1, P32_2, P32_3 = 0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D
P64_1, P64_2, P64_3 = 0x9E3779B185EBCA87, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9
P64_4, P64_5 = 0x85EBCA77C2B2AE63, 0x27D4EB2F165667C5
MX1, MX2 = 0x165667919E3779F9, 0x9FB21C651E98DF25
BLOCK_SECRET = int.from_bytes(b"".join(SECRET[8 * n:8 * n + 64] for n in range(16)), "little")


def u32(data, at):
    return int.from_bytes(data[at:at + 4], "little")


def u64(data, at):
    return int.from_bytes(data[at:at + 8], "little")


def _key(a, b):
    """Two secret words combined."""
    return u64(SECRET, a) ^ u64(SECRET, b)


def _swap(x, size=8):
    return int.from_bytes(x.to_bytes(size, "little"), "big")


def _rotl(x, r, bits=64):
    return ((x << r) | (x >> (bits - r))) & (2 ** bits - 1)


def _fold(a, b):
    p = a * b
    return (p & M64) ^ (p >> 64)


def _avalanche(h):
    h &= M64
    h = ((h ^ (h >> 37)) * MX1) & M64
    return h ^ (h >> 32)


def _avalanche64(h):
    h = ((h ^ (h >> 33)) * P64_2) & M64
    h = ((h ^ (h >> 29)) * P64_3) & M64
    return h ^ (h >> 32)


def _mix16(d, at, s):
    return _fold(u64(d, at) ^ u64(SECRET, s), u64(d, at + 8) ^ u64(SECRET, s + 8))


def _mix_pairs(n):
    """17 to 128 bytes: (from the front, from the back, secret) in the order in which they are mixed."""
    return [(16 * i, n - 16 * i - 16, 32 * i) for i in range((n - 1) // 32, -1, -1)]


def _combine_1_to_3(d, n):
    return d[0] << 16 | d[n >> 1] << 24 | d[n - 1] | n << 8


def _long_accumulate(data):
    """More than 240 bytes: blocks of 16 stripes of 64 bytes, a whole block at a time. The eight lanes are reduced
    modulo 2^64 once a block only."""
    n = len(data)
    acc = [P32_3, P64_1, P64_2, P64_3, P64_4, P32_2, P64_5, P32_1]
    scramble = struct.unpack_from("<8Q", SECRET, 128)

    def accumulate(at, size, secret):
        chunk = data[at:at + size]
        keyed = (int.from_bytes(chunk, "little") ^ secret).to_bytes(size, "little")
        words = struct.unpack(f"<{size // 8}Q", chunk)
        halves = struct.unpack(f"<{size // 4}I", keyed)
        products = list(map(operator.mul, halves[0::2], halves[1::2]))
        for i in range(8):
            acc[i] = (acc[i] + sum(products[i::8]) + sum(words[i ^ 1::8])) & M64

    blocks = (n - 1) // 1024
    for b in range(blocks):
        accumulate(1024 * b, 1024, BLOCK_SECRET)
        for i in range(8):
            acc[i] = ((acc[i] ^ (acc[i] >> 47) ^ scramble[i]) * P32_1) & M64
    rest = (n - 1 - 1024 * blocks) // 64 * 64
    accumulate(1024 * blocks, rest, BLOCK_SECRET & ((1 << 8 * rest) - 1))
    accumulate(n - 64, 64, int.from_bytes(SECRET[121:185], "little"))
    return acc


def _merge(acc, s, start):
    folds = (_fold(acc[2 * i] ^ u64(SECRET, s + 16 * i), acc[2 * i + 1] ^ u64(SECRET, s + 16 * i + 8))
             for i in range(4))
    return _avalanche(start + sum(folds))


def xxh3_64(data):
    """XXH3-64 with seed 0, as a number."""
    d, n = data, len(data)
    if n == 0:
        return _avalanche64(_key(56, 64))
    if n <= 3:
        return _avalanche64(_combine_1_to_3(d, n) ^ u32(SECRET, 0) ^ u32(SECRET, 4))
    if n <= 8:
        h = (u32(d, n - 4) + (u32(d, 0) << 32)) ^ _key(8, 16)
        h = ((h ^ _rotl(h, 49) ^ _rotl(h, 24)) * MX2) & M64
        h = ((h ^ ((h >> 35) + n)) * MX2) & M64
        return h ^ (h >> 28)
    if n <= 16:
        lo, hi = u64(d, 0) ^ _key(24, 32), u64(d, n - 8) ^ _key(40, 48)
        return _avalanche(n + _swap(lo) + hi + _fold(lo, hi))
    if n <= 128:
        return _avalanche(n * P64_1 + sum(_mix16(d, a, s) + _mix16(d, b, s + 16) for a, b, s in _mix_pairs(n)))
    if n <= 240:
        h = _avalanche(n * P64_1 + sum(_mix16(d, 16 * i, 16 * i) for i in range(8)))
        h += sum(_mix16(d, 16 * i, 16 * (i - 8) + 3) for i in range(8, n // 16))
        return _avalanche(h + _mix16(d, n - 16, 119))
    return _merge(_long_accumulate(d), 11, n * P64_1)


def xxh3_128(data):
    """XXH3-128 with seed 0, as a number; `.to_bytes(16, "big")` is the form of *Geometry hash*."""
    d, n = data, len(data)
    if n == 0:
        lo, hi = _avalanche64(_key(64, 72)), _avalanche64(_key(80, 88))
    elif n <= 3:
        c = _combine_1_to_3(d, n)
        lo = _avalanche64(c ^ u32(SECRET, 0) ^ u32(SECRET, 4))
        hi = _avalanche64(_rotl(_swap(c, 4), 13, 32) ^ u32(SECRET, 8) ^ u32(SECRET, 12))
    elif n <= 8:
        m = ((u32(d, 0) + (u32(d, n - 4) << 32)) ^ _key(16, 24)) * (P64_1 + (n << 2))
        lo, hi = m & M64, m >> 64
        hi = (hi + (lo << 1)) & M64
        lo ^= hi >> 3
        lo = ((lo ^ (lo >> 35)) * MX2) & M64
        lo, hi = lo ^ (lo >> 28), _avalanche(hi)
    elif n <= 16:
        first, last = u64(d, 0), u64(d, n - 8)
        m = (first ^ last ^ _key(32, 40)) * P64_1
        lo, hi = ((m & M64) + ((n - 1) << 54)) & M64, m >> 64
        last ^= _key(48, 56)
        hi = (hi + last + (last & M32) * (P32_2 - 1)) & M64
        m = (lo ^ _swap(hi)) * P64_2
        lo, hi = _avalanche(m & M64), _avalanche((m >> 64) + hi * P64_2)
    elif n <= 240:
        lo, hi = n * P64_1 & M64, 0

        def mix32(lo, hi, a, b, s):
            lo = ((lo + _mix16(d, a, s)) & M64) ^ ((u64(d, b) + u64(d, b + 8)) & M64)
            hi = ((hi + _mix16(d, b, s + 16)) & M64) ^ ((u64(d, a) + u64(d, a + 8)) & M64)
            return lo, hi

        if n <= 128:
            for a, b, s in _mix_pairs(n):
                lo, hi = mix32(lo, hi, a, b, s)
        else:
            for at in range(0, 128, 32):
                lo, hi = mix32(lo, hi, at, at + 16, at)
            lo, hi = _avalanche(lo), _avalanche(hi)
            for at in range(128, n // 32 * 32, 32):
                lo, hi = mix32(lo, hi, at, at + 16, at - 125)
            lo, hi = mix32(lo, hi, n - 16, n - 32, 103)
        lo, hi = _avalanche(lo + hi), -_avalanche(lo * P64_1 + hi * P64_4 + n * P64_2) & M64
    else:
        acc = _long_accumulate(d)
        lo, hi = _merge(acc, 11, n * P64_1), _merge(acc, 117, ~(n * P64_2) & M64)
    return hi << 64 | lo
