"""Files written by taxel, and frames served by it, read by numpy, pyarrow, openpyxl, mcap with the schemas of Foxglove and of ROS 2, rosbags, pyxdf and
onnx; and Parquet that pyarrow wrote anew, read by taxel.

    python check.py TAXEL REPOSITORY

Every number is held against what taxel writes as text. Nothing is skipped: a library that is missing ends it.
"""

import json
import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import mcap.reader
import mcap_protobuf.decoder
import mcap_ros2.decoder
import numpy as np
import onnx
import onnx.reference
import openpyxl
import pyarrow as pa
import pyarrow.parquet as pq
import pyxdf
from foxglove_schemas_protobuf import Grid_pb2
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

import live

TAXEL, ROOT = sys.argv[1], Path(sys.argv[2])
SENSOR = """format = 1
name = "small"
[array]
rows = 4
columns = 6
pitch_mm = [2.0, 3.0]
taxel_area_mm2 = 5.0
[readout]
topology = "tia-grounded-columns"
v_test_volts = 0.4
r_feedback_ohms = 2000.0
open_loop_gain = 1e5
r_mux_column_ohms = 10.0
r_mux_row_ohms = 10.0
[converter]
bits = 16
full_scale_volts = 2.2
inverted = true
[material]
g_zero_siemens = 1e-6
factor = 8.29e-6
exponent = 0.857
"""
ROWS, COLUMNS, FRAMES = 4, 6, 50
checked = 0


def taxel(words, codes=(0,)):
    run = subprocess.run([TAXEL, *words.split()], capture_output=True, text=True)
    assert run.returncode in codes, f"taxel {words}: {run.returncode}\n{run.stdout}{run.stderr}"
    return run


def same(what, found, expected):
    """The very same numbers, NaN where NaN is."""
    global checked
    found, expected = np.asarray(found, float), np.asarray(expected, float)
    assert found.shape == expected.shape, f"{what}: {found.shape}, expected {expected.shape}"
    assert np.array_equal(found, expected, equal_nan=True), f"{what}: other numbers"
    assert found.size > 0, f"{what}: nothing to compare"
    checked += found.size
    print(f"  {what}: {found.size} numbers")


def frames(name):
    """Frames as text: lines of numbers; words and blanks are no frame's."""
    lines = (line.strip().strip(",") for line in Path(name).read_text().splitlines())
    lines = [line.split(",") for line in lines if line and not line.startswith("time_secs")]
    return np.array(lines, float).reshape(-1, ROWS, COLUMNS)


def times(name):
    lines = Path(name).read_text().splitlines()
    return [float(line.split("=")[1]) for line in lines if line.startswith("time_secs")]


def arrays():
    counts = frames("run.txt")
    for name in ["run.npy", "run.npz", "timed.csv"]:
        taxel(f"convert run.mcap -o {name}")
    array = np.load("run.npy")
    assert array.dtype == np.uint16, array.dtype
    same("numpy, counts in .npy", array, counts)
    with np.load("run.npz") as archive:
        assert archive.files == ["frames"], archive.files
        same("numpy, counts in .npz", archive["frames"], counts)
    for unit, ending in [("N", "npy"), ("siemens", "npz"), ("volts", "npy")]:
        file, text = f"{unit}.{ending}", f"{unit}.csv"
        for output in [file, text]:
            taxel(f"compensate run.txt --sensor sensor.toml --unit {unit} -o {output}")
        array = np.load(file)
        same(f"numpy, {unit} in .{ending}", array if ending == "npy" else array["frames"], frames(text))
    taxel("compensate run.txt --sensor sensor.toml --unit N -o n.npy --marks marks.npy")
    array = np.load("marks.npy")
    assert array.dtype == np.uint8, array.dtype
    same("numpy, marks in .npy", array, frames("N.marks.csv"))


