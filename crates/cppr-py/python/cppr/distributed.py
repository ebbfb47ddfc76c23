"""`Robot.solve_many` on many machines: dask.distributed, Parquet parts, nothing lost.

Poses are cut into chunks; each is one call that leaves the interpreter, on one core of a worker, and one Parquet part,
moved to its place when whole. A lost worker costs its chunks in work, which others repeat; after a lost client the same call goes
on where it stopped. Needs a folder that client and workers share, and ``pip install 'cppr[distributed]'``.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import pickle
from collections.abc import Iterable
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from distributed import Client, as_completed
from distributed.client import FutureCancelledError
from distributed.scheduler import KilledWorker
from numpy.typing import ArrayLike

from . import _cppr
from ._design import Settings
from ._loads import Load
from ._many import Floats, PerTube, Poses, Progress, resolved, solve_slice, unpack, watcher

_INPUTS = ("pull_m", "rotation_rad", "tension_N", "torque_Nm")
_MANIFEST = "manifest.json"
_Columns = list[tuple[int, int, Floats]]


def solve_many(
    client: Client,
    robot: _cppr.Robot,
    folder: str | os.PathLike[str],
    pull: PerTube = None,
    rotate: PerTube = None,
    tension: PerTube = None,
    torque: PerTube = None,
    *,
    tip_force: ArrayLike | None = None,
    tip_moment: ArrayLike | None = None,
    loads: Iterable[Load] | None = None,
    settings: Settings | None = None,
    accuracy: float | None = 1e-4,
    margin: bool = False,
    chunk: int = 20_000,
    retries: int = 10,
    progress: Progress = False,
) -> Path:
    """Solves many poses on the workers of `client` into Parquet parts of `chunk` poses; see `read`.

    Arguments are those of `Robot.solve_many`. Parts that are in `folder` already are kept, so that an interrupted call is
    repeated as it was; a folder with other poses is refused. `retries` is how often a chunk may lose its worker.

    Returns the folder. Raises what `Robot.solve_many` raises; parts that are done stay.
    """
    if chunk < 1:
        raise ValueError(f"chunk is {chunk}; at least one pose is needed")
    loads = None if loads is None else list(loads)
    drives = {"pull": pull, "rotate": rotate, "tension": tension, "torque": torque}
    poses = Poses(drives, tip_force, tip_moment)
    settings, _ = resolved(robot, poses, loads, settings, accuracy)
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    _claim(folder, robot, poses, loads, settings, margin, chunk)

    starts = [at for at in range(0, poses.count, chunk) if not _part(folder, at // chunk).exists()]
    callback, close = watcher(progress)
    done = poses.count - sum(min(chunk, poses.count - at) for at in starts)
    lost: dict[int, int] = {}
    options = {"loads": loads, "settings": settings, "margin": margin}
    # Every task carries all it needs: data that were scattered would die with their worker.
    packed = pickle.dumps(robot)
    running = as_completed()
    begun: dict[object, int] = {}

    def submit(at: int) -> None:
        stop = min(at + chunk, poses.count)
        path = str(_part(folder, at // chunk).absolute())
        future = client.submit(_solve, packed, at, *poses.slice(at, stop), options, path, pure=False)
        begun[future.key] = at
        running.add(future)

    waiting = iter(starts)
    try:
        if callback is not None:
            callback(done, poses.count)
        for at in islice(waiting, 2 * _cores(client) + 2):
            submit(at)
        for future in running:
            at = begun.pop(future.key)
            try:
                done += future.result()
            except (KilledWorker, FutureCancelledError):
                lost[at] = lost.get(at, 0) + 1
                if lost[at] > retries:
                    raise
                submit(at)
                continue
            if callback is not None:
                callback(done, poses.count)
            for at in islice(waiting, 1):
                submit(at)
    finally:
        running.clear()
        close()
    for left in folder.glob("*.tmp"):
        # What lost workers left behind.
        left.unlink(missing_ok=True)
    return folder


def read(folder: str | os.PathLike[str], columns: list[str] | None = None) -> pa.Table:
    """The finished table, one row per pose in C order of the broadcast inputs.

    Columns carry their units: pose, input_tube2_pull_m, ..., status (0 converged, 1 unstable, 2 and 3 none found),
    tip_x_m, ..., tip_qw, ..., tube2_pull_m, tube2_tension_N, ..., elastic_energy_J, newton_steps. NaN where there is no
    equilibrium. `to_pandas()` makes a DataFrame. Raises `FileNotFoundError` while parts are missing.
    """
    folder = Path(folder)
    manifest = json.loads((folder / _MANIFEST).read_text(encoding="utf-8"))
    parts = [_part(folder, i) for i in range(-(-manifest["poses"] // manifest["chunk"]))]
    missing = [part.name for part in parts if not part.exists()]
    if missing:
        raise FileNotFoundError(
            f"{len(missing)} of {len(parts)} parts are missing in {folder}, first {missing[0]}; "
            "call solve_many again as it was called to go on"
        )
    return pa.concat_tables([pq.read_table(part, columns=columns) for part in parts])


def _cores(client: Client) -> int:
    return sum(client.nthreads().values()) or 1


def _part(folder: Path, number: int) -> Path:
    return folder / f"part-{number:06}.parquet"


def _claim(
    folder: Path,
    robot: _cppr.Robot,
    poses: Poses,
    loads: list[Load] | None,
    settings: Settings | None,
    margin: bool,
    chunk: int,
) -> None:
    """Writes what the folder holds, or compares."""
    said = [dataclasses.asdict(part) for part in (*robot.tubes, *(loads or ()), settings or Settings())]
    text = json.dumps([robot.name, robot.length, said, margin, poses.shape], default=lambda a: np.asarray(a).tolist())
    total = hashlib.sha256(text.encode())
    for at in range(0, poses.count, 1 << 20):
        columns, vectors = poses.slice(at, min(at + (1 << 20), poses.count))
        for means, tube, values in columns:
            total.update(f"{means} {tube}".encode() + values.tobytes())
        for v in vectors:
            total.update(b"-" if v is None else v.tobytes())
    manifest = {
        "schema": "cppr/poses",
        "cppr_version": _cppr.__version__,
        "poses": poses.count,
        "shape": poses.shape,
        "chunk": chunk,
        "sha256": total.hexdigest(),
    }
    path = folder / _MANIFEST
    own = json.loads(json.dumps(manifest))
    if path.exists():
        there = json.loads(path.read_text(encoding="utf-8"))
        different = [key for key, value in own.items() if there.get(key) != value]
        if different:
            raise ValueError(f"{folder} holds other poses (they differ in {', '.join(different)}): take another folder")
        return
    if any(folder.glob("part-*.parquet")):
        raise ValueError(f"{folder} holds parts without {_MANIFEST}: take another folder")
    _write(path, lambda name: Path(name).write_text(json.dumps(manifest, indent=1), encoding="utf-8"))


def _write(path: Path, write: Any) -> None:
    """Whole or not at all; the name of the unfinished file belongs to one process and task."""
    unfinished = f"{path}.{os.uname().nodename}.{os.getpid()}.{os.urandom(4).hex()}.tmp"
    write(unfinished)
    os.replace(unfinished, path)


# A worker builds its robot once.
_robots: dict[bytes, _cppr.Robot] = {}


def _solve(
    packed: bytes,
    start: int,
    columns: _Columns,
    vectors: list[Floats | None],
    options: dict[str, Any],
    path: str,
) -> int:
    """One chunk, on a worker: solves it and writes its part."""
    if packed not in _robots:
        _robots.clear()
        _robots[packed] = pickle.loads(packed)
    robot = _robots[packed]
    count = len(columns[0][2]) if columns else next(len(v) for v in vectors if v is not None)
    poses = Poses.of(columns, vectors, count)
    margin = options["margin"]
    rows = solve_slice(
        robot, poses, 0, count, loads=options["loads"], settings=options["settings"], jacobian=False,
        margin=margin, sections=0, warm=True, threads=1, progress=False, first=start,
    )  # fmt: skip
    found = unpack(rows, (count,), len(robot.followers), False, margin, 0)
    table: dict[str, Any] = {"pose": np.arange(start, start + count)}
    for means, tube, values in columns:
        table[f"input_tube{tube}_{_INPUTS[means]}"] = values
    for name, unit, v in zip(("force", "moment"), ("N", "Nm"), vectors):
        if v is not None:
            table |= {f"input_tip_{name}_{axis}_{unit}": v[:, i] for i, axis in enumerate("xyz")}
    table["status"] = found.code
    table |= {f"tip_{axis}_m": found.tip_position[:, i] for i, axis in enumerate("xyz")}
    turn = quaternions(found.tip_rotation)
    table |= {f"tip_q{axis}": turn[:, i] for i, axis in enumerate("wxyz")}
    for f, tube in enumerate(robot.followers):
        for name, field in zip(_INPUTS, (found.pull, found.rotation, found.tension, found.torque)):
            table[f"tube{tube}_{name}"] = field[:, f]
    table["elastic_energy_J"] = found.elastic_energy
    if found.margin is not None:
        table["margin_to_instability"] = found.margin
    table["newton_steps"] = np.nan_to_num(found.iterations).astype(np.int32)
    _write(Path(path), lambda name: pq.write_table(pa.table(table), name))
    return count


def quaternions(rotation: Floats) -> Floats:
    """w, x, y, z of rotations, shape (n, 3, 3), with w >= 0; shape (n, 4)."""
    r = rotation.transpose(1, 2, 0)
    diagonal = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) @ np.stack([r[i, i] for i in range(3)])
    # Four times a product of two components each: rows of q qᵀ. The one with the largest square loses no digits.
    products = np.empty((4, 4, len(rotation)))
    products[range(4), range(4)] = 1 + diagonal
    for i, j, value in (
        (0, 1, r[2, 1] - r[1, 2]), (0, 2, r[0, 2] - r[2, 0]), (0, 3, r[1, 0] - r[0, 1]),
        (1, 2, r[1, 0] + r[0, 1]), (1, 3, r[0, 2] + r[2, 0]), (2, 3, r[2, 1] + r[1, 2]),
    ):  # fmt: skip
        products[i, j] = products[j, i] = value
    best = np.argmax(diagonal, axis=0)
    q = products[best, :, np.arange(len(rotation))]
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    return np.asarray(np.where(q[:, :1] < 0, -q, q))
