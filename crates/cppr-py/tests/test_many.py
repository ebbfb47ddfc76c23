"""Many poses in one call."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import cppr


def test_broadcasting_agrees_with_single_solves(three: cppr.Robot) -> None:
    pull2 = np.linspace(-4e-4, 4e-4, 3)[:, None]
    pull3 = np.linspace(0, 3e-4, 2)
    many = three.solve_many(
        pull={2: pull2, 3: pull3}, tip_force=(0, 0.01, 0.02), jacobian=True, margin=True, sections=5
    )
    assert many.code.shape == (3, 2) and many.stable.all() and (many.status == "converged").all()
    assert many.jacobian is not None and many.compliance is not None
    assert many.margin is not None and many.centreline is not None
    for i in range(3):
        for j in range(2):
            eq = three.solve(pull={2: pull2[i, 0], 3: pull3[j]}, tip_force=(0, 0.01, 0.02))
            pairs = (
                (many.tip_position, eq.tip_position),
                (many.tip_rotation, eq.tip_rotation),
                (many.tension, eq.tension),
                (many.torque, eq.torque),
                (many.pull, eq.pull),
                (many.rotation, eq.rotation),
                (many.jacobian, eq.jacobian),
                (many.compliance, eq.compliance),
                (many.margin, eq.margin),
                (many.elastic_energy, eq.elastic_energy),
                (many.centreline, eq.sample(5).centre),
            )
            for field, wanted in pairs:
                np.testing.assert_allclose(field[i, j], wanted, rtol=1e-9, atol=1e-9 * np.abs(wanted).max())


def test_results_do_not_depend_on_threads(r3: cppr.Robot) -> None:
    pull = np.linspace(-8e-3, 8e-3, 100)
    one, four = (r3.solve_many(pull=pull, threads=n) for n in (1, 4))
    assert (one.tip_position == four.tip_position).all() and (one.tension == four.tension).all()


def test_efforts_forces_and_moments_vary_too(r3: cppr.Robot) -> None:
    force = np.array([[0, 0.05, 0], [0, 0, 0.05]])
    many = r3.solve_many(tension=[1.0, 2.0], torque=0.01, tip_force=force, tip_moment=(0, 0, 1e-3))
    eq = r3.solve(tension=2.0, torque=0.01, tip_force=force[1], tip_moment=(0, 0, 1e-3))
    np.testing.assert_allclose(many.tip_position[1], eq.tip_position, rtol=0, atol=1e-11)


def test_near_poses_begin_at_each_other_with_the_same_answers(r3: cppr.Robot) -> None:
    grid = {"pull": np.linspace(0, 6e-3, 40)[:, None], "rotate": np.linspace(-2.0, 2.0, 40)}
    near, rest = r3.solve_many(**grid), r3.solve_many(**grid, warm=False)
    assert near.stable.all() and rest.stable.all()
    np.testing.assert_allclose(near.tip_position, rest.tip_position, rtol=0, atol=1e-11)
    np.testing.assert_allclose(near.torque, rest.torque, rtol=0, atol=1e-9)
    assert near.iterations.sum() < 0.85 * rest.iterations.sum()


def test_poses_without_equilibrium_are_nan() -> None:
    robot = cppr.Robot.from_toml("robots/r3.toml")
    many = robot.solve_many(
        pull=[0.0, 0.02], settings=cppr.Settings(planar=True, formulation="printed")
    )
    assert many.code.tolist() == [0, 2] and many.status[1] == "not converged"
    assert np.isnan(many.tip_position[1]).all() and np.isfinite(many.tip_position[0]).all()


def test_scalars_and_nothing(r3: cppr.Robot) -> None:
    assert r3.solve_many(pull=1e-3).tip_position.shape == (3,)
    empty = r3.solve_many(pull=np.zeros((0, 4)))
    assert empty.tip_position.shape == (0, 4, 3) and repr(empty) == "Solutions((0, 4): none)"


def test_progress_is_told(r3: cppr.Robot) -> None:
    seen: list[tuple[int, int]] = []
    r3.solve_many(pull=np.linspace(0, 1e-3, 50), progress=lambda done, total: seen.append((done, total)))
    assert seen[-1] == (50, 50)
    r3.solve_many(pull=np.zeros(3), progress=True)
    with pytest.raises(ZeroDivisionError):
        r3.solve_many(pull=np.zeros(3), progress=lambda done, total: 1 // 0)


def test_ctrl_c_stops_it(r3: cppr.Robot) -> None:
    pull = np.linspace(-8e-3, 8e-3, 3_000_000)
    threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        r3.solve_many(pull=pull)
    assert time.monotonic() - start < 30
    assert r3.solve(pull=1e-3).stable


def test_a_forked_child_can_solve() -> None:
    code = (
        "import os, cppr, numpy as np\n"
        "r = cppr.Robot.from_toml('robots/r3.toml'); p = np.linspace(0, 1e-3, 40)\n"
        "a = r.solve_many(pull=p).tip_position\n"
        "pid = os.fork()\n"
        "if pid == 0:\n"
        "    os._exit(0 if (r.solve_many(pull=p).tip_position == a).all() else 1)\n"
        "assert os.waitpid(pid, 0)[1] == 0\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_other_python_threads_run_meanwhile(r3: cppr.Robot) -> None:
    counts = [0]
    stop = threading.Event()

    def count() -> None:
        while not stop.is_set():
            counts[0] += 1

    thread = threading.Thread(target=count)
    thread.start()
    try:
        r3.solve_many(pull=np.linspace(0, 5e-3, 500), threads=1)
    finally:
        stop.set()
        thread.join()
    assert counts[0] > 1000


def test_as_many_modes_as_the_poses_need(r3: cppr.Robot) -> None:
    smooth = r3.solve_many(pull=[1e-3, 4e-3])
    assert 0 < smooth.error < 1e-6 * r3.length
    with pytest.warns(cppr.AccuracyWarning, match="sudden changes"):
        robot = cppr.Robot.from_toml("crates/cppr-cli/tests/data/steps_in_a_table.toml")
    with pytest.warns(cppr.AccuracyWarning, match="cppr.Bundle.of"):
        many = robot.solve_many(pull=[1e-3, 2e-3])
    assert many.error > 1e-4 * robot.length
    bare = robot.solve_many(pull=[1e-3, 2e-3], accuracy=None)
    assert np.isnan(bare.error)
    chosen = robot.solve_many(pull=[1e-3, 2e-3], settings=cppr.Settings(refine=4))
    np.testing.assert_allclose(many.tip_position, chosen.tip_position, atol=1e-9)
    # Within its error of the robot that knows no modes.
    whole = cppr.Bundle.of(robot).solve(pull=2e-3)
    away = np.linalg.norm(many.tip_position[1] - whole.tip_position)
    assert away < 1.5 * many.error and np.linalg.norm(whole.tip_position[:2] - [88.599e-3, -50.173e-3]) < 1e-5
    with pytest.raises(ValueError, match="accuracy is 2"):
        r3.solve_many(pull=[1e-3], accuracy=2)


def test_the_path_from_rest_is_followed_past_its_folds() -> None:
    robot = cppr.Robot.from_toml("crates/cppr-cli/tests/data/folds_on_the_way.toml")
    with pytest.warns(cppr.SnapWarning, match=r"snaps at 12\.8 %"):
        eq = robot.solve(
            pull={2: 0.02310248e-3, 3: -0.08407234e-3}, rotate={3: 14.037675 * cppr.deg}, accuracy=None,
            settings=cppr.Settings(refine=4),
        )
    assert eq.stable