def recording():
    with open("run.mcap", "rb") as file:
        reader = mcap.reader.make_reader(file, validate_crcs=True, decoder_factories=[mcap_protobuf.decoder.DecoderFactory()])
        schemas = {schema.name: schema for schema in reader.get_summary().schemas.values()}
        ours = FileDescriptorSet.FromString(schemas["foxglove.Grid"].data)
        theirs = {}
        pending = [Grid_pb2.DESCRIPTOR]
        while pending:
            one = pending.pop()
            theirs[one.name] = [message.name for message in one.message_types_by_name.values()]
            pending += one.dependencies
        found = {one.name: [message.name for message in one.message_type] for one in ours.file}
        assert {name.split("/")[-1] for name in found} == {name.split("/")[-1] for name in theirs}, (found, theirs)
        grids = ["/taxel/counts", "/taxel/loads"]
        messages = list(reader.iter_decoded_messages(topics=grids))
        events = [json.loads(message.data) for _, _, message in reader.iter_messages(topics=["/taxel/events"])]
        metadata = {one.name: one.metadata for one in reader.iter_metadata()}
    assert metadata["taxel"]["sensor_toml"].count("small") == 1, metadata.keys()
    topics = {}
    for schema, channel, message, decoded in messages:
        topics.setdefault(channel.topic, []).append((message, decoded))
    counts, loads = [], []
    for message, decoded in topics["/taxel/counts"]:
        # Once by the schema in the file, once by Foxglove's own.
        grid = Grid_pb2.Grid.FromString(message.data)
        assert bytes(decoded.data) == grid.data
        assert (grid.cell_size.x, grid.cell_size.y) == (0.003, 0.002), grid.cell_size
        assert [(f.name, f.offset, f.type) for f in grid.fields] == [("counts", 0, 3)], grid.fields
        assert message.log_time == grid.timestamp.ToNanoseconds()
        counts.append(np.frombuffer(grid.data, "<u2").reshape(ROWS, COLUMNS))
    same("mcap and Foxglove's schema, counts", counts, frames("run.txt"))
    published = np.array([message.publish_time for message, _ in topics["/taxel/counts"]])
    since = (published - published[0]) * 1e-9
    assert np.abs(since - times("timed.csv")).max() < 1e-8, "times of the device"
    cell = np.dtype({"names": ["newtons", "mark"], "formats": ["<f4", "u1"], "offsets": [0, 4], "itemsize": grid_stride(topics)})
    for message, _ in topics["/taxel/loads"]:
        grid = Grid_pb2.Grid.FromString(message.data)
        assert [(f.name, f.offset, f.type) for f in grid.fields] == [("newtons", 0, 7), ("mark", 4, 1)], grid.fields
        loads.append(np.frombuffer(grid.data, cell).reshape(ROWS, COLUMNS))
    same("mcap and Foxglove's schema, loads", np.array(loads)["newtons"], frames("N.csv").astype(np.float32))
    same("mcap and Foxglove's schema, marks", np.array(loads)["mark"], frames("N.marks.csv"))
    assert all(set(event) == {"kind", "text"} for event in events), events
    return [message.log_time for message, _ in topics["/taxel/counts"]]


def grid_stride(topics):
    return Grid_pb2.Grid.FromString(topics["/taxel/loads"][0][0].data).cell_stride


def lists(table, column):
    return np.array(table[column].to_pylist()).reshape(-1, ROWS, COLUMNS)


