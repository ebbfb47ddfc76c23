"""Robots and reference data that the tests share."""

from __future__ import annotations

import math
import os
import signal
from pathlib import Path
from typing import Iterator

import pytest

import cppr

ROOT = Path(__file__).resolve().parents[3]
os.environ.setdefault("MPLBACKEND", "Agg")


def pytest_configure(config: pytest.Config) -> None:
    # Here and not in pyproject.toml, which tests that know no cppr read too.
    config.addinivalue_line("filterwarnings", "error::cppr.UnitWarning")


@pytest.fixture(autouse=True)
def at_the_root(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)


@pytest.fixture(autouse=True)
def interruptible() -> Iterator[None]:
    """A shell that starts the tests in the background has them ignore Ctrl-C, which some of them send to themselves."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def r3() -> cppr.Robot:
    return cppr.Robot.from_toml(ROOT / "robots/r3.toml")


@pytest.fixture
def three() -> cppr.Robot:
    return cppr.Robot.from_toml(ROOT / "robots/childs3.toml")


def uniform(offsets: tuple[float, float] = (2e-3, 1e-3), length: float = 0.1) -> cppr.Robot:
    """Two opposed uniform tubes, whose unloaded curvature does not depend on their stiffness."""
    tubes = [
        cppr.StiffnessTube(offset, 0.02, 0.01, 0.005, opening, axial=1e5, mass_per_length=0.01)
        for offset, opening in zip(offsets, (math.pi, 0.0))
    ]
    return cppr.Robot(length, tubes, name="uniform")
