"""The same poses on a cluster: nothing is lost, whoever dies."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from distributed import Client, LocalCluster

import cppr
import cppr.distributed

PULL = np.linspace(-8e-3, 8e-3, 60)[:, None]
FORCE = np.stack([np.zeros(100), np.linspace(-0.05, 0.05, 100), np.full(100, 0.02)], axis=-1)


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with Client(cluster) as client:
            yield client


def agree(folder: Path, robot: cppr.Robot, pull: np.ndarray, chunk: int) -> None:
    """To the bit with calls for each chunk, to 1e-11 m with one for all, in which poses have other neighbours."""
    table = cppr.distributed.read(folder).to_pandas()
    whole = robot.solve_many(pull=pull, tip_force=FORCE)
    assert (table.pose == np.arange(whole.code.size)).all()
    assert (table.status == whole.code.ravel()).all()
    pulls = np.broadcast_to(pull, whole.code.shape).ravel()
    forces = np.broadcast_to(FORCE, (*whole.code.shape, 3)).reshape(-1, 3)
    assert (table.input_tube2_pull_m == pulls).all()
    tip = table[["tip_x_m", "tip_y_m", "tip_z_m"]].to_numpy()
    assert np.abs(tip - whole.tip_position.reshape(-1, 3)).max() < 1e-11
    for start in range(0, pulls.size, chunk):
        rows = slice(start, start + chunk)
        own = robot.solve_many(pull=pulls[rows], tip_force=forces[rows])
        assert (tip[rows] == own.tip_position).all()
        assert (table.tube2_tension_N[rows] == own.tension[:, 0]).all()


def test_a_worker_killed_in_mid_run_loses_nothing(
    client: Client, r3: cppr.Robot, tmp_path: Path
) -> None:
    killed = []

    def kill() -> None:
        while not any(tmp_path.glob("part-*.parquet")):
            time.sleep(0.01)
        pid = next(iter(client.run(os.getpid).values()))
        os.kill(pid, signal.SIGKILL)
        killed.append((pid, len(list(tmp_path.glob("part-*.parquet")))))

    thread = threading.Thread(target=kill)
    thread.start()
    seen = []
    cppr.distributed.solve_many(
        client, r3, tmp_path, pull=PULL, tip_force=FORCE, chunk=250,
        progress=lambda done, total: seen.append((done, total)),
    )  # fmt: skip
    thread.join()
    assert killed and killed[0][1] < 24, "the worker was to die in mid-run"
    assert seen[-1] == (6_000, 6_000)
    agree(tmp_path, r3, PULL, 250)
    assert not list(tmp_path.glob("*.tmp"))


def test_an_interrupted_call_goes_on(client: Client, r3: cppr.Robot, tmp_path: Path) -> None:
    arguments = {"pull": PULL[:10], "tip_force": FORCE, "chunk": 150}
    cppr.distributed.solve_many(client, r3, tmp_path, **arguments)
    parts = sorted(tmp_path.glob("part-*.parquet"))
    assert len(parts) == 7
    before = {part: part.stat().st_mtime_ns for part in parts}
    for part in parts[2:4]:
        part.unlink()
    # As a client leaves it that dies.
    (tmp_path / "part-000002.parquet.host.1.tmp").write_bytes(b"half")
    with pytest.raises(FileNotFoundError, match="2 of 7 parts are missing"):
        cppr.distributed.read(tmp_path)
    cppr.distributed.solve_many(client, r3, tmp_path, **arguments)
    again = {part for part in parts if part.stat().st_mtime_ns != before[part]}
    assert again == set(parts[2:4])
    agree(tmp_path, r3, PULL[:10], 150)
    assert cppr.distributed.read(tmp_path, ["tip_y_m"]).column_names == ["tip_y_m"]


def test_another_sweep_is_refused(client: Client, r3: cppr.Robot, tmp_path: Path) -> None:
    cppr.distributed.solve_many(client, r3, tmp_path, pull=[1e-3, 2e-3])
    with pytest.raises(ValueError, match="holds other poses .*sha256.*: take another folder"):
        cppr.distributed.solve_many(client, r3, tmp_path, pull=[1e-3, 2.1e-3])
    with pytest.raises(ValueError, match="settings|sha256"):
        cppr.distributed.solve_many(
            client, r3, tmp_path, pull=[1e-3, 2e-3], settings=cppr.Settings(refine=2)
        )


def test_problems_reach_the_caller(client: Client, r3: cppr.Robot, tmp_path: Path) -> None:
    pull = np.zeros(10)
    pull[7] = 5.0
    with pytest.raises(cppr.CommandError, match="pose 7: .*Check the unit"):
        cppr.distributed.solve_many(client, r3, tmp_path, pull=pull, chunk=3)


def test_quaternions() -> None:
    random = np.random.default_rng(1)
    q = random.normal(size=(200, 4))
    q[:20, 0] = 0.0
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    q *= np.where(q[:, :1] < 0, -1, 1)
    w, x, y, z = q.T
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    ).transpose(2, 0, 1)
    found = cppr.distributed.quaternions(rotation)
    # Both signs stand for half a turn.
    assert np.allclose(np.abs(np.einsum("ni,ni->n", found, q)), 1, atol=1e-14)
    assert (found[:, 0] >= 0).all() and np.allclose(found[20:], q[20:])
