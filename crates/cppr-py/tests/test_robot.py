"""Robots from files and from code."""

from __future__ import annotations

import dataclasses
import json
import math
import pickle
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, uniform

import cppr

PLA = cppr.Material(youngs_modulus=5.39e9, poissons_ratio=0.35, density=1240)
NOTCHES = cppr.NotchPattern(length=5e-3, tooth=5e-3, count=15)


def r3_in_code(**changes: object) -> cppr.Robot:
    leader = cppr.NotchedTube(
        outer_radius=4.5e-3, inner_radius=3.7e-3, depth=(8.2e-3, 7.2e-3), opening=math.pi,
        material=PLA, notches=NOTCHES, centroid_offset_factor=1.32,
    )  # fmt: skip
    follower = cppr.NotchedTube(
        outer_radius=3.2e-3, inner_radius=2.4e-3, depth=(5.6e-3, 4.95e-3), opening=0.0,
        material=PLA, notches=NOTCHES, centroid_offset_factor=1.32,
    )  # fmt: skip
    return cppr.Robot(0.15, [dataclasses.replace(leader, **changes), follower], name="R3")


def test_code_and_file_make_the_same_robot(r3: cppr.Robot) -> None:
    tip = r3.solve(pull=5e-3).tip_position
    assert np.abs(r3_in_code().solve(pull=5e-3).tip_position - tip).max() < 1e-12


@pytest.mark.parametrize(
    "depth",
    [
        lambda x: 8.2e-3 - 1e-3 * x / 0.15,
        np.linspace(8.2e-3, 7.2e-3, 7),
        cppr.Table([0.0, 0.07, 0.15], np.interp([0.0, 0.07, 0.15], [0, 0.15], [8.2e-3, 7.2e-3])),
        cppr.PerNotch(8.2e-3 - 1e-3 * (np.arange(15) + 0.5) / 15),
    ],
    ids=["function", "array", "table", "per notch"],
)
def test_every_way_to_write_a_profile(r3: cppr.Robot, depth: cppr.ProfileLike) -> None:
    tip = r3.solve(pull=5e-3).tip_position
    assert np.abs(r3_in_code(depth=depth).solve(pull=5e-3).tip_position - tip).max() < 1e-9
    other = r3_in_code(depth=(8.2e-3, 7.0e-3)).solve(pull=5e-3).tip_position
    assert np.abs(other - tip).max() > 1e-4


def test_a_robot_is_written_and_read(r3: cppr.Robot, tmp_path: Path) -> None:
    coded = r3_in_code(depth=lambda x: 8.2e-3 - 1e-3 * (x / 0.15) ** 2)
    for robot in (r3, coded):
        robot.to_toml(tmp_path / "it.toml")
        again = cppr.Robot.from_toml(tmp_path / "it.toml")
        assert (again.name, again.length) == (robot.name, robot.length)
        tip = again.solve(pull=5e-3, rotate=0.3).tip_position
        assert np.abs(tip - robot.solve(pull=5e-3, rotate=0.3).tip_position).max() < 1e-12
        assert [p.name for p in tmp_path.iterdir()] == ["it.toml"]
    assert "outer_diameter_mm = 9.0" in r3.to_toml_text()
    soft = dataclasses.replace(r3.tubes[0], material=dataclasses.replace(PLA, youngs_modulus=10.0))
    with pytest.warns(cppr.UnitWarning), pytest.raises(cppr.RobotError, match="less than any robot has"):
        cppr.Robot(0.15, [soft, r3.tubes[1]]).to_toml(tmp_path / "soft.toml")
    assert not (tmp_path / "soft.toml").exists()


def test_a_function_is_called_once_per_cell() -> None:
    seen: list[float] = []

    def depth(x: float) -> float:
        seen.append(x)
        return 8e-3

    r3_in_code(depth=depth)
    assert len(seen) == 257 and seen[0] == 0.0 and seen[-1] == 0.15


@pytest.mark.parametrize("path", sorted((ROOT / "robots").glob("*.toml")), ids=lambda p: p.stem)
def test_robots_survive_pickling(path: Path) -> None:
    robot = cppr.Robot.from_toml(path)
    again = pickle.loads(pickle.dumps(robot))
    pull = {tube: 1e-3 / tube for tube in robot.followers}
    assert (robot.solve(pull).tip_position == again.solve(pull).tip_position).all()
    assert again.tubes == robot.tubes and again.name == robot.name


def test_fields_and_sections(r3: cppr.Robot) -> None:
    fields = r3.fields([-0.01, 0.0, 0.15], tube=2)
    section = cppr.section(3.2e-3, 2.4e-3, 5.6e-3)
    assert fields["bending_z"][1] == pytest.approx(5.39e9 * section.inertia_z, rel=1e-12)
    assert fields["centroid_offset"][1] == pytest.approx(1.32 * section.centroid_offset, rel=1e-12)
    # Below the plate stands the uncut tube.
    assert fields["centroid_offset"][0] == 0 and fields["depth"].tolist() == [0.0, 5.6e-3, 4.95e-3]
    with (ROOT / "crates/cppr/tests/data/sections.json").open() as file:
        assert json.load(file)
    assert cppr.section(3e-3, 2e-3, 5e-3).area == pytest.approx(3.09748208011e-6, rel=1e-11)


def test_constant_curvature_in_closed_form() -> None:
    eq = uniform().solve(pull=2e-3)
    # K_Z = -Δa / ((D_1 + D_2) L), whatever the stiffness.
    assert np.allclose(eq.shape.curvature, [0, 0, -2e-3 / (3e-3 * 0.1)], atol=1e-9)
    assert np.allclose(eq.shape.rate[:, 1], 1 - 2e-3 / 0.1)
    assert eq.shape.x[-1] == 0.1 and eq.shape.abscissa[0].tolist() == pytest.approx([0.0, 2e-3])


def test_contact_computations_are_met() -> None:
    """Brute-force contact computations of planar robots (see the tests of the mechanics)."""
    with (ROOT / "crates/cppr/tests/data/planar_contact.json").open() as file:
        cases = json.load(file)["cases"]
    for case in cases:
        file_robot = cppr.Robot.from_toml(f"robots/{case['robot'].lower()}.toml")
        tubes = [
            dataclasses.replace(t, centroid_offset_factor=case["f_D"], below_plate="continued")
            for t in file_robot.tubes
        ]
        robot = cppr.Robot(file_robot.length, tubes, name=case["robot"])
        arm = robot.fields([robot.length])["centroid_offset"][0]
        load = cppr.Wrench(force=(0, case["tip_force_N"][1], 0), point=(0, arm, 0))
        eq = robot.solve(pull=case["delta_a_mm"] * 1e-3, loads=[load])
        tip = eq.sample(2).centroid[-1, 0, :2] * 1e3
        # 600 rigid links differ from a continuum by a few micrometres, modes by some more.
        assert np.abs(tip - case["brute_force"]["tip_mm"]).max() < 0.025, case["name"]
        assert eq.tension[0] == pytest.approx(case["brute_force"]["T_N"], abs=0.02)
    assert len(cases) == 8
