"""Ways to break a file: of bytes, lines, tables, TOML, numpy arrays, MCAP, safetensors, ONNX.

Used by broken_inputs.py; not a command of its own. Each breaker takes a random.Random and the whole bytes, and gives the
bytes of the broken file, or a list of pieces where the file is too large to be built at once.
"""

import io
import json
import re
import struct
import zipfile
import zlib

NASTY = ["nan", "inf", "-inf", "-nan", "1e400", "-1", "0", "-0", "1e308", "-1e308", "1e-308", "5e-324", "18446744073709551616",
         "18446744073709551615", "9223372036854775807", "9223372036854775808", "4294967296", "4294967295", "65536", "65535.5",
         "0x10", "1_000", "1e999999999", "\u0663", "\u00bd", "", " ", '""', "''", "[]", "{}", "true", "1979-05-27", "0,01",
         "1e19", "1e30", "1e-300", "3.5e-10", "99999999999999999999999999999999999999", "1" * 400, "+5", "--5", "e", ".", "-"]
# Words for names. Nothing here may be a place that a run could write to outside of its folder: any of them may come to
# stand where an output is named.
WORDS = ["../nowhere/x.csv", "nowhere/x", ".", "", "\u0000", "r.mcap", "x" * 5000, "=cmd", "\u202e", "A0", "ZZZZZZZZZZ9", "-1"]


# ---- bytes

def flips(rng, data):
    data = bytearray(data)
    for _ in range(rng.choice([1, 1, 1, 2, 8, 64])):
        if data:
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(data)


def cut(rng, data):
    return data[:rng.randrange(len(data) + 1)]


def _span(rng, data):
    a, b = sorted((rng.randrange(len(data) + 1), rng.randrange(len(data) + 1)))
    return a, min(b, a + rng.choice([1, 4, 64, 1 << 20]))


def removed(rng, data):
    a, b = _span(rng, data)
    return data[:a] + data[b:]


def doubled(rng, data):
    a, b = _span(rng, data)
    return data[:b] + data[a:b] * rng.choice([1, 1, 3, 50]) + data[b:]


def moved(rng, data):
    a, b = _span(rng, data)
    rest = data[:a] + data[b:]
    at = rng.randrange(len(rest) + 1)
    return rest[:at] + data[a:b] + rest[at:]


def filled(rng, data):
    a, b = _span(rng, data)
    return data[:a] + rng.choice([b"\0", b"\xff", b" ", b"\n", b"9"]) * (b - a) + data[b:]


def inserted(rng, data):
    at = rng.choice([0, 0, len(data), rng.randrange(len(data) + 1)])
    what = rng.choice([b"\0", b"\0" * 40, b"\xef\xbb\xbf", b"\xff\xfe", rng.randbytes(1), rng.randbytes(300), b"\r", b"\n\n\n", b"\x1b[2J"])
    return data[:at] + what + data[at:]


def empty(rng, data):
    return rng.choice([b"", b"", b"\n", b"\0", b" ", b"\0" * 4096, b"\xff" * 4096, b"\n" * 4096])


def lengths(rng, data):
    """A number of 2, 4 or 8 bytes at a random place becomes one that lies."""
    if len(data) < 8:
        return flips(rng, data)
    size, form = rng.choice([(2, "<H"), (4, "<I"), (8, "<Q"), (4, ">I")])
    at = rng.randrange(len(data) - size + 1)
    bits = 8 * size
    value = rng.choice([0, 1, (1 << bits) - 1, (1 << bits - 1) - 1, 1 << bits - 1, (1 << bits) - 8, 1 << rng.randrange(bits), len(data), len(data) + 1])
    return data[:at] + struct.pack(form, value & (1 << bits) - 1) + data[at + size:]


BYTES = [flips, flips, flips, cut, cut, removed, doubled, moved, filled, inserted, empty, lengths]


# ---- lines, tables, TOML

