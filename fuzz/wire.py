"""What a device sends in protocol taxel-1, sound and broken. Used by broken_inputs.py; not a command of its own."""

import struct
import zlib


def cobs(data):
    out, block = bytearray(), bytearray()
    for byte in data:
        if byte:
            block.append(byte)
        if not byte or len(block) == 254:
            out += bytes([len(block) + 1]) + block
            block = bytearray()
    return bytes(out + bytes([len(block) + 1]) + block)


def packet(counts, rows, columns, sequence, bits=16, sensor=7, micros=None, version=1):
    body = struct.pack("<BBHIQHH", version & 255, bits & 255, sensor & 65535, sequence & 0xFFFFFFFF,
                       (sequence * 10_000 if micros is None else micros) & (1 << 64) - 1, rows & 65535, columns & 65535)
    body += struct.pack(f"<{len(counts)}H", *counts)
    return b"\0" + cobs(body + struct.pack("<I", zlib.crc32(body))) + b"\0"


def packets(rng, data):
    """Whole packets go, come twice or change places; noise between them."""
    frames = [p for p in data.split(b"\0") if p]
    at, how = rng.randrange(len(frames)), rng.randrange(7)
    if how == 0:
        del frames[at]
    elif how == 1:
        frames.insert(at, frames[at])
    elif how == 2:
        other = rng.randrange(len(frames))
        frames[at], frames[other] = frames[other], frames[at]
    elif how <= 4:
        frames.insert(at, rng.randbytes(rng.choice([1, 30, 70_000])).replace(b"\0", b"\1"))
    elif how == 5:
        return data[rng.randrange(len(data)):]
    else:
        return b"\0" * rng.choice([1, 3, 5000]) + data
    return b"\0" + b"\0\0".join(frames) + b"\0"


def forged(rng, data):
    """A packet whose checksum is right and one of whose fields is not true."""
    frames = [p for p in data.split(b"\0") if p]
    at = rng.randrange(len(frames))
    lie = rng.choice(["rows", "columns", "bits", "sensor", "micros", "version", "sequence"])
    said = {"rows": 4, "columns": 5, "sequence": at}
    said[lie] = rng.choice([0, 1, 3, 65535, 1 << 31, 1 << 63, (1 << 64) - 1])
    made = packet([rng.randrange(65536) for _ in range(20)], said.pop("rows"), said.pop("columns"), said.pop("sequence"), **said)
    frames[at] = made.strip(b"\0")
    return b"\0" + b"\0\0".join(frames) + b"\0"