def parquet(log_times):
    taxel("convert run.mcap -o counts.parquet")
    taxel("compensate run.mcap -o loads.parquet")
    taxel("compensate N.siemens.csv --sensor sensor.toml --input-unit siemens -o only.parquet")
    scalars = [("sequence", pa.int64()), ("time_secs", pa.float64()), ("host_time", pa.timestamp("us", tz="UTC"))]
    fixed = lambda kind: pa.list_(pa.field("element", kind, nullable=False), ROWS * COLUMNS)
    counts, loads = [("counts", fixed(pa.uint16()))], [("newtons", fixed(pa.float64())), ("marks", fixed(pa.uint8()))]
    for name, lists_there in [("counts", counts), ("loads", counts + loads), ("only", loads)]:
        file = pq.ParquetFile(f"{name}.parquet")
        schema = [(field.name, field.type) for field in file.schema_arrow]
        assert schema == scalars + lists_there, f"{name}.parquet: {schema}"
        about = {key.decode(): value.decode() for key, value in file.metadata.metadata.items()}
        assert (about["taxel.rows"], about["taxel.columns"]) == (str(ROWS), str(COLUMNS))
        assert 'name = "small"' in about["taxel.sensor_toml"]
        assert file.metadata.num_rows == FRAMES, file.metadata.num_rows
    table = pq.read_table("counts.parquet")
    same("pyarrow, counts", lists(table, "counts"), frames("run.txt"))
    same("pyarrow, sequence", table["sequence"].to_pylist(), range(FRAMES))
    assert np.abs(np.array(table["time_secs"].to_pylist()) - times("timed.csv")).max() < 1e-8
    micros = table["host_time"].cast(pa.int64()).to_pylist()
    same("pyarrow, host_time", micros, [time // 1000 for time in log_times])
    table = pq.read_table("loads.parquet")
    same("pyarrow, counts beside loads", lists(table, "counts"), frames("run.txt"))
    same("pyarrow, newtons", lists(table, "newtons"), frames("N.csv"))
    same("pyarrow, marks", lists(table, "marks"), frames("N.marks.csv"))
    # And back: as it is, and as other programs write it.
    taxel("convert counts.parquet -o back.txt")
    same("taxel, counts of its own Parquet", frames("back.txt"), frames("run.txt"))
    taxel("convert counts.parquet -o back.mcap")
    taxel("convert back.mcap -o back.parquet")
    there, back = pq.read_table("counts.parquet"), pq.read_table("back.parquet")
    for column in ["sequence", "host_time", "counts"]:
        assert back[column].equals(there[column]), f"{column}: Parquet to MCAP and back"
    # Where the device's clock falls back it is set to the host's anew, of which Parquet holds microseconds.
    since = np.array(back["time_secs"].to_pylist()) - there["time_secs"].to_pylist()
    assert np.abs(since).max() < 2e-6, "time_secs: Parquet to MCAP and back"
    rewritten(pq.read_table("loads.parquet"))


def rewritten(table):
    bare = table.replace_schema_metadata(None)
    plain = bare.set_column(3, "counts", pa.array(bare["counts"].to_pylist(), pa.list_(pa.int64())))
    doubles = bare.set_column(3, "counts", pa.array(bare["counts"].to_pylist(), pa.list_(pa.float64())))
    nanos = plain.set_column(2, "host_time", plain["host_time"].cast(pa.timestamp("ns", tz="UTC")))
    extra = plain.append_column("note", pa.array(["x"] * len(plain))).select(["note", "counts", "newtons"])
    for name, one, how in [
        ("metadata kept", table, dict(compression="zstd")),
        ("no metadata", bare, dict(compression="zstd", row_group_size=7)),
        ("int64, one page a row", plain, dict(compression="none", data_page_size=64, write_batch_size=1)),
        ("doubles, no dictionary", doubles, dict(compression="zstd", use_dictionary=False)),
        ("nanoseconds", nanos, dict(compression="zstd")),
        ("other columns", extra, dict(compression="zstd")),
    ]:
        pq.write_table(one, "theirs.parquet", **how)
        taxel("convert theirs.parquet --sensor sensor.toml -o theirs.txt")
        same(f"taxel, pyarrow's Parquet: {name}", frames("theirs.txt"), frames("run.txt"))
    pq.write_table(table, "theirs.parquet", compression="zstd")
    told = json.loads(taxel("info theirs.parquet --values --sensor sensor.toml --json").stdout)
    assert told["frames"] == FRAMES, told
    # What is not read is told.
    pq.write_table(plain, "theirs.parquet", compression="snappy")
    assert "SNAPPY" in taxel("convert theirs.parquet --sensor sensor.toml -o no.txt", codes=(1,)).stderr
    pq.write_table(plain.drop_columns(["counts", "newtons"]), "theirs.parquet")
    assert "no column `counts`" in taxel("convert theirs.parquet --sensor sensor.toml -o no.txt", codes=(1,)).stderr


def tables():
    """An export of `analyse`: as text, as a sheet and as Parquet."""
    for ending in ["csv", "xlsx", "parquet"]:
        taxel(f"analyse screened.txt --sensor masked.toml --row 1 --export table.{ending}")
    header, *lines = Path("table.csv").read_text().splitlines()
    cells = [[float(cell) if cell else math.nan for cell in line.split(",")] for line in lines]
    assert any(math.isnan(cell) for line in cells for cell in line), "an empty cell is to be looked at too"
    book = openpyxl.load_workbook("table.xlsx")
    assert book.sheetnames == ["taxel"], book.sheetnames
    names, *rows = book["taxel"].iter_rows(values_only=True)
    assert ",".join(f'"{name}"' if "," in name else name for name in names) == header, names
    assert all(cell is None or isinstance(cell, (int, float)) for row in rows for cell in row)
    same("openpyxl", [[math.nan if cell is None else cell for cell in row] for row in rows], cells)
    table = pq.read_table("table.parquet")
    assert table.column_names == list(names), table.column_names
    assert all(kind == pa.float64() for kind in table.schema.types), table.schema
    same("pyarrow, table", np.array([column.to_pylist() for column in table.columns]).T, cells)


def images():
    """Loads as images, marks as images, totals as wrenches: beside everything else, and alone in a bag of ROS 2."""
    loads, marks = frames("N.csv").astype(np.float32), frames("N.marks.csv")
    totals = frames("N.csv").sum(axis=(1, 2))
    decoders = [mcap_ros2.decoder.DecoderFactory()]
    found = {}
    with open("run.mcap", "rb") as file:
        reader = mcap.reader.make_reader(file, validate_crcs=True, decoder_factories=decoders)
        for _, channel, message, decoded in reader.iter_decoded_messages(topics=["/taxel/loads/image", "/taxel/marks/image", "/taxel/force"]):
            found.setdefault(channel.topic, []).append(decoded)
    check_images("mcap", found, loads, marks, totals)
    taxel("compensate live.mcap --as ros2 -o bag.mcap")
    found = {}
    with AnyReader([Path("bag.mcap")], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as bag:
        assert len(bag.connections) == 3, bag.connections
        for connection, _, raw in bag.messages():
            found.setdefault(connection.topic, []).append(bag.deserialize(raw, connection.msgtype))
    check_images("rosbags", found, loads, marks, totals)


def check_images(reader, found, loads, marks, totals):
    pixels = {"32FC1": "<f4", "mono8": "u1"}
    for topic, encoding, expected in [("/taxel/loads/image", "32FC1", loads), ("/taxel/marks/image", "mono8", marks)]:
        for image in found[topic]:
            assert (image.encoding, image.height, image.width) == (encoding, ROWS, COLUMNS), image
            assert image.step == COLUMNS * np.dtype(pixels[encoding]).itemsize and image.header.frame_id == "small", image
        arrays = [np.frombuffer(bytes(image.data), pixels[encoding]).reshape(ROWS, COLUMNS) for image in found[topic]]
        same(f"{reader}, {topic}", arrays, expected)
    forces = np.array([message.wrench.force.z for message in found["/taxel/force"]])
    assert np.abs(forces - totals).max() < 1e-9, f"{reader}: totals"


def exports():
    """Loads as other programs read them."""
    loads = frames("N.csv")
    taxel("compensate live.mcap -o loads.xdf")
    streams, header = pyxdf.load_xdf("loads.xdf", dejitter_timestamps=False, synchronize_clocks=False)
    assert header["info"]["version"] == ["1.0"], header
    pressure = next(stream for stream in streams if stream["info"]["type"] == ["Pressure"])
    same("pyxdf, loads", pressure["time_series"].reshape(-1, ROWS, COLUMNS), loads.astype(np.float32))
    since = pressure["time_stamps"] - pressure["time_stamps"][0]
    assert np.abs(since - times("timed.csv")).max() < 1e-9, "times in XDF"
    desc = pressure["info"]["desc"][0]
    channels = desc["channels"][0]["channel"]
    labels = [channel["label"][0] for channel in channels]
    assert labels == [f"r{row}c{column}" for row in range(ROWS) for column in range(COLUMNS)], labels
    assert {channel["unit"][0] for channel in channels} == {"N"}
    assert channels[1]["location"][0] == {"X": ["3"], "Y": ["0"]}, channels[1]
    assert 'name = "small"' in desc["taxel"][0]
    assert int(pressure["footer"]["info"]["sample_count"][0]) == FRAMES
    # Marks are a text for each frame that has some.
    taxel("compensate screened.txt --sensor masked.toml -o marked.xdf", codes=(0, 3))
    marked, _ = pyxdf.load_xdf("marked.xdf", dejitter_timestamps=False, synchronize_clocks=False)
    texts = next(stream for stream in marked if stream["info"]["type"] == ["Markers"])["time_series"]
    assert len(texts) == 1 and texts[0][0].startswith("r1c0 ") and texts[0][0].count(",") == COLUMNS - 1, texts
    taxel("compensate live.mcap --as table -o table-of-loads.csv")
    table = np.genfromtxt("table-of-loads.csv", delimiter=",", names=True)
    assert table.dtype.names[:3] == ("frame", "time_s", "r0c0"), table.dtype.names
    same("numpy, table of loads", np.array(table.tolist())[:, 2:].reshape(-1, ROWS, COLUMNS), loads)


def network():
    """A network of PyTorch, imported and exported, beside onnxruntime's answers to the one it was made of."""
    rows = np.loadtxt(ROOT / "testdata/onnx/torch.csv", delimiter=",")
    eight = SENSOR.replace("columns = 6", "columns = 8")
    Path("eight.toml").write_text(eight)
    taxel("simulate --sensor eight.toml --pattern press --frames 60 --presses presses.csv -o presses.txt")
    network = ROOT / "testdata/onnx/torch.onnx"
    taxel(f"model import {network} --sensor eight.toml --presses presses.csv -o model.safetensors")
    taxel("model export model.safetensors -o model.onnx")
    model = onnx.load("model.onnx")
    onnx.checker.check_model(model, full_check=True)
    found = onnx.reference.ReferenceEvaluator(model).run(None, {"readings": rows[:, :9].astype(np.float32)})[0]
    error = np.abs(found.reshape(-1) - rows[:, 9]).max() / np.abs(rows[:, 9]).max()
    assert error < 1e-5, f"onnx: {error:.1e} of the largest answer"
    print(f"  onnx: {found.size} answers, largest difference {error:.1e} of the largest")


def foxglove():
    """Every frame that Foxglove is served is one of the recording's, to the bit."""
    grids, images, figures = live.served(TAXEL, "live file:run.mcap?speed=0.02")
    expected = frames("N.csv").astype(np.float32)
    served = np.array([np.frombuffer(grid.data, live.CELL).reshape(ROWS, COLUMNS) for grid in grids])
    number = [int(np.flatnonzero((expected == frame).all(axis=(1, 2)))[0]) for frame in served["newtons"]]
    assert len(set(number)) > 5, number
    same("Foxglove, loads served", served["newtons"], expected[number])
    assert {(grid.cell_size.x, grid.cell_size.y, grid.column_count) for grid in grids} == {(0.003, 0.002, COLUMNS)}
    pixels = np.array([np.frombuffer(image.data, "<f4").reshape(image.height, image.width) for image in images])
    assert {image.encoding for image in images} == {"32FC1"}
    same("Foxglove, images served", pixels, served["newtons"])
    totals = np.array([one["total_force_newtons"] for one in figures])
    error = np.abs(totals - served["newtons"].astype(float).sum(axis=(1, 2))).max()
    assert error < 1e-5 * totals.max(), error
    print(f"  Foxglove, total force served: {totals.size} numbers")


def main():
    started = time.monotonic()
    Path("sensor.toml").write_text(SENSOR)
    Path("masked.toml").write_text(SENSOR + "[screen]\nhigh_counts = 65000\n")
    taxel(f"record sim:sensor.toml?hand&fps=400 --frames {FRAMES} --loads -o live.mcap")
    taxel("convert live.mcap -o run.txt")
    taxel("compensate run.txt --sensor sensor.toml --unit N -o N.csv")
    taxel("compensate run.txt --sensor sensor.toml --unit siemens -o N.siemens.csv")
    # Loads of the recording as they are computed from the file, with the live session's out of the way.
    taxel("compensate live.mcap -o run.mcap")
    lines = Path("run.txt").read_text().splitlines()
    lines[ROWS * 3 + 1] = ",".join(["65535"] * COLUMNS) + ","
    Path("screened.txt").write_text("\n".join(lines) + "\n")
    arrays()
    parquet(recording())
    images()
    exports()
    tables()
    network()
    foxglove()
    print(f"{checked} numbers read by others are what taxel says ({time.monotonic() - started:.0f} s)")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        import os

        os.chdir(folder)
        main()
