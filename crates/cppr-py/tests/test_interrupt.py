"""Ctrl-C ends long computations soon, and leaves everything usable."""

from __future__ import annotations

import os
import signal
import threading
import time
from typing import Callable

import numpy as np
import pandas as pd
import pytest

import cppr

FINE = cppr.Settings(refine=6)


def path() -> None:
    cppr.Robot.from_toml("robots/r3.toml").solve().continue_path(pull=8e-3, step=1e-6, points=10**8)


def branches() -> None:
    eq = cppr.Robot.from_toml("robots/r3.toml").solve(pull=-5e-3, tip_force=(-1.0, 0, 0))
    eq.continue_path(load_factor=2.5, step=1e-5, points=10**8, depth=1)


def path_of_parts() -> None:
    cppr.Bundle.from_toml("robots/bundles/two_sections.toml").solve().continue_path(pull=2e-3, step=1e-6, points=10**8)


def history() -> None:
    waypoints = [{"pull": 0.0}, {"pull": 2e-3}]
    cppr.Bundle.from_toml("robots/bundles/two_sections.toml").cycle(waypoints, 0.1, steps=10**6)


def ranges() -> None:
    cppr.Robot.from_toml("robots/childs3.toml").solve(settings=FINE).safe_ranges()


def reach() -> None:
    cppr.Robot.from_toml("robots/childs3.toml").solve(settings=FINE).reach(position=(0.02, 0.01, 0.0))


def match() -> None:
    points = np.array([(0.01, 0, 0), (0.02, 2e-3, 0), (0.029, 5e-3, 1e-3)])
    cppr.Robot.from_toml("robots/childs3.toml").solve(settings=FINE).match_shape(points)


def calibrate() -> None:
    i = np.arange(100_000)
    pull = i % 6000 * 1e-3
    table = pd.DataFrame({"pull2_mm": pull, "x_mm": 150 - pull, "y_mm": -10 * pull, "z_mm": 0 * pull})
    cppr.calibrate(cppr.Robot.from_toml("robots/r1.toml"), table, ["centroid_offset_factor"])


@pytest.mark.parametrize("work", [path, branches, path_of_parts, history, ranges, reach, match, calibrate])
def test_ctrl_c_ends_it(work: Callable[[], None], r3: cppr.Robot) -> None:
    sent: list[float] = []

    def send() -> None:
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.5, send)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            work()
    finally:
        timer.cancel()
    assert time.monotonic() - sent[0] < 5
    assert r3.solve(pull=1e-3).stable
