"""What is wrong is said in a sentence."""

from __future__ import annotations

import dataclasses
import math
import pickle
import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_robot import PLA, r3_in_code

import cppr

Call = Callable[[cppr.Robot], Any]

COMMANDS: list[tuple[Call, type[Exception], str]] = [
    (lambda r: r.solve(pull=5), cppr.CommandError, "cannot slide by 5000.000 mm.*Check the unit"),
    (lambda r: r.solve(pull=math.nan), cppr.CommandError, "tube 2 is given a value that is not finite"),
    (lambda r: r.solve(pull={3: 1e-3}), cppr.CommandError, "no tube 3; the only follower .* is tube 2"),
    (lambda r: r.solve(pull={1: 1e-3}), cppr.CommandError, "tube 1 is the leader"),
    (lambda r: r.solve(pull={"a": 1e-3}), TypeError, "a tube of pull must be a tube number, not str"),
    (lambda r: r.solve(pull=1e-3, tension=1), cppr.CommandError, "both pull and tension"),
    (lambda r: r.solve(pull=[1e-3]), TypeError, "number .* or a dict .* solve_many takes arrays, not list"),
    (lambda r: r.solve(pull="5mm"), TypeError, "not str"),
    (lambda r: r.solve(pull=True), TypeError, "not bool"),
    (lambda r: r.solve(tip_force=[1, 2]), ValueError, "tip_force has 2 components; give three"),
    (lambda r: r.solve(tip_force=1.0), TypeError, "tip_force must be a sequence of three numbers"),
    (lambda r: r.solve(tip_force=[0, 0, math.inf]), cppr.CommandError, "not a finite number"),
    (lambda r: r.solve(loads=cppr.Gravity()), TypeError, "loads must be a list of"),
    (lambda r: r.solve(loads=[1]), TypeError, "a load must be"),
    (lambda r: r.solve(loads=[type("Gravity", (), {"acceleration": (0, 0, -1)})()]), TypeError, "a load must be"),
    (lambda r: r.solve(settings=type("Settings", (), {})()), TypeError, "settings must be a Settings"),
    (lambda r: r.solve(loads=[cppr.Wrench((0, 1, 0), at=0.2)]), cppr.CommandError, "200.000 mm, but"),
    (lambda r: r.solve(loads=[cppr.Wrench((0, 1, 0), frame="tip")]), ValueError, '"base" or "section"'),
    (lambda r: r.solve(settings={"planar": True}), TypeError, "settings must be a Settings, not dict"),
    (lambda r: r.solve(settings=cppr.Settings(refine=0)), ValueError, "refine .* must be from 1 to 8 and whole"),
    (lambda r: r.solve(settings=cppr.Settings(formulation="paper")), ValueError, '"consistent" or "printed"'),
    (lambda r: r.solve(tip_force=(0, 0, 1), settings=cppr.Settings(planar=True)), cppr.CommandError, "plane"),
    (lambda r: r.solve(start=3), TypeError, "Equilibrium"),
    (lambda r: r.solve_many(pull=[1e-3, math.nan]), cppr.CommandError, "pose 1: .* not finite"),
    (lambda r: r.solve_many(pull=[1e-3, 5]), cppr.CommandError, "pose 1: .* Check the unit"),
    (lambda r: r.solve_many(pull=np.zeros(3), rotate=np.zeros(4)), ValueError, "do not broadcast"),
    (lambda r: r.solve_many(pull=["a"]), TypeError, "array of numbers"),
    (lambda r: r.solve_many(pull={4: [0]}), cppr.CommandError, "no tube 4"),
    (lambda r: r.solve_many(tip_force=[1, 2]), ValueError, "last axis must hold 3"),
    (lambda r: r.solve_many(pull=[0], sections=-1), ValueError, "sections"),
    (lambda r: r.solve_many(pull=[0], threads=0), ValueError, "threads"),
    (lambda r: r.solve_many(pull=np.broadcast_to(1e-3, (10**6, 10**8))), MemoryError, "allocate"),
    (lambda r: r.solve().sample([0.2]), ValueError, "0.2 m; the robot reaches from 0 to 0.15 m"),
    (lambda r: r.solve().sample(1), ValueError, "from 2 to"),
    (lambda r: r.solve().sample([[0.1]]), TypeError, "one-dimensional"),
    (lambda r: r.fields([0.2]), ValueError, "end at the tip"),
    (lambda r: r.fields([0.1], tube=3), cppr.CommandError, "tubes 1 to 2"),
]


@pytest.mark.parametrize(("call", "kind", "sentence"), COMMANDS)
def test_commands_that_cannot_be(r3: cppr.Robot, call: Call, kind: type[Exception], sentence: str) -> None:
    with pytest.raises(kind) as caught:
        call(r3)
    assert re.search(sentence, str(caught.value)), str(caught.value)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda r: r.solve(rotate=90), "90 degrees is 1.5708"),
        (lambda r: r.solve(rotate=10), "90 degrees is 1.5708"),
        (lambda r: r.solve_many(rotate=[0, 90]), "90 degrees is 1.5708"),
        (lambda r: r.solve(torque=20), "20 N mm is 0.020"),
        (lambda r: r.solve(tension=3000), "forces are in newtons"),
        (lambda r: r3_in_code(outer_radius=4.5), "3 mm is 0.003"),
        (lambda r: r3_in_code(material=cppr.Material(5.39, 0.35)), "5 GPa is 5e9"),
        (lambda r: cppr.Robot(150, r.tubes), "150 mm is 0.150"),
    ],
)
def test_unit_slips_are_warned_of(r3: cppr.Robot, call: Call, sentence: str) -> None:
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        try:
            call(r3)
        except cppr.Error:
            pass
    assert any(w.category is cppr.UnitWarning and sentence in str(w.message) for w in seen), seen


