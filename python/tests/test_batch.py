"""An archive by the module: what `taxel batch` makes of it, on threads, processes and a cluster."""

from __future__ import annotations

import csv
import functools
import hashlib
import multiprocessing
import os
import pickle
import signal
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import taxel
from taxel._batch import Settings

SENSOR = "mat-16x16-cd4067"


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Recordings of three formats, one of them cut, one that is none."""
    folder = tmp_path_factory.mktemp("archive")
    paths: list[str] = []
    for seed, name in enumerate(["a.npy", "b.txt", "c.npy", "d.npy", "e.npy"]):
        counts = taxel.simulate(SENSOR, pattern="hand", frames=40, seed=seed).counts
        path = folder / name
        if path.suffix == ".npy":
            np.save(path, counts)
        else:
            lines = [",".join(str(int(count)) for count in row) for frame in counts for row in frame]
            path.write_text("\n".join(lines[:-1]) + "\n")
        paths.append(str(path))
    (folder / "f.npy").write_bytes(b"no array")
    return [*paths, str(folder / "f.npy")]


def contents(folder: Path) -> dict[str, bytes]:
    """Everything below a folder that is the same in every run."""
    files = (path for path in folder.rglob("*") if path.is_file())
    timed = ("entry.json", "manifest.csv", "summary.parquet")
    return {str(path.relative_to(folder)): path.read_bytes() for path in files if not path.name.endswith(timed)}


def test_it_is_what_the_command_makes(archive: list[str], command: Callable[..., str], tmp_path: Path) -> None:
    command("batch", *archive, "--sensor", SENSOR, "--out", tmp_path / "command", code=3)
    table = taxel.map(archive, tmp_path / "module", sensor=SENSOR)
    assert contents(tmp_path / "module") == contents(tmp_path / "command")
    assert table["status"].tolist() == ["done", "incomplete", "done", "done", "done", "broken"]
    with open(tmp_path / "command" / "summary.csv", encoding="utf-8", newline="") as file:
        lines = list(csv.DictReader(file))
    assert sorted(lines[0]) == sorted(table)
    for name in table:
        for cell, line in zip(table[name], lines, strict=True):
            if isinstance(cell, str):
                assert cell.replace("\n", "; ") == line[name]
            elif line["status"] != "broken":
                assert np.isnan(cell) if line[name] == "" else float(line[name]) == cell
    measured = taxel.measure(archive[0], sensor=SENSOR, intervals=False)
    peak = measured.series["total_n"].max()
    assert table["peak_force_n"][0] == pytest.approx(peak, rel=1e-9)
    assert table.to_pandas().shape == (6, len(table))


def test_a_manifest_says_what_was_made_of_what_and_with_what(archive: list[str], tmp_path: Path) -> None:
    taxel.map(archive, tmp_path, sensor=SENSOR)
    with open(tmp_path / "manifest.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["recording"] for row in rows] == archive
    for path, row in zip(archive, rows, strict=True):
        content = Path(path).read_bytes()
        assert int(row["bytes"]) == len(content) and row["sha256"] == hashlib.sha256(content).hexdigest()
        assert row["program"] == f"taxel {taxel.__version__}" and float(row["seconds"]) >= 0.0
    assert len({row["settings_sha256"] for row in rows}) == 1 and len(rows[0]["settings_sha256"]) == 64
    assert [row["status"] for row in rows] == ["done", "incomplete", "done", "done", "done", "broken"]
    other = taxel.map(archive, tmp_path / "other", sensor=SENSOR, repair=True)
    with open(tmp_path / "other" / "manifest.csv", encoding="utf-8", newline="") as file:
        assert next(csv.DictReader(file))["settings_sha256"] != rows[0]["settings_sha256"]
    # What broke is told in several lines: a table of them is still one.
    other.to_csv(tmp_path / "table.csv")
    with open(tmp_path / "table.csv", encoding="utf-8", newline="") as file:
        read = list(csv.DictReader(file))
    assert [row["recording"] for row in read] == archive and "\n" in read[-1]["error"]


def test_called_again_it_does_what_is_missing(archive: list[str], tmp_path: Path) -> None:
    first = taxel.map(archive[:2], tmp_path, sensor=SENSOR, workers=1)
    dates = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.entry.json")}
    again = taxel.map(archive, tmp_path, sensor=SENSOR, pictures=False)
    assert first == taxel.Table({name: again[name][:2] for name in again})
    assert all(path.stat().st_mtime_ns == date for path, date in dates.items())


def test_processes_may_share_a_folder(archive: list[str], tmp_path: Path) -> None:
    """The recipe for Dask, joblib and the like: a function of one path that can be pickled."""
    one = functools.partial(taxel.map, out=str(tmp_path), sensor=taxel.Sensor(SENSOR), workers=1, summary=False)
    one = pickle.loads(pickle.dumps(one))
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        tables = pool.map(one, archive)
    assert not (tmp_path / "summary.csv").exists()
    whole = taxel.map(archive, tmp_path, sensor=SENSOR)
    for place, table in enumerate(tables):
        assert table == taxel.Table({name: whole[name][place : place + 1] for name in whole})


def test_what_cannot_be_is_said(archive: list[str], tmp_path: Path) -> None:
    with pytest.raises(taxel.Error, match="under one name"):
        taxel.map([archive[0], archive[0]], tmp_path, sensor=SENSOR)
    with pytest.raises(taxel.Error, match="loads are written as"):
        taxel.map(archive, tmp_path, sensor=SENSOR, loads="xls")
    with pytest.raises(taxel.Error, match="cannot make the folder"):
        taxel.map(archive, archive[0], sensor=SENSOR)
    tables = taxel.Sensor(SENSOR).to_dict()
    del tables["material"]
    with pytest.raises(taxel.SensorError, match="material"):
        taxel.map(archive, tmp_path, sensor=taxel.Sensor(tables))
    with pytest.raises(taxel.Error, match="no intervals with the method raw"):
        taxel.map(archive, tmp_path, sensor=SENSOR, method="raw", intervals=True)
    np.save(tmp_path / "counts.npy", np.load(archive[0]))
    (tmp_path / "summary.csv").symlink_to(tmp_path / "counts.npy")
    with pytest.raises(taxel.Error, match="would be replaced: a table"):
        taxel.map(tmp_path / "counts.npy", tmp_path, sensor=SENSOR)
    (tmp_path / "summary.csv").unlink()
    with pytest.raises(taxel.Error, match="0 workers"):
        taxel.map(archive, tmp_path, sensor=SENSOR, workers=0)
    nothing = taxel.map([], tmp_path / "nothing", sensor=SENSOR)
    assert nothing.rows == 0 and list(nothing) == list(taxel.map(archive[0], tmp_path / "one", sensor=SENSOR))


def test_settings_can_be_pickled(tmp_path: Path) -> None:
    settings = Settings(str(tmp_path), taxel.Sensor(SENSOR), pictures=True)
    assert pickle.loads(pickle.dumps(settings)) == settings


def test_a_worker_is_checked_once_when_it_is_made(archive: list[str], tmp_path: Path) -> None:
    from taxel.ray import Settings, Worker

    tables = taxel.Sensor(SENSOR).to_dict()
    del tables["material"]
    with pytest.raises(taxel.SensorError, match="material"):
        Worker(Settings(str(tmp_path / "none"), taxel.Sensor(tables)))
    model = tmp_path / "model.taxel"
    with pytest.raises(taxel.Error, match=r"model\.taxel"):
        Worker(Settings(str(tmp_path / "none"), taxel.Sensor(SENSOR), method=str(model)))
    assert not (tmp_path / "none").exists()
    worker = Worker(Settings(str(tmp_path / "out"), taxel.Sensor(SENSOR)))
    rows = [worker({"place": np.array([place]), "recording": np.array([path])}) for place, path in enumerate(archive)]
    whole = taxel.map(archive, tmp_path / "out", sensor=SENSOR)
    assert [row["status"][0] for row in rows] == whole["status"].tolist()
    # As in a pipeline of one's own, which knows recordings alone.
    again = worker({"recording": np.array(archive)})
    assert again["place"].tolist() == [*range(6)] and again["frames"].tolist() == whole["frames"].tolist()


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """Ray on two nodes of a processor each, both on this machine."""
    import ray
    from ray.cluster_utils import Cluster

    nodes = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    nodes.add_node(num_cpus=1)
    ray.init(address=nodes.address, log_to_driver=False)
    yield ray
    ray.shutdown()
    nodes.shutdown()


@pytest.mark.filterwarnings("ignore")
def test_a_cluster_gives_the_same_row_for_row(cluster: Any, archive: list[str], tmp_path: Path) -> None:
    import pandas

    import taxel.ray

    assert sum(node["Alive"] for node in cluster.nodes()) == 2
    here = taxel.map(archive, tmp_path / "here", sensor=SENSOR, pictures=True)
    there = taxel.ray.process(archive, tmp_path / "there", sensor=SENSOR, pictures=True)
    assert here == there
    assert contents(tmp_path / "here") == contents(tmp_path / "there")
    table = pandas.read_parquet(tmp_path / "there" / "summary.parquet")
    assert table["recording"].tolist() == archive and "no array" in table["error"].iloc[-1]
    with pytest.raises(taxel.Error, match="under one name"):
        taxel.ray.process([archive[0], archive[0]], tmp_path, sensor=SENSOR)
    with pytest.raises(taxel.Error, match="on every machine"):
        taxel.ray.process(["a.npy"], tmp_path, sensor=SENSOR)
    with pytest.raises(taxel.Error, match=r"model.taxel is a different file on every machine"):
        taxel.ray.process(archive, tmp_path, sensor=SENSOR, method="model.taxel")
    for options, words in (({"workers": 0}, "0 workers"), ({"workers": -1}, "-1 workers"), ({"threads": 0}, "0 threads")):
        with pytest.raises(taxel.Error, match=words):
            taxel.ray.process(archive, tmp_path, sensor=SENSOR, **options)


def workers() -> list[int]:
    """The processes of Ray's that do the work."""
    found: list[int] = []
    for folder in Path("/proc").iterdir():
        try:
            if b"ray::MapWorker" in (folder / "cmdline").read_bytes():
                found.append(int(folder.name))
        except (OSError, ValueError):
            continue
    return found


@pytest.mark.skipif(not Path("/proc/self/cmdline").exists(), reason="processes are looked for as Linux lists them")
@pytest.mark.filterwarnings("ignore")
def test_a_worker_that_is_killed_loses_and_doubles_nothing(cluster: Any, tmp_path: Path) -> None:
    import taxel.ray

    counts = taxel.simulate(SENSOR, pattern="hand", frames=400, seed=9).counts
    paths = [str(tmp_path / f"{place}.npy") for place in range(12)]
    for path in paths:
        np.save(path, counts)
    killed: list[int] = []

    def kill() -> None:
        # In the middle: some are done, and not all.
        while len(list(tmp_path.rglob("*.entry.json"))) < 3:
            time.sleep(0.005)
        killed.extend(workers()[:1])
        os.kill(killed[0], signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    there = taxel.ray.process(paths, tmp_path / "there", sensor=SENSOR)
    killer.join()
    assert killed
    here = taxel.map(paths, tmp_path / "here", sensor=SENSOR)
    assert here == there
    assert contents(tmp_path / "here") == contents(tmp_path / "there")