def lines(rng, data):
    rows = data.split(b"\n")
    a = rng.randrange(len(rows))
    b = rng.randrange(len(rows))
    how = rng.randrange(9)
    if how == 0:
        del rows[a:a + rng.choice([1, 1, 3])]
    elif how == 1:
        rows[a:a] = rows[a:a + rng.choice([1, 1, 4])] * rng.choice([1, 2, 30])
    elif how == 2:
        rows[a], rows[b] = rows[b], rows[a]
    elif how == 3:
        rows[a:a + 2] = [b"".join(rows[a:a + 2])]
    elif how == 4:
        return data.replace(b"\n", rng.choice([b"\r\n", b"\r", b"\n\n", b"\n\r", b" "]))
    elif how == 5:
        rows[a] += rng.choice([b",", b"5,", b'5"', b"x", b"0," * 100000, b"[" * 50000, b" " * 100000, b"1" * 100000, b"\"" * 1000])
    elif how == 6:
        rng.shuffle(rows)
    elif how == 7:
        return data.replace(b",", rng.choice([b";", b"\t", b" ", b",,", b", ", b"."]))
    else:
        rows[a] = b"" if how % 2 else rng.randbytes(30).replace(b"\n", b"?")
    return b"\n".join(rows)


def cells(rng, data):
    """One to a few numbers or words become nasty ones; the rest stays."""
    spots = list(re.finditer(rb"-?[0-9][0-9.eE+-]*|[A-Za-z_][A-Za-z_.0-9-]*", data))
    if not spots:
        return inserted(rng, data)
    for spot in sorted(rng.sample(spots, min(len(spots), rng.choice([1, 1, 1, 2, 20]))), key=lambda s: -s.start()):
        word = rng.choice(NASTY if spot.group()[:1].isdigit() or rng.random() < 0.5 else WORDS).encode()
        if rng.random() < 0.2:
            word = str(rng.choice([1, -1]) * 10 ** rng.uniform(-30, 30)).encode()
        data = data[:spot.start()] + word + data[spot.end():]
    return data


def column(rng, data):
    """The same thing happens to a whole column of a table."""
    rows = [row.split(b",") for row in data.split(b"\n")]
    which, how = rng.randrange(max(len(row) for row in rows)), rng.randrange(6)
    word = rng.choice(NASTY).encode()
    for i, row in enumerate(rows):
        if i == 0 or which >= len(row):
            continue
        if how == 0:
            row[which] = word
        elif how == 1:
            row[which] += b"000"
        elif how == 2:
            row[which] = b"0." + row[which]
        elif how == 3:
            del row[which]
        elif how == 4:
            row[which] = rows[1][which] if which < len(rows[1]) else word
        else:
            row[which] = rng.choice(rows[1:])[-1]
    return b"\n".join(b",".join(row) for row in rows)


def toml(rng, data):
    rows = data.decode(errors="replace").split("\n")
    keys = [i for i, row in enumerate(rows) if "=" in row]
    at = rng.choice(keys or [0])
    name = rows[at].split("=")[0].strip() or "a"
    how = rng.randrange(13)
    if how <= 3:
        rows[at] = f"{name} = {rng.choice(NASTY)}"
    elif how == 4:
        rows[at] = f"{name} = [{', '.join(rng.choice(NASTY[:20] + ['1.0'] * 40) for _ in range(rng.choice([1, 4, 5, 20, 4097])))}]"
    elif how == 5:
        del rows[at]
    elif how == 6:
        rows.insert(at, rows[at])
    elif how == 7:
        rows.append(f"{name} = " + rng.choice(["[" * 100_000, "{a=" * 50_000, "[" * 127 + "]" * 127, "[" * 40_000 + "]" * 40_000]))
    elif how == 8:
        rows.append(".".join("a" * rng.choice([1, 3]) for _ in range(rng.choice([100, 50_000]))) + " = 1")
    elif how == 9:
        rows.append("[" + ".".join(["b"] * rng.choice([100, 20_000])) + "]")
    elif how == 10:
        rows.append(f"name = \"{'x' * rng.choice([10_000, 3_000_000])}\"")
    elif how == 11:
        shape = rng.choice([("rows", 1), ("rows", 0), ("rows", 4096), ("rows", 4097), ("columns", 1), ("columns", 4096), ("rows", 256), ("columns", 256)])
        rows = [f"{shape[0]} = {shape[1]}" if row.split("=")[0].strip() == shape[0] else row for row in rows]
        if rng.random() < 0.3:
            rows = ["rows = 4096" if row.startswith("rows") else "columns = 4096" if row.startswith("columns") else row for row in rows]
    else:
        rows[at] = rows[at].replace("=", rng.choice(["= -", "= \"", "=", "= [", ":", "= 1e", "==", "= {x = "]), 1)
    return "\n".join(rows).encode()