def test_ordinary_numbers_are_not_warned_of() -> None:
    # pytest turns a UnitWarning into an error.
    for name in ("r1", "r4", "childs2", "helicoid"):
        cppr.Robot.from_toml(f"robots/{name}.toml").solve(tension=0.5, torque=1e-3)


def test_a_robot_error_lists_every_problem() -> None:
    text = (cppr_file := Path("robots/r3.toml").read_text()).replace("outer_radius_mm = 4.5", "outer_radius = 4.5")
    text = text.replace("tooth_mm = 5.0", "tooth_mm = -5.0")
    assert text != cppr_file
    with pytest.raises(cppr.RobotError) as caught:
        cppr.Robot.from_toml_text(text)
    problems = caught.value.problems
    assert len(problems) >= 3 and all(p.line > 0 and p.message for p in problems)
    assert str(caught.value).count("line ") >= 3
    again = pickle.loads(pickle.dumps(caught.value))
    assert again.problems == problems and str(again) == str(caught.value)
    with pytest.raises(cppr.RobotError, match="cannot be read"):
        cppr.Robot.from_toml("robots/none.toml")


@pytest.mark.parametrize(
    ("build", "kind", "sentence"),
    [
        (lambda: r3_in_code(depth=9.5e-3), cppr.RobotError, "tube 1 .*leaves nothing"),
        (lambda: r3_in_code(depth=math.nan), cppr.RobotError, "depth of tube 1: value 1 is NaN"),
        (lambda: r3_in_code(depth=[[1, 2]]), TypeError, "depth of tube 1 must be a number, a one-dim"),
        (lambda: r3_in_code(depth=lambda x: "a"), TypeError, "function for the depth of tube 1"),
        (lambda: r3_in_code(depth=cppr.Table([0, 1], [1, 2, 3])), cppr.RobotError, "3 values for 2 absc"),
        (lambda: r3_in_code(depth=cppr.PerNotch([1, 2])), cppr.RobotError, "one per notch"),
        (lambda: r3_in_code(inner_radius="a"), TypeError, "inner_radius of tube 1 must be a number"),
        (lambda: r3_in_code(inner_radius=3e-3), cppr.RobotError, "tube 2 .*bore"),
        (lambda: r3_in_code(shape="oval"), ValueError, '"round" or "square" or "hexagon", not "oval"'),
        (lambda: r3_in_code(material=3), TypeError, "material of tube 1 must be a Material"),
        (lambda: r3_in_code(notches=cppr.NotchPattern(5e-3, 5e-3, 16)), cppr.RobotError, "do not fit"),
        (lambda: cppr.Robot(0.1, [3]), TypeError, "tube 1 must be a NotchedTube or a StiffnessTube"),
        (lambda: cppr.Robot(0.1, []), cppr.RobotError, "no tube"),
        (lambda: cppr.Robot(math.nan, r3_in_code().tubes), cppr.RobotError, "length is NaN"),
        (lambda: cppr.Robot("a", []), TypeError, "length must be a number, not str"),
        (lambda: cppr.section(3e-3, 2e-3, 7e-3), cppr.RobotError, "leaves nothing"),
    ],
)
def test_robots_that_cannot_be(build: Callable[[], Any], kind: type[Exception], sentence: str) -> None:
    with pytest.raises(kind) as caught:
        build()
    assert re.search(sentence, str(caught.value)), str(caught.value)


def test_all_tubes_are_looked_at() -> None:
    tube = cppr.NotchedTube(4.5e-3, 3.7e-3, math.nan, math.pi, PLA)
    with pytest.raises(cppr.RobotError) as caught:
        cppr.Robot(0.15, [tube, dataclasses.replace(tube, outer_radius=3e-3, inner_radius=2e-3)])
    assert [p.key for p in caught.value.problems] == ["depth of tube 1", "depth of tube 2"]


def test_no_equilibrium_carries_the_last_iterate(r3: cppr.Robot) -> None:
    with pytest.raises(cppr.NoEquilibrium, match="not converged") as caught:
        r3.solve(pull=0.02, settings=cppr.Settings(planar=True, formulation="printed"))
    found = caught.value
    assert 0.1 < found.fraction < 1 and found.equilibrium is not None
    assert found.equilibrium.status == "not converged" and not found.equilibrium.stable
    assert np.isfinite(found.equilibrium.shape.centre).all()
    with pytest.raises(cppr.NoEquilibrium, match="differentiate"):
        _ = found.equilibrium.jacobian
    again = pickle.loads(pickle.dumps(found))
    assert again.fraction == found.fraction and again.equilibrium is None
