"""Robots of parts and joints, against an independent program and against their files."""

from __future__ import annotations

import json
import math

import matplotlib
import numpy as np
import pytest
from conftest import ROOT

import cppr

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

OUTER = cppr.StiffnessTube(3.056e-3, 0.0175, 0.00115, 0.00134, opening=math.pi)
INNER = cppr.StiffnessTube(1.155e-3, 0.00495, 0.00074, 0.000838, opening=0.0)


def turned(tube: cppr.StiffnessTube) -> cppr.StiffnessTube:
    return cppr.StiffnessTube(
        tube.centroid_offset, tube.bending_y, tube.bending_z, tube.torsion, math.pi - float(tube.opening)
    )  # fmt: skip


def s_shape() -> cppr.Bundle:
    tubes = [cppr.Tube([cppr.Part(0.075, t), cppr.Part(0.075, turned(t))]) for t in (OUTER, INNER)]
    return cppr.Bundle(tubes, [cppr.Joint([1, 2])], name="S")


def expected(name: str) -> dict[str, list[float]]:
    cases = json.loads((ROOT / "crates/cppr/tests/data/general_bundles.json").read_text())
    return next(case["expected"] for case in cases if case["name"] == name)


def test_an_s_bends_as_an_independent_program_says() -> None:
    eq = s_shape().solve(pull=5 * cppr.mm)
    reference = expected("s_shape_pull")
    assert eq.stable and np.allclose(eq.tip_position, reference["tip_m"], atol=3e-8)
    assert np.allclose(eq.tension, reference["force_N"], rtol=1e-6, atol=1e-6)
    assert eq.tip_error < 1e-8 and 0.14 < eq.length < 0.16
    # A joint of all tips is what is meant where none is written.
    tubes = [cppr.Tube([cppr.Part(0.075, t), cppr.Part(0.075, turned(t))]) for t in (OUTER, INNER)]
    assert np.allclose(cppr.Bundle(tubes).solve(pull=5e-3).tip_position, eq.tip_position, atol=1e-12)


def test_a_file_is_read() -> None:
    robot = cppr.Bundle.from_toml(ROOT / "robots/bundles/two_sections.toml")
    eq = robot.solve(pull={2: 3e-3, 4: 2e-3})
    assert np.allclose(eq.tip_position, expected("two_sections")["tip_m"], atol=3e-8)
    assert [sorted(j) for j in eq.joints] == [[1, 2], [3, 4]]
    assert np.allclose(robot.lengths, [0.06, 0.06, 0.12, 0.12]) and "4 tubes" in repr(robot)


def test_the_jacobian_is_the_slope_and_a_start_is_taken() -> None:
    robot = s_shape()
    eq = robot.solve(pull=2e-3, rotate={2: 0.3}, tip_force=(0, 0.05, 0))
    step = 1e-6
    moved = robot.solve(pull=2e-3 + step, rotate={2: 0.3}, tip_force=(0, 0.05, 0), start=eq)
    slope = (moved.tip_position - eq.tip_position) / step
    assert eq.tip_jacobian.shape == (6, 4) and np.linalg.norm(slope) > 1
    assert np.allclose(eq.tip_jacobian[:3, 2], slope, rtol=1e-3, atol=1e-2)


def test_the_outer_tube_can_be_advanced() -> None:
    robot = cppr.Bundle.from_toml(ROOT / "robots/bundles/s_shape.toml")
    eq = robot.solve(pull={1: -0.02, 2: -0.02})
    assert np.allclose(eq.tip_position, [0.17, 0, 0], atol=1e-9)


def test_it_is_drawn_with_its_joints() -> None:
    flat = s_shape().solve(pull=5e-3)
    ax = flat.plot()
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert labels == ["tube 2", "tube 1", "centre", "joint"] and ax.get_xlabel() == "x (mm)"
    curved = cppr.Bundle.from_toml(ROOT / "robots/bundles/concentric3.toml").solve(rotate={2: 1.0})
    assert curved.plot().name == "3d"
    fields = curved.sample(2e-3)
    # Beyond its tip a tube has no fields.
    assert np.isnan(fields["abscissa"][-1, 0]) and fields["abscissa"][-1, 2] == pytest.approx(0.18)
    plt.close("all")


def test_what_is_wrong_is_said() -> None:
    tube = cppr.Tube([cppr.Part(0.1, OUTER)])
    for make, error, fragment in [
        (lambda: cppr.Bundle([tube, cppr.Tube([cppr.Part(0.05, INNER)])]), cppr.RobotError, "do not meet"),
        (lambda: cppr.Bundle([tube], [cppr.Joint([1])]), cppr.RobotError, "two"),
        (lambda: cppr.Bundle([tube], [cppr.Joint([1, 2])]), cppr.RobotError, "there is no tube 2"),
        (lambda: cppr.Bundle([OUTER]), TypeError, "a Tube"),
        (lambda: s_shape().solve(pull={3: 1e-3}), cppr.CommandError, "tubes 1 to 2"),
        (lambda: s_shape().solve(pull=1e-3, tension=1.0), cppr.CommandError, "tube 2"),
        (lambda: s_shape().solve(pull=0.2), cppr.CommandError, "behind the plate"),
        (lambda: s_shape().solve(pull=math.nan), cppr.CommandError, "finite"),
        (lambda: s_shape().solve().sample(0.0), ValueError, "spacing"),
    ]:
        with pytest.raises(error, match=fragment):
            make()
    with pytest.warns(cppr.UnitWarning, match="radians"):
        s_shape().solve(rotate={1: 90, 2: 90})