def huge_line(rng, data):
    """A file of tens of megabytes without a line feed."""
    unit = rng.choice([b"[", b"a", b"1,", b"\0", b" ", b"a=[", b"\"x\","])
    return [data[:rng.randrange(len(data) + 1)]] + [unit * ((1 << 20) // len(unit))] * rng.choice([8, 48])


# ---- numpy

def npy_header(rng, data):
    text = rng.choice([
        "{{'descr': '{d}', 'fortran_order': {f}, 'shape': {s}, }}", "{{'shape': {s}, 'descr': '{d}', 'fortran_order': {f}}}",
        "{{'descr': [('a', '{d}')], 'fortran_order': {f}, 'shape': {s}}}", "{{'descr': '{d}'}}", "(" * 50_000, "{{" * 20_000, ""])
    shape = rng.choice([
        "(40, 4, 5)", "(4, 5)", "(40, 5, 4)", "(18446744073709551615, 4, 5)", "(4294967296, 4294967296, 2)", "(-1, 4, 5)", "()", "(0, 4, 5)",
        "(40, 0, 5)", "(1, 4096, 4096)", "(1000000000, 4, 5)", "(40, 4, 5, 1)", "(40L, 4L, 5L)", "(1.5, 4, 5)", "(" * 9000, "(" + "1," * 20_000 + ")",
        "(2, 65536, 65536)", "(9223372036854775807, 4, 5)"])
    kind = rng.choice(["<f8", ">f8", "<f4", "|u1", "<u2", ">u2", "<i8", "<u8", "<f2", "<c16", "|O", "<U9", "|V8", "<i4", "f8", "<f999999999999"])
    head = text.replace("{d}", kind).replace("{f}", rng.choice(["False", "False", "True", "1"])).replace("{s}", shape).replace("{{", "{").replace("}}", "}").encode() + b"\n"
    version = rng.choice([(1, 0), (1, 0), (2, 0), (3, 0), (9, 9), (0, 0)])
    length = rng.choice([len(head)] * 6 + [0, 65535, 4294967295, len(head) + 100, max(0, len(head) - 5)])
    form = "<H" if version[0] < 2 else "<I"
    length = min(length, 65535 if form == "<H" else 4294967295)
    at = data.find(b"\n") + 1
    return b"\x93NUMPY" + bytes(version) + struct.pack(form, length) + head + data[at:]


def npz(rng, data):
    """A sound archive around something else: a bomb, two arrays, a wrong name, a broken array, a lie about sizes."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        array = archive.read(archive.namelist()[0])
    made, how = io.BytesIO(), rng.randrange(8)
    with zipfile.ZipFile(made, "w", rng.choice([zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])) as archive:
        if how == 0:
            archive.writestr("a.txt", b"no array")
        elif how == 1:
            archive.writestr("a.npy", npy_header(rng, array))
        elif how == 2:
            archive.writestr("../../a.npy", rng.choice(BYTES)(rng, array))
        elif how == 3:
            for i in range(rng.choice([0, 2, 3000])):
                archive.writestr(f"{i}.npy", array if i < 3 else b"")
        elif how == 4:
            archive.writestr("x" * 60_000 + ".npy", array)
        elif how >= 5:
            archive.compression = zipfile.ZIP_DEFLATED
            rows, columns = rng.choice([(4, 5), (4096, 4096), (20_000, 20_000), (1, 4096)])
            with archive.open("bomb.npy", "w") as file:
                head = b"{'descr': '<u2', 'fortran_order': False, 'shape': (%d, %d, %d), }\n" % (rng.choice([1, 5, 1000]), rows, columns)
                file.write(b"\x93NUMPY\1\0" + struct.pack("<H", len(head)) + head)
                for _ in range(rng.choice([1, 24])):
                    file.write(bytes(1 << 22))
    made = bytearray(made.getvalue())
    if rng.random() < 0.3:
        # sizes in the central directory
        at = made.rfind(b"PK\1\2")
        if at >= 0:
            at += rng.choice([20, 24, 8, 10, 42, 28, 30])
            made[at:at + 4] = struct.pack("<I", rng.choice([0, 1, 0xFFFFFFFF, 0x7FFFFFFF, 1 << 28]))
    return bytes(made)


# ---- MCAP

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, STATISTICS, METADATA, DATA_END = 1, 2, 3, 4, 5, 6, 0xB, 0xC, 0xF


def mcap_records(data):
    """(opcode, content) of each record of the file."""
    at, found = 8, []
    while at + 9 <= len(data) - 8:
        size = struct.unpack_from("<Q", data, at + 1)[0]
        if at + 9 + size > len(data):
            break
        found.append((data[at], data[at + 9:at + 9 + size]))
        at += 9 + size
    return found


def mcap_file(records):
    return MAGIC + b"".join(bytes([op]) + struct.pack("<Q", len(content)) + content for op, content in records) + MAGIC


def mcap_string(text):
    text = text if isinstance(text, bytes) else text.encode()
    return struct.pack("<I", len(text)) + text


def mcap_chunk(records, compression="", inside=None, claimed=None, crc=None):
    inside = b"".join(bytes([op]) + struct.pack("<Q", len(c)) + c for op, c in records) if inside is None else inside
    packed = zstd_raw(inside) if compression == "zstd" else inside
    size = len(inside) if claimed is None else claimed
    return struct.pack("<QQQI", 0, 1 << 40, size, zlib.crc32(inside) if crc is None else crc) + mcap_string(compression) + struct.pack("<Q", len(packed)) + packed


def zstd_raw(data):
    """A zstd frame of uncompressed blocks."""
    blocks = [data[i:i + 100_000] for i in range(0, len(data), 100_000)] or [b""]
    out = b"\x28\xb5\x2f\xfd\x00\x58"
    for i, block in enumerate(blocks):
        out += struct.pack("<I", (len(block) << 3) | (i == len(blocks) - 1))[:3] + block
    return out


def zstd_bomb(size):
    """A zstd frame of `size` zeros in blocks of one repeated byte."""
    n = max(1, size >> 17)
    return b"\x28\xb5\x2f\xfd\x00\x58" + b"".join(struct.pack("<I", ((1 << 17) << 3) | 2 | (i == n - 1))[:3] + b"\0" for i in range(n))


def _varint(n):
    out = b""
    while n > 127:
        out, n = out + bytes([n & 127 | 128]), n >> 7
    return out + bytes([n])


def _field(number, content):
    if isinstance(content, int):
        return _varint(number << 3) + _varint(content)
    return _varint(number << 3 | 2) + _varint(len(content)) + content


def grid(rng, counts, rows, columns, broken=False):
    """foxglove.Grid of one field `counts`; broken: one of its numbers lies."""
    lie = rng.randrange(10) if broken else -1
    fixed = lambda number, value: _varint(number << 3 | 5) + struct.pack("<I", value)
    wild = rng.choice([0, 1, 3, 65535, 0xFFFFFFFF, 0x7FFFFFFF, 4097])
    data = struct.pack(f"<{rows * columns}H", *counts)
    if lie == 0:
        data = data[:rng.randrange(len(data))]
    kind = wild if lie == 1 else 3
    name = b"x" * 70_000 if lie == 2 else b"counts"
    cell = _field(1, name) + fixed(2, wild if lie == 3 else 0) + _field(3, kind)
    size = b"\x09" + struct.pack("<d", rng.choice([0.0, -1.0, float("nan"), 1e308]) if lie == 4 else 2e-3) + b"\x11" + struct.pack("<d", 2e-3)
    out = (_field(1, _field(1, 1_700_000_000) + _field(2, 5)) + _field(2, b"taxel") + fixed(4, wild if lie == 5 else columns) + _field(5, size)
           + fixed(6, wild if lie == 6 else 2 * columns) + fixed(7, wild if lie == 7 else 2))
    if lie == 8:
        out += b"\x1a\x04" * 20_000
    return out + _field(8, cell) * (3000 if lie == 9 else 1) + _field(9, data)


def mcap_made(rng, sensor_toml, rows, columns, frames=12, lie=False):
    """A recording without compression, made here; with `lie` one thing in it is not true."""
    how = rng.randrange(14) if lie else -1
    meta = mcap_string("taxel") + mcap_string(mcap_string("sensor_toml") + mcap_string(sensor_toml) + mcap_string("program") + mcap_string("taxel"))
    if how == 0:
        meta = mcap_string("taxel") + mcap_string(mcap_string("sensor_toml") + mcap_string(toml(rng, sensor_toml)))
    schema = struct.pack("<H", 1) + mcap_string("foxglove.Grid") + mcap_string("protobuf") + mcap_string(b"")
    channel = struct.pack("<HH", 0, 1) + mcap_string("/taxel/counts") + mcap_string("protobuf") + mcap_string(b"")
    if how == 1:
        schema = struct.pack("<H", rng.choice([0, 7])) + schema[2:]
    if how == 2:
        channel = struct.pack("<HH", rng.choice([0, 7]), rng.choice([0, 9])) + channel[4:]
    chunks = []
    bad = rng.randrange(frames)
    for i in range(frames):
        shape = (rows, columns) if not (how == 3 and i == bad) else (columns + 1, rows)
        counts = [rng.randrange(200, 60_000) for _ in range(shape[0] * shape[1])]
        when = 1_700_000_000_000_000_000 + i * 10_000_000
        if how == 4 and i == bad:
            when = rng.choice([0, 1, (1 << 64) - 1, 1 << 63, 5])
        sequence = rng.choice([0, 0xFFFFFFFF, i - 1 & 0xFFFFFFFF, 1 << 31]) if how == 5 and i == bad else i
        content = grid(rng, counts, *shape, broken=(how in (6, 7, 8, 9) and i == bad))
        chunks.append((MESSAGE, struct.pack("<HIQQ", 0, sequence, when, when) + content))
    inside = [(SCHEMA, schema), (CHANNEL, channel)]
    records = [(HEADER, mcap_string("taxel") + mcap_string("made")), (METADATA, meta)]
    for at in range(0, frames, 4):
        records.append((CHUNK, mcap_chunk(inside + chunks[at:at + 4], rng.choice(["", "zstd"]))))
    if how == 10:
        size = rng.choice([1 << 26, 1 << 28, 1 << 30])
        bomb = zstd_bomb(size)
        records.insert(2, (CHUNK, struct.pack("<QQQI", 0, 1 << 62, rng.choice([size, 100, 1 << 40]), 0) + mcap_string("zstd") + struct.pack("<Q", len(bomb)) + bomb))
    if how == 11:
        nested = mcap_chunk(inside + chunks)
        for _ in range(rng.choice([1, 30, 3000])):
            nested = mcap_chunk([(CHUNK, nested)])
            if len(nested) > 4_000_000:
                break
        records[2] = (CHUNK, nested)
    if how == 12:
        records[2:3] = [(METADATA, mcap_string("taxel") + mcap_string(mcap_string("sensor_toml") + mcap_string(b"[" * 100_000)))] * rng.choice([1, 200])
    if how == 13:
        records[2:3] = [(SCHEMA, struct.pack("<H", i) + schema[2:]) for i in range(rng.choice([300, 65536]))]
    before = mcap_file(records)[:-8]
    records.append((DATA_END, struct.pack("<I", zlib.crc32(before))))
    summary = len(before) + 9 + 4
    first, last = 1_700_000_000_000_000_000, 1_700_000_000_000_000_000 + (frames - 1) * 10_000_000
    numbers = struct.pack("<QHIIIIQQ", frames, 1, 1, 0, 1, len([1 for op, _ in records if op == CHUNK]), first, last)
    records.append((STATISTICS, numbers + struct.pack("<IHQ", 10, 0, frames)))
    return mcap_file(records + [(FOOTER, struct.pack("<QQI", summary, 0, 0))])


def mcap(rng, data):
    """Whole records go, come twice, change places, lie about their length, or hold something else."""
    records = mcap_records(data)
    if not records:
        return flips(rng, data)
    at, how = rng.randrange(len(records)), rng.randrange(11)
    op, content = records[at]
    if how == 0:
        del records[at]
    elif how == 1:
        records.insert(at, records[at])
    elif how == 2:
        other = rng.randrange(len(records))
        records[at], records[other] = records[other], records[at]
    elif how == 3:
        records[at] = (rng.choice([0, 1, 2, 3, 4, 5, 6, 7, 11, 12, 15, 0x7F, 0x80, 0xFF]), content)
    elif how == 4:
        records[at] = (op, content[:rng.randrange(len(content) + 1)])
    elif how == 5:
        records[at] = (op, lengths(rng, content))
    elif how == 6:
        made = mcap_file(records)
        place = 8 + sum(9 + len(c) for _, c in records[:at]) + 1
        lie = rng.choice([0, 1, len(content) - 1, len(content) + 1, 1 << 31, 1 << 40, (1 << 63) - 1, (1 << 64) - 1, (1 << 64) - 9])
        return made[:place] + struct.pack("<Q", lie & (1 << 64) - 1) + made[place + 8:]
    elif how == 7:
        chunks = [i for i, (o, _) in enumerate(records) if o == CHUNK]
        if chunks:
            which = rng.choice(chunks)
            old = records[which][1]
            field, size = rng.choice([(0, 8), (8, 8), (16, 8), (24, 4), (28, 4)])
            lie = rng.choice([0, 1, 1 << 20, 1 << 31, (1 << 8 * size) - 1]) & (1 << 8 * size) - 1
            records[which] = (CHUNK, old[:field] + lie.to_bytes(size, "little") + old[field + size:])
    elif how == 8:
        records = records[:at]
    elif how == 9:
        records.insert(at, (rng.choice([0x40, 0x90, 9, 8]), rng.randbytes(rng.choice([0, 5, 3000]))))
    else:
        records[at] = (op, flips(rng, content))
    return mcap_file(records)


# ---- networks

def safetensors(rng, data):
    size = struct.unpack_from("<Q", data)[0]
    head, rest, how = data[8:8 + size], data[8 + size:], rng.randrange(8)
    if how == 0:
        return struct.pack("<Q", rng.choice([0, 1, size - 1, size + 1, len(data), 1 << 33, (1 << 64) - 1, 100_000_001])) + data[8:]
    if how == 1:
        head = rng.choice([b"[" * 100_000, b'{"a":' * 50_000, b"{}", b"null", b'{"__metadata__":{"card":"' + b"[" * 60_000 + b'"}}'])
    elif how <= 4:
        try:
            held = json.loads(head)
            card = json.loads(held["__metadata__"]["card"])
            if how == 2:
                name = rng.choice([k for k in held if k != "__metadata__"])
                held[name][rng.choice(["shape", "data_offsets"])] = rng.choice([[0, 0], [1, 1 << 62], [1 << 32, 1 << 32], [-1, 5], [], [4, 4], [1] * 1000, [len(rest), 0]])
            else:
                key = rng.choice(list(card))
                card[key] = rng.choice([None, -1, 1e300, "", [], {}, "x" * 100_000, [[]] * 1000, 1 << 64, [1e308] * 7, card[rng.choice(list(card))]])
                held["__metadata__"]["card"] = json.dumps(card)
            head = json.dumps(held).encode()
        except (ValueError, KeyError, IndexError):
            head = flips(rng, head)
    elif how == 5:
        head = cells(rng, head)
    elif how == 6:
        wild = struct.pack("<f", rng.choice([float("nan"), float("inf"), 3e38, -3e38, 1e-45]))
        at = 4 * rng.randrange(max(1, len(rest) // 4))
        rest = rest[:at] + wild * rng.choice([1, 20]) + rest[at:]
        rest = rest[:len(data) - 8 - size]
    else:
        return rng.choice(BYTES)(rng, data)
    return struct.pack("<Q", len(head)) + head + rest


def onnx(rng, data):
    how = rng.randrange(6)
    if how == 0:
        inside = b"\x0a\x01x"
        for _ in range(rng.choice([200, 20_000])):
            inside = _field(rng.choice([7, 1, 5, 6]), inside)
            if len(inside) > 300_000:
                break
        return inside
    if how == 1:
        return data + _field(7, _field(1, b"") * 100_000)
    if how == 2:
        at = rng.randrange(len(data))
        return data[:at] + b"\xff" * rng.choice([1, 9, 10]) + data[at:]
    return rng.choice(BYTES)(rng, data)
