"""An archive on more than one machine, by Ray: ``pip install "taxel[ray]"``.

>>> import ray, taxel.ray                                                       # doctest: +SKIP
>>> ray.init("auto")                                                            # doctest: +SKIP
>>> table = taxel.ray.process(paths, "/shared/out", sensor="mat.toml")          # doctest: +SKIP

Recordings and ``out`` lie where all machines see them under one name. Each recording is worked through by one worker, which checks
sensor and settings once; what is done is known from the folder, so that a worker that dies loses at most the recording that it had, and
nothing is there twice.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._batch import Path, Settings, paths_of, row_of, table_of
from ._errors import Error
from ._pipeline import sensor_of
from ._table import Table

__all__ = ["Settings", "Worker", "process"]


class Worker:
    """What one worker does: a class for ``ray.data.Dataset.map_batches`` over a column ``recording`` of paths.

    It makes of each batch the rows of ``taxel.map``'s table, and beside them ``place``, what stood there or the place in the batch, and
    ``entry``, all that is known of the recording, as JSON.

    Parameters
    ----------
    settings : Settings
        What is made of each recording.
    threads : int
        Threads of the worker.
    """

    def __init__(self, settings: Settings, threads: int = 1) -> None:
        self._folder = settings.folder()
        self._threads = threads

    def __call__(self, batch: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        entries = self._folder.run([str(path) for path in batch["recording"]], self._threads)
        places = batch.get("place", np.arange(len(entries)))
        told = [(place, entry) for place, (entry, _) in zip(places, entries, strict=True)]
        rows = [{"place": place, "entry": entry, **row_of(entry)} for place, entry in told]
        return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def process(
    recordings: Iterable[Path] | Path,
    out: Path,
    *,
    sensor: Any = None,
    workers: int | None = None,
    threads: int = 1,
    **options: Any,
) -> Table:
    """Works an archive through on all machines of the Ray cluster that this program is connected to.

    Parameters
    ----------
    recordings : paths
        Recordings of counts, under names that every machine knows.
    out : path
        A folder that every machine sees. Beside what ``taxel.map`` writes there is ``summary.parquet``, the table.
    sensor : Sensor, str, path or dict, optional
        The sensor of all; without it each recording brings its own.
    workers : int, optional
        How many workers; without it as many as the cluster has processors for.
    threads : int
        Processors of each worker.
    **options
        ``method``, ``loads``, ``intervals``, ``pictures``, ``repair``, ``tare``, ``transpose``, ``with_names``, as of ``taxel.map``.

    Returns
    -------
    Table
        A row a recording, in their order, as of ``taxel.map``.

    Raises
    ------
    taxel.Error, taxel.SensorError
        As of ``taxel.map``; a path that is not absolute, of a model too; fewer workers or threads than 1.
    """
    # None of them tells all of its types.
    ray: Any = import_module("ray")
    data: Any = import_module("ray.data")
    arrow: Any = import_module("pyarrow")
    parquet: Any = import_module("pyarrow.parquet")
    for what, many in (("workers", workers), ("threads", threads)):
        if many is not None and many < 1:
            raise Error(f"{many} {what}, but 1 or more are needed")
    settings = Settings(os.path.abspath(out), None if sensor is None else sensor_of(sensor), **options)
    paths = paths_of(recordings)
    # What is no word is the file of a model.
    models = [] if settings.method.isalpha() else [settings.method]
    for path in [*paths, *models]:
        if not os.path.isabs(path):
            raise Error(f"{path} is a different file on every machine\nhint: os.path.abspath gives the name that all of them know")
    folder = settings.folder()
    # Refused here, not by every worker.
    folder.check_names(paths)
    found: list[dict[str, Any]] = []
    if paths:
        items = [{"place": place, "recording": path} for place, path in enumerate(paths)]
        processors = int(ray.cluster_resources().get("CPU", 1))
        count = max(1, min(len(items), workers or processors // threads))
        dataset = data.from_items(items, override_num_blocks=min(len(items), 8 * count))
        done = dataset.map_batches(
            Worker,
            fn_constructor_args=(settings, threads),
            batch_size=1,
            num_cpus=threads,
            compute=data.ActorPoolStrategy(size=count),
        )
        found = sorted(done.take_all(), key=lambda row: row["place"])
    table = table_of([row_of(str(row["entry"])) for row in found])
    folder.write_tables([str(row["entry"]) for row in found])
    summary = os.path.join(settings.out, "summary.parquet")
    parquet.write_table(arrow.table({name: list(table[name]) for name in table}), f"{summary}.new")
    os.replace(f"{summary}.new", summary)
    return table
