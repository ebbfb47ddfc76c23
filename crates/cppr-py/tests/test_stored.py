"""Equilibria and shapes survive pickling and copying; masked arrays are refused."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cppr

ROOT = Path(__file__).parents[3]
Store = Callable[[Any], Any]
WAYS: list[Store] = [lambda x: pickle.loads(pickle.dumps(x)), copy.copy, copy.deepcopy]
FIELDS = [
    "x", "centre", "rotation", "curvature", "angles", "energy_density", "abscissa", "centroid", "tube_rotation", "rate",
    "strain", "stretch", "moment", "force",
]  # fmt: skip


def solved(name: str) -> cppr.Equilibrium:
    robot = cppr.Robot.from_toml(ROOT / f"robots/{name}.toml")
    # Pushed, so that there is an edge; loaded in every way.
    loads: list[cppr.Load] = [
        cppr.Wrench((0, 0.02, 0), at=0.5 * robot.length),
        cppr.DistributedForce((0, 0, 0.1), 0.0, 0.4 * robot.length),
        cppr.Thread(0.02, (robot.length, -0.2, 0)),
    ]
    return robot.solve(pull=-1e-3, torque=1e-3, tip_force=(0, 0, 0.01), loads=loads)


@pytest.mark.parametrize("store", WAYS, ids=["pickle", "copy", "deepcopy"])
@pytest.mark.parametrize("name", ["r3", "childs3", "helicoid"])
def test_an_equilibrium_is_the_same_again(name: str, store: Store) -> None:
    eq = solved(name)
    again = store(eq)
    assert again is not eq and again.robot.name == eq.robot.name
    for number in ("status", "elastic_energy", "residual", "iterations", "evaluations", "load_steps", "margin", "loads"):
        assert getattr(again, number) == getattr(eq, number), number
    for array in ("tip_position", "tip_rotation", "pull", "rotation", "tension", "torque", "jacobian", "compliance"):
        assert np.array_equal(getattr(again, array), getattr(eq, array)), array
    for field in FIELDS:
        assert np.array_equal(getattr(again.shape, field), getattr(eq.shape, field)), field
    # It goes on where it stood, with its own robot and with the one it came from.
    for robot in (again.robot, eq.robot):
        onwards = robot.solve(pull=-1.1e-3, torque=1e-3, start=again)
        assert np.allclose(onwards.tip_position, eq.robot.solve(pull=-1.1e-3, torque=1e-3, start=eq).tip_position, atol=1e-12)


def test_another_branch_stays_itself() -> None:
    """Solving again from rest would lead elsewhere."""
    robot = cppr.Robot.from_toml(ROOT / "robots/r3.toml")
    wound = robot.solve(rotate=0.0, tip_force=(0, 0, 1.0))
    for turn in np.linspace(0, 2 * np.pi, 25):
        wound = robot.solve(rotate=turn, tip_force=(0, 0, 1.0 - turn / (2 * np.pi)), start=wound)
    again = pickle.loads(pickle.dumps(wound))
    assert np.array_equal(again.tip_position, wound.tip_position)
    assert again.tension == wound.tension


def test_no_equilibrium_is_stored_as_such() -> None:
    robot = cppr.Robot.from_toml(ROOT / "robots/r3.toml")
    with pytest.raises(cppr.NoEquilibrium) as caught:
        robot.solve(pull=0.02, settings=cppr.Settings(planar=True, formulation="printed"))
    again = pickle.loads(pickle.dumps(caught.value.equilibrium))
    assert again.status == "not converged"
    with pytest.raises(cppr.NoEquilibrium, match="differentiate"):
        _ = again.jacobian


BUNDLES = ["bundles/two_sections", "bundles/hybrid", "bundles/two_curved", "wrists/wrist90"]


@pytest.mark.parametrize("store", WAYS, ids=["pickle", "copy", "deepcopy"])
@pytest.mark.parametrize("name", BUNDLES)
def test_a_robot_of_parts_is_the_same_again(name: str, store: Store) -> None:
    robot = cppr.Bundle.from_toml(ROOT / f"robots/{name}.toml")
    loads: list[cppr.Load] = [cppr.DistributedForce((0, 0, 0.02), 0.0, 0.3 * robot.lengths[0])]
    asked: dict[str, Any] = {"pull": {2: 5e-4}, "rotate": {2: 0.2}, "tip_force": (0, 0, 5e-3), "loads": loads}
    eq = robot.solve(**asked)
    own, again = store(robot), store(eq)
    assert own is not robot and (own.name, repr(own)) == (robot.name, repr(robot))
    # The same design, the same numbers: to the last digit.
    assert np.array_equal(own.solve(**asked).tip_position, eq.tip_position)
    assert again is not eq and again.robot.name == robot.name and repr(again) == repr(eq)
    for number in ("stable", "length", "tip_error", "force_error", "iterations", "joints", "inputs"):
        assert getattr(again, number) == getattr(eq, number), number
    for array in ("tip_position", "tip_rotation", "pull", "rotation", "tension", "torque", "jacobian", "response", "compliance"):
        assert np.array_equal(getattr(again, array), getattr(eq, array)), array
    fields, wanted = again.sample(), eq.sample()
    for field in wanted:
        assert np.array_equal(fields[field], wanted[field], equal_nan=True), field
    # It goes on where it stood, with its own robot and with the one it came from.
    asked["pull"] = {2: 6e-4}
    onwards = [r.solve(**asked, start=s).tip_position for r in (again.robot, robot) for s in (again, eq)]
    assert all(np.array_equal(tip, onwards[0]) for tip in onwards)
    with pytest.raises(ValueError, match="another robot"):
        cppr.Bundle.from_toml(ROOT / "robots/bundles/s_shape.toml").solve(start=again)


def test_teeth_survive_pickling() -> None:
    """What has no place in the dataclasses is kept too."""
    text = (ROOT / "robots/r1.toml").read_text()
    stiff = text.replace("[tube.notches]", '[tube.notches]\nteeth = "rigid"')
    robot, plain = cppr.Robot.from_toml_text(stiff), cppr.Robot.from_toml_text(text)
    tension = robot.solve(pull=3e-3).tension
    assert tension[0] > 1.05 * plain.solve(pull=3e-3).tension[0]
    assert np.array_equal(pickle.loads(pickle.dumps(robot)).solve(pull=3e-3).tension, tension)


@pytest.mark.parametrize("store", WAYS[::2], ids=["pickle", "deepcopy"])
def test_a_shape_has_arrays_of_its_own(store: Store) -> None:
    shape = solved("r3").sample(7)
    again = store(shape)
    for field in FIELDS:
        assert np.array_equal(getattr(again, field), getattr(shape, field)), field
    again.centre[0] = 1.0
    assert shape.centre[0].tolist() == [0, 0, 0]
    assert repr(again) == repr(shape)


def test_another_process_reads_it(tmp_path: Path) -> None:
    eq = solved("childs3")
    file = tmp_path / "eq.pickle"
    file.write_bytes(pickle.dumps(eq))
    code = "import pickle, sys; eq = pickle.load(open(sys.argv[1], 'rb')); print(eq.tip_position.tobytes().hex())"
    out = subprocess.run([sys.executable, "-c", code, str(file)], check=True, capture_output=True, text=True)
    assert out.stdout.strip() == eq.tip_position.tobytes().hex()


def test_what_is_no_equilibrium_is_refused() -> None:
    eq = solved("r3")
    restore, (robot, state, version) = eq.__reduce__()
    with pytest.raises(ValueError, match="of cppr 0.0.1"):
        restore(robot, state, "0.0.1")
    with pytest.raises(ValueError, match="cannot be read"):
        restore(robot, state[:20], version)
    with pytest.raises(ValueError, match="another robot"):
        restore(cppr.Robot.from_toml(ROOT / "robots/childs3.toml"), state, version)


def test_what_is_no_robot_of_parts_is_refused() -> None:
    robot = cppr.Bundle.from_toml(ROOT / "robots/bundles/two_sections.toml")
    restore, (state, version) = robot.__reduce__()
    with pytest.raises(ValueError, match="of cppr 0.0.1"):
        restore(state, "0.0.1")
    with pytest.raises(ValueError, match="cannot be read"):
        restore(state[:20], version)
    restore, (_, state, version) = robot.solve().__reduce__()
    with pytest.raises(ValueError, match="another robot"):
        restore(cppr.Bundle.from_toml(ROOT / "robots/bundles/s_shape.toml"), state, version)


HALF = np.ma.masked_array([1e-3, 2e-3, 3e-3], mask=[False, True, False])
POINT = np.ma.masked_array([[0.1, 0, 0], [0.12, 0, 0]], mask=[[0, 0, 0], [0, 1, 0]])


@pytest.mark.parametrize(
    "call",
    [
        lambda r: r.solve_many(pull=HALF),
        lambda r: r.solve_many(tip_force=np.ma.masked_array(np.zeros((2, 3)), mask=np.eye(2, 3))),
        lambda r: r.solve(tip_force=HALF),
        lambda r: r.solve(loads=[cppr.Wrench(HALF)]),
        lambda r: r.solve().sample(np.ma.masked_array([0.1, 0.2], mask=[False, True])),
        lambda r: r.solve().match_shape(POINT),
        lambda r: r.solve().reach(position=HALF),
        lambda r: r.fields(HALF),
    ],
)
def test_masked_values_are_refused(r3: cppr.Robot, call: Callable[[cppr.Robot], Any]) -> None:
    with pytest.raises(ValueError, match="masked values: leave them out"):
        call(r3)


PART = cppr.Part(0.1, cppr.StiffnessTube(1e-3, 0.02, 0.01, 0.01, opening=0.0))


@pytest.mark.parametrize(
    "call",
    [
        lambda r: r.solve(pull={2: HALF[1]}),
        lambda r: r.solve(tip_force=HALF),
        lambda r: r.solve(tip_moment=HALF),
        lambda r: r.solve(loads=[cppr.Wrench(HALF)]),
        lambda r: r.solve().match_shape(POINT),
        lambda r: r.solve().reach(position=HALF),
        lambda r: r.cycle([{"pull": 0.0}, {"pull": HALF[1]}], 0.1),
        lambda r: cppr.Bundle([cppr.Tube([PART]), cppr.Tube([PART])], [cppr.Joint([1, 2], np.ma.masked_array([0.1, 0.1], mask=[0, 1]))]),
        lambda r: cppr.Bundle([cppr.Tube([cppr.Part(HALF[1], PART.body)])]),
    ],
)
def test_masked_values_are_refused_of_parts_too(call: Callable[[cppr.Bundle], Any]) -> None:
    with pytest.raises((ValueError, TypeError), match="masked values: leave them out|must be a number, not MaskedConstant"):
        call(cppr.Bundle.from_toml(ROOT / "robots/bundles/two_sections.toml"))


def test_a_mask_that_hides_nothing_changes_nothing(r3: cppr.Robot) -> None:
    plain = np.array([1e-3, 2e-3])
    masked = r3.solve_many(pull=np.ma.masked_array(plain, mask=False))
    assert np.array_equal(masked.tip_position, r3.solve_many(pull=plain).tip_position)


def test_degrees_in_a_sweep_are_warned_of(tmp_path: Path) -> None:
    with pytest.warns(cppr.UnitWarning, match="90 degrees is 1.5708"):
        cppr.sweep(ROOT / "robots/r3.toml", tmp_path / "poses.csv", rotate=cppr.Range(-90, 90, 3))
