"""What Python adds to a solve, and the share of Rust's throughput that `solve_many` reaches.

    python crates/cppr-py/bench/overhead.py

Rust's side is a loop inside the extension module, in the same process, run turn about with Python's: ratios and
differences hold on a busy machine as well, the smallest of many turns is what is shown.
"""

from __future__ import annotations

import argparse
import os
import time

import numpy as np

import cppr
from cppr import _cppr


def seconds(call: object) -> float:
    start = time.perf_counter()
    call()  # type: ignore[operator]
    return time.perf_counter() - start


def single(robot: cppr.Robot, settings: cppr.Settings | None, turns: int) -> tuple[float, float]:
    """Smallest mean cost of a solve and its tip (s) from Rust and from Python, turn about."""
    pulls = np.linspace(-1e-3, 1e-3, 20).tolist()

    def python() -> None:
        for pull in pulls:
            robot.solve(pull=pull, settings=settings).tip_position  # noqa: B018

    pairs = [(_cppr.time_solves(robot, pulls, settings), seconds(python)) for _ in range(turns)]
    rust, ours = (min(side) / len(pulls) for side in zip(*pairs))
    return rust, ours


def many(robot: cppr.Robot, settings: cppr.Settings | None, turns: int) -> float:
    """Median share of Rust's throughput."""
    pulls = np.linspace(-8e-3, 8e-3, 4000)
    threads = len(os.sched_getaffinity(0))
    ratios = []
    for _ in range(turns):
        rust = _cppr.time_many(robot, pulls.tolist(), settings, threads)
        ratios.append(rust / seconds(lambda: robot.solve_many(pull=pulls, settings=settings, threads=threads)))
    return float(np.median(ratios))


def side_by_side(robot: cppr.Robot, settings: cppr.Settings | None, turns: int) -> float:
    """Median of how many times the throughput of single solves in Rust `solve_many` has, both on one thread."""
    pulls = np.linspace(0, 8e-3, 4000)
    ratios = []
    for _ in range(turns):
        rust = _cppr.time_solves(robot, pulls.tolist(), settings)
        ratios.append(rust / seconds(lambda: robot.solve_many(pull=pulls, settings=settings, threads=1)))
    return float(np.median(ratios))


def few(robot: cppr.Robot, settings: cppr.Settings | None, turns: int) -> tuple[float, float]:
    """Smallest cost of four poses (s), one by one in Rust and in one call of `solve_many`, turn about."""
    pulls = np.linspace(0, 8e-3, 4)

    def python() -> None:
        robot.solve_many(pull=pulls, settings=settings)

    pairs = [(_cppr.time_solves(robot, pulls.tolist(), settings), seconds(python)) for _ in range(turns)]
    rust, ours = (min(side) for side in zip(*pairs))
    return rust, ours


def of_bundle(bundle: cppr.Bundle, turns: int) -> tuple[float, float, float]:
    """Smallest cost per pose (s) on one thread: one by one, in one call from rest, and in one call each from the pose before it, turn about."""
    pulls = np.linspace(0.5e-3, 2e-3, 100)

    def one_by_one() -> None:
        for pull in pulls:
            bundle.solve(pull=pull)

    def in_one_call(warm: bool) -> None:
        assert bundle.solve_many(pull=pulls, warm=warm, threads=1).stable.all()

    calls = (one_by_one, lambda: in_one_call(False), lambda: in_one_call(True))
    one, rest, near = (min(side) / len(pulls) for side in zip(*([seconds(c) for c in calls] for _ in range(turns))))
    return one, rest, near


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--turns", type=int, default=100)
    turns = parser.parse_args().turns
    robot = cppr.Robot.from_toml("robots/r3.toml")
    for name, settings in (("space", None), ("plane", cppr.Settings(planar=True))):
        rust, python = single(robot, settings, turns)
        print(
            f"solve in {name}: Rust {rust * 1e6:.1f} us, Python {python * 1e6:.1f} us, "
            f"overhead {(python - rust) * 1e6:.1f} us"
        )
        print(f"solve_many in {name}: {many(robot, settings, max(3, turns // 10)):.1%} of Rust's throughput")
        rust, python = few(robot, settings, turns)
        print(
            f"four poses in {name}: Rust one by one {rust * 1e6:.0f} us, "
            f"solve_many {python * 1e6:.0f} us"
        )
        ratio = side_by_side(robot, settings, max(3, turns // 10))
        print(f"solve_many in {name}: {ratio:.1f} times the throughput of single solves in Rust, on one thread")
    for name in ("concentric3", "two_sections", "s_shape", "uncut_ends"):
        bundle = cppr.Bundle.from_toml(f"robots/bundles/{name}.toml")
        one, rest, near = of_bundle(bundle, max(3, turns // 10))
        print(
            f"poses of {name}: one by one {one * 1e6:.0f} us, solve_many from rest {rest * 1e6:.0f} us, "
            f"from the pose before {near * 1e6:.0f} us"
        )


if __name__ == "__main__":
    main()
