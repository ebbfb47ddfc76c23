"""Robots of parts and joints, against an independent program and against their files."""

from __future__ import annotations

import csv
import json
import math
import pickle
import warnings
from pathlib import Path
from typing import Any

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
    assert eq.jacobian.shape == (6, 4) and np.linalg.norm(slope) > 1
    assert np.allclose(eq.jacobian[:3, 2], slope, rtol=1e-3, atol=1e-2)


def test_many_poses_are_those_of_single_solves() -> None:
    robot = cppr.Bundle.from_toml(ROOT / "robots/bundles/two_sections.toml")
    pull2, pull4 = np.linspace(0, 3e-3, 4)[:, None], np.linspace(0, 2e-3, 31)
    told: list[tuple[int, int]] = []
    many = robot.solve_many(
        pull={2: pull2, 4: pull4}, tip_force=[0.0, 0.0, 0.02], jacobian=True, progress=lambda *at: told.append(at)
    )
    assert many.tip_position.shape == (4, 31, 3) and many.stable.all() and told[-1] == (124, 124)
    assert many.jacobian is not None and many.jacobian.shape == (4, 31, 6, 8)
    # Most poses begin at the one before; those at rest tell their error.
    assert np.isnan(many.tip_error).sum() > 60 and np.nanmax(many.tip_error) < 1e-6
    alone = robot.solve_many(pull={2: pull2, 4: pull4}, tip_force=[0.0, 0.0, 0.02], warm=False, threads=1)
    assert not np.isnan(alone.tip_error).any()
    for i, j in ((0, 0), (1, 17), (3, 30)):
        eq = robot.solve(pull={2: pull2[i, 0], 4: pull4[j]}, tip_force=[0.0, 0.0, 0.02])
        assert np.linalg.norm(many.tip_position[i, j] - eq.tip_position) < 1e-5 * robot.length
        assert np.allclose(alone.tip_position[i, j], eq.tip_position, atol=1e-12)
        assert np.allclose(many.tension[i, j], eq.tension, atol=1e-4)
        assert np.allclose(many.pull[i, j], eq.pull, atol=1e-12) and np.allclose(many.rotation[i, j], 0)
        scale = np.abs(eq.jacobian).max()
        assert np.allclose(many.jacobian[i, j], eq.jacobian, atol=1e-3 * scale)
    again = robot.solve_many(pull={2: pull2, 4: pull4}, tip_force=[0.0, 0.0, 0.02], threads=1)
    assert np.array_equal(again.tip_position, many.tip_position)
    with pytest.raises(cppr.CommandError, match=r"pull: there is no tube 5; this robot has tubes 1 to 4"):
        robot.solve_many(pull={5: [0.0, 1e-3]})
    with pytest.raises(cppr.CommandError, match=r"pose 1: "):
        robot.solve_many(pull={2: [0.0, math.nan]})
    assert "2 converged" in repr(robot.solve_many(pull={2: [0.0, 1e-3]}))


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


def uncut_ends() -> cppr.Bundle:
    return cppr.Bundle.from_toml(ROOT / "robots/bundles/uncut_ends.toml")


def test_limits_end_the_safe_ranges() -> None:
    text = (ROOT / "robots/bundles/uncut_ends.toml").read_text()
    brittle = text.replace("allowable_strain_percent = 6", "allowable_strain_percent = 0.5")
    assert brittle != text
    robot = cppr.Bundle.from_toml_text(brittle)
    eq = robot.solve(pull=0.3e-3)
    limits = eq.limits()
    assert sum(section.place == "notch" for section in limits.sections) == 200
    assert limits.governing is not None and 0.01 < limits.governing.utilisation < 0.9
    ranges = {(r.means, r.tube): r for r in eq.safe_ranges()}
    high = ranges["pull", 2].high
    assert high.bound == "limit" and high.limit is not None and high.limit.section is not None
    for part, least, most in ((0.98, 0.9, 1.0), (1.02, 1.0, 1.1)):
        used = robot.solve(pull=part * high.value).limits().governing
        assert used is not None and least < used.utilisation < most
    whole = robot.solve(pull=1.02 * high.value).safe_part()
    assert whole.bound == "limit" and whole.value == pytest.approx(1 / 1.02, rel=1e-3)
    assert eq.safe_part().value == 1.0


def test_derivatives_are_slopes() -> None:
    robot = s_shape()
    motors = {"pull": {2: 2e-3}, "rotate": {2: 0.3}}
    eq = robot.solve(**motors, tip_force=(0, 0.05, 0.0))
    assert eq.inputs[2:] == (("pull", 2), ("rotate", 2))
    force = 1e-4
    pushed = robot.solve(**motors, tip_force=(0, 0.05, force), start=eq)
    slope = (pushed.tip_position - eq.tip_position) / force
    assert np.linalg.norm(slope) > 1e-3
    assert np.allclose(eq.compliance[:3, 2], slope, rtol=2e-3, atol=1e-3 * np.linalg.norm(slope))
    tension = (pushed.tension[1] - eq.tension[1]) / force
    assert eq.response_by_wrench[2, 2] == pytest.approx(tension, rel=5e-3, abs=1e-3)
    step = 1e-6
    moved = robot.solve(pull=2e-3 + step, rotate={2: 0.3}, tip_force=(0, 0.05, 0.0), start=eq)
    assert eq.response[2, 2] == pytest.approx((moved.tension[1] - eq.tension[1]) / step, rel=1e-3)
    assert np.allclose(eq.jacobian_body[:3], eq.tip_rotation.T @ eq.jacobian[:3])


def test_a_path_turns_at_folds_and_begins_where_it_is_asked_from() -> None:
    eq = cppr.Bundle.from_toml(ROOT / "robots/bundles/two_curved.toml").solve()
    (path,) = eq.continue_path(rotate={2: 2 * math.pi})
    assert path.reached and path.kind.count("fold") == 2 and not path.stable.all()
    assert np.allclose([e.rotation[1] for e in path.equilibria], path.parameter, atol=1e-9)
    # From an unstable one between the folds, which no solve from rest gives.
    unstable = path.equilibria[int(np.flatnonzero(~path.stable)[2])]
    (back,) = unstable.continue_path(rotate={2: 0.0})
    assert np.allclose(back.tip_position[0], unstable.tip_position, atol=1e-9) and not back.stable[0]
    loaded = s_shape().solve(pull=1e-3, tip_force=(0, 0.05, 0))
    (more,) = loaded.continue_path(load_factor=2.0)
    twice = s_shape().solve(pull=1e-3, tip_force=(0, 0.1, 0))
    assert more.reached and np.allclose(more.tip_position[-1], twice.tip_position, atol=1e-7)
    with pytest.raises(cppr.CommandError, match="not both"):
        loaded.continue_path(pull=2e-3, load_factor=2.0)


def test_motors_for_a_tip_and_a_shape_and_the_force_on_it() -> None:
    robot = uncut_ends()
    wanted = robot.solve(pull=1e-3, rotate=0.5)
    start = robot.solve(pull=0.5e-3)
    for near in (False, True):
        found = start.reach(position=wanted.tip_position, near=near)
        assert found.reached and found.distance is not None and found.distance < 1e-6
        assert {tube for _, tube in found.inputs} == {2} and 0 < found.limit_used < 1
        assert np.allclose(found.equilibrium.tip_position, wanted.tip_position, atol=1e-6)
    points = wanted.sample(wanted.length / 8)["centre"][1:]
    match = start.match_shape(points)
    assert match.rms < 1e-6 and dict(zip(match.inputs, match.values))["pull", 2] == pytest.approx(1e-3, rel=1e-2)
    force = np.array([0.0, 0.02, -0.01])
    pushed = robot.solve(pull=0.5e-3, tip_force=force)
    sensed = start.sense(tension={2: pushed.tension[1]}, position=pushed.tip_position)
    assert np.allclose(sensed.force, force, atol=2e-4) and sensed.misfit < 0.1
    with pytest.raises(cppr.CommandError, match="tubes 1 to 2"):
        start.sense(tension={3: 1.0}, position=pushed.tip_position)


def test_it_is_calibrated() -> None:
    robot = cppr.Bundle.from_toml(ROOT / "robots/bundles/concentric3.toml")
    fit = cppr.calibrate(
        robot, ROOT / "examples/calibration/concentric3.csv", ["rest_curvature_factor", "shear_modulus"]
    )
    truth = np.array([1.06, 20e9])
    assert (np.abs(fit.values - truth) < 2 * fit.intervals).all() and fit.rms < 0.5 * fit.rms_before
    (fitted,) = fit.robots
    assert isinstance(fitted, cppr.Bundle)
    assert np.linalg.norm(fitted.solve().tip_position - robot.solve().tip_position) > 1e-3


def test_friction_is_calibrated(tmp_path: Path) -> None:
    robot = cppr.Robot.from_toml(ROOT / "robots/r1.toml")
    rows = ["pull2_mm,driven,measured_tension2_N,sigma_N"]
    for pull in (2.0, 5.0):
        on, back = robot.solve(pull=pull * 1e-3).friction(0.25)
        rows += [f"{pull},{way},{own['tension'][1]},1e-4" for way, own in (("on", on), ("back", back))]
    data = tmp_path / "loops.csv"
    data.write_text("\n".join(rows) + "\n")
    fit = cppr.calibrate(robot, data, ["youngs_modulus", "friction"], friction=0.1)
    assert abs(fit.values[1] / 0.25 - 1) < 1e-4 and fit.before[1] == 0.1 and fit.at_bounds == (False, False)
    assert abs(fit.values[0] / fit.before[0] - 1) < 1e-4 and np.isnan(fit.rms)
    (tension,) = fit.misses
    assert tension.what == "tension2" and tension.before > 0.05 and tension.fitted < 1e-4
    assert fit.residuals[0].what == "tension2" and "rms tension2" in repr(fit)
    (fitted,) = fit.robots
    assert fitted.friction == fit.values[1] and robot.friction is None
    known = cppr.calibrate(fitted, data, [])
    assert len(known.values) == 0 and known.misses[0].fitted < 1e-4
    assert cppr.calibrate(robot, data, [], friction=0.25).misses[0].fitted < 1e-4
    with pytest.raises(cppr.CalibrationError, match="rub differently"):
        cppr.calibrate([robot, fitted], data, [])


@pytest.mark.parametrize("file", ["r1.toml", "bundles/s_shape.toml"])
def test_a_robot_holds_friction(tmp_path: Path, file: str) -> None:
    path = tmp_path / "rubs.toml"
    path.write_text((ROOT / "robots" / file).read_text() + "\n[friction]\ncoefficient = 0.2\nguide_mm = 20\n")
    kind = cppr.Robot if file == "r1.toml" else cppr.Bundle
    robot = kind.from_toml(path)
    assert (robot.friction, robot.guide) == (0.2, 0.02)
    eq = robot.solve(pull=2e-3)
    told, own = eq.friction(0.2, 0.02), eq.friction()
    assert own[0]["tension"][1] == told[0]["tension"][1] > eq.friction(0.1)[0]["tension"][1]

    def sensed(**friction: float) -> list[Any]:
        seen = eq.sense(tension=told[1]["tension"][1], position=told[1]["tip_position"], **friction)
        return [side and side.force.tolist() for side in (seen.loading, seen.unloading)]

    assert sensed() == sensed(friction=0.2, guide=0.02) != sensed(friction=0.0) == [None, None]
    for copied in (pickle.loads(pickle.dumps(robot)), pickle.loads(pickle.dumps(eq)).robot, eq.robot):
        assert (copied.friction, copied.guide) == (0.2, 0.02)
    output = tmp_path / "table.npz"
    cppr.sweep(path, output, pull=cppr.Range(1e-3, 2e-3, 2))
    assert np.load(output)["loading_tube2_tension_N"][-1] == pytest.approx(own[0]["tension"][1], rel=1e-4)
    bundle = robot if isinstance(robot, cppr.Bundle) else cppr.Bundle.of(robot)
    assert bundle.friction == 0.2 and len(bundle.cycle([{"pull": 0.0}, {"pull": 1e-3}], steps=2)["leg"]) == 3


def test_friction_is_given_and_written(tmp_path: Path) -> None:
    plain = cppr.Robot.from_toml(ROOT / "robots/r1.toml")
    robot = cppr.Robot(plain.length, plain.tubes, "R1", friction=0.3, guide=0.01)
    assert (plain.friction, plain.guide) == (None, None) and "[friction]" not in plain.to_toml_text()
    again = cppr.Robot.from_toml_text(robot.to_toml_text())
    assert (again.friction, again.guide) == (0.3, 0.01)
    for wrong in (-0.1, float("nan")):
        with pytest.raises(ValueError, match="coefficient of friction"):
            cppr.Robot(plain.length, plain.tubes, friction=wrong)
    with pytest.raises(ValueError, match="give friction"):
        cppr.Robot(plain.length, plain.tubes, guide=0.01)
    with pytest.raises(ValueError, match="say how the tubes rub"):
        plain.solve(pull=1e-3).friction()
    with pytest.raises(cppr.RobotError, match="tubes jam"):
        cppr.Robot(plain.length, plain.tubes, friction=2.5).to_toml_text()


def test_it_is_swept_with_its_designs(tmp_path: Path) -> None:
    robot = ROOT / "robots/bundles/uncut_ends.toml"
    output = tmp_path / "ends.npz"
    depths = {"tube1.part2.notches.depth_mm": cppr.Range(1.5, 1.6, 2)}
    counts = cppr.sweep(robot, output, pull=cppr.Range(0.0, 1e-3, 3), vary=depths, limits="rigid")
    assert counts == {"converged": 6}
    table = np.load(output)
    eq = uncut_ends().solve(pull=1e-3)
    used = eq.limits().governing
    assert used is not None and used.limit == "strain"
    assert table["tip_y_m"][-1] == pytest.approx(eq.tip_position[1], abs=1e-8)
    assert table["strain_utilisation"][-1] == pytest.approx(used.utilisation, rel=1e-4)
    assert abs(table["tip_y_m"][2] - table["tip_y_m"][-1]) > 1e-5
    with pytest.raises(cppr.CommandError, match="no modes"):
        cppr.sweep(robot, output, pull=cppr.Range(0.0, 1e-3, 3), settings=cppr.Settings())


def test_a_sweep_knows_friction(tmp_path: Path) -> None:
    robot = ROOT / "robots/r1.toml"
    output = tmp_path / "rubbed.npz"
    cppr.sweep(robot, output, pull=cppr.Range(2e-3, 4e-3, 2), friction=0.2, guide=20e-3)
    table = np.load(output)
    loading, unloading = cppr.Robot.from_toml(robot).solve(pull=4e-3).friction(0.2, guide=20e-3)
    assert table["loading_tube2_tension_N"][-1] == pytest.approx(loading["tension"][1], rel=1e-4)
    assert table["unloading_tip_y_m"][-1] == pytest.approx(unloading["tip_position"][1], abs=1e-7)
    with pytest.raises(ValueError, match="coefficient of friction"):
        cppr.sweep(robot, output, pull=cppr.Range(2e-3, 4e-3, 2), friction=-0.2)


def test_tubes_press_on_each_other_and_rub() -> None:
    """R1 under 6 mm with a friction of 0.1: the forces of an independent program, from a robot and from its bundle."""
    path = ROOT / "robots/r1.toml"
    modal = cppr.Robot.from_toml(path).solve(6 * cppr.mm, settings=cppr.Settings(planar=True))
    eq = cppr.Bundle.from_toml(path).solve(pull=6 * cppr.mm)
    for own in (modal, eq):
        (pair,) = own.contact()
        assert (pair["outer"], pair["inner"]) == (1, 2) and pair["force"].shape == (len(pair["length"]), 3)
        # Constant curvature and tension: N K all along.
        assert np.allclose(np.linalg.norm(pair["force"], axis=1), 43.0317, rtol=1e-4)
        loading, unloading = own.friction(0.1)
        assert loading["tension"][1] == pytest.approx(4.775537, rel=1e-6)
        assert unloading["tension"][1] == pytest.approx(4.140580, rel=1e-6)
        assert own.friction(0.1, guide=0.02)[0]["tension"][1] > loading["tension"][1]
    with pytest.raises(ValueError, match="at least 0"):
        eq.friction(-0.1)


def test_superelastic_metal_unloads_along_a_lower_curve() -> None:
    wrist = cppr.Bundle.from_toml(ROOT / "robots/wrists/superelastic.toml")
    lower = wrist.unloading()
    assert lower is not None and lower.unloading() is None
    loading, unloading = (robot.solve(pull={2: 1e-3}) for robot in (wrist, lower))
    assert 0 < unloading.tension[1] < 0.6 * loading.tension[1]
    assert cppr.Bundle.from_toml(ROOT / "robots/wrists/wrist90.toml").unloading() is None
    kept = pickle.loads(pickle.dumps(wrist)).unloading()
    assert kept is not None and kept.solve(pull={2: 1e-3}).tension[1] == unloading.tension[1]


def test_gaps_are_estimated() -> None:
    path = ROOT / "robots/r1.toml"
    modal = cppr.Robot.from_toml(path).solve(6 * cppr.mm)
    eq = cppr.Bundle.from_toml(path).solve(pull=6 * cppr.mm)
    told = [own.clearance_estimate() for own in (modal, eq)]
    for own in told:
        (pair,) = own["pairs"]
        assert pair["gap"] == pytest.approx(0.5e-3) and pair["touches"]
        assert 0.4e-3 < pair["offset"] < 0.5e-3 and 0.01 < pair["layer"] < 0.04
        assert own["pull"][1] == pytest.approx(6e-3, abs=5e-6)
        assert own["tension"][1] < 0.9 * eq.tension[1] and np.isnan(own["backlash"][0])
    assert np.allclose(told[0]["tip_position"], told[1]["tip_position"], atol=1e-7)
    assert eq.clearance_estimate(gap=0.0)["pairs"] == []
    with pytest.raises(ValueError, match="at least 0"):
        eq.clearance_estimate(gap=-1e-3)
    solved = modal.with_clearance()
    (pair,) = solved["pairs"]
    assert pair["mean_offset"] == pytest.approx(told[0]["pairs"][0]["offset"], rel=0.05)
    assert solved["tension"] == pytest.approx(told[0]["tension"][1:], rel=0.01) and solved["error"][0] < 1e-5
    assert np.allclose(solved["centres"][-1], solved["tip_position"]) and pair["offset"].shape == (*solved["labels"].shape, 2)
    ((start, end, angles, force),) = pair["zones"]
    assert 0.02 < start < end < 0.13 and np.allclose(np.cos(angles), -1)
    assert force == pytest.approx(np.trapezoid(np.linalg.norm(pair["force"], axis=1), solved["labels"]), rel=0.02)
    loose = modal.with_clearance(guide=(20 * cppr.mm, 0.5 * cppr.mm), elements=60)
    assert loose["labels"][0] == pytest.approx(-20e-3) and loose["tension"][0] < solved["tension"][0]
    with pytest.raises(ValueError, match="length of at least 0"):
        modal.with_clearance(guide=(20 * cppr.mm, -1.0))
    spatial = cppr.Robot.from_toml(ROOT / "robots/helicoid.toml").solve(pull=5 * cppr.mm).with_clearance(elements=60)
    (pair,) = spatial["pairs"]
    frames = spatial["frames"]
    assert np.allclose(np.einsum("nij,nik->njk", frames, frames), np.eye(3), atol=1e-9) and np.allclose(np.linalg.det(frames), 1)
    steps = np.diff(spatial["centres"], axis=0)
    assert np.allclose(np.einsum("ni,ni->n", steps, frames[:-1, :, 0]), np.linalg.norm(steps, axis=1), rtol=2e-2)
    assert np.ptp(np.unwrap(np.arctan2(*pair["offset"][20:-20].T[::-1]))) > 1, "the notches wind about the axis, and so does what lies on the wall"


def test_bundles_are_solved_with_gaps() -> None:
    same = [robot.solve(pull=6 * cppr.mm).with_clearance(elements=40) for robot in (cppr.Robot.from_toml(ROOT / "robots/r1.toml"), cppr.Bundle.from_toml(ROOT / "robots/r1.toml"))]
    assert np.allclose(same[0]["tip_position"], same[1]["tip_position"], atol=1e-6)
    eq = cppr.Bundle.from_toml(ROOT / "robots/bundles/two_curved.toml").solve(rotate={2: 1.0})
    loose = eq.with_clearance(elements=40)
    (pair,) = loose["pairs"]
    assert np.all(np.linalg.norm(pair["offset"], axis=1) <= 0.05e-3 * (1 + 1e-6)) and pair["zones"]
    assert loose["leader"]["torque"] == pytest.approx(-loose["torque"][0], rel=1e-3), "no load: the torques of the plate balance"
    telescope = cppr.Bundle.from_toml(ROOT / "robots/bundles/concentric3.toml").solve().with_clearance(elements=40)
    assert np.isnan(telescope["pairs"][0]["offset"][-1]).all() and np.isfinite(telescope["pairs"][1]["mean_offset"])
    wrist = cppr.Bundle.from_toml(ROOT / "robots/wrists/superelastic.toml").solve(pull={2: 0.2e-3})
    with pytest.raises(ValueError, match="linear tubes alone"):
        wrist.with_clearance(gap=0.05e-3)


def test_a_cycle_comes_back_to_its_loop() -> None:
    robot = cppr.Bundle.from_toml(ROOT / "robots/r1.toml")
    path = [{"pull": x * cppr.mm} for x in (0, 3, 0, 3)]
    found = robot.cycle(path, 0.1, steps=3)
    assert found["leg"] == [0, 1, 1, 1, 2, 2, 2, 3, 3, 3] and found["tip_position"].shape == (10, 3)
    up, down, again = (found["tension"][i, 1] for i in (2, 4, 8))
    assert up > 1.02 * down and again == pytest.approx(up, rel=1e-4)
    with pytest.raises(ValueError, match="it has no push"):
        robot.cycle([{"pull": 0}, {"push": 1e-3}], 0.1)


def test_sudden_changes_are_said_with_the_line_that_follows_them(tmp_path: Path) -> None:
    """The right tip is that of `answers_say_how_accurate_they_are` among the tests of the program."""
    steps = "crates/cppr-cli/tests/data/steps_in_a_table.toml"
    right = [88.599e-3, -50.173e-3, 0.0]
    said = r"notch depth of tube 1 at 30 mm.*cppr\.Bundle\.of\(robot\).*cppr\.Bundle\.from_toml"
    with pytest.warns(cppr.AccuracyWarning, match=said):
        robot = cppr.Robot.from_toml(steps)
    with pytest.warns(cppr.AccuracyWarning, match=said):
        cppr.Robot.from_toml_text(Path(steps).read_text())
    with pytest.warns(cppr.AccuracyWarning, match="notch depth of tube 2"):
        cppr.Robot(robot.length, robot.tubes)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for bundle in (cppr.Bundle.of(robot), cppr.Bundle.from_toml(steps)):
            eq = bundle.solve(pull=2e-3)
            assert eq.tip_position == pytest.approx(right, abs=1e-5)
            assert eq.tension[1] == pytest.approx(1.8538, abs=1e-3)
        pickle.loads(pickle.dumps(robot))
        cppr.Robot.from_toml("robots/r1.toml")

    def swept(**options: Any) -> dict[str, str]:
        """The last row."""
        path = tmp_path / "steps.csv"
        cppr.sweep(steps, path, pull=cppr.Range(0.0, 2e-3, 3), **options)
        _, *table = path.read_text().splitlines()  # The first line says what was asked.
        *_, last = csv.DictReader(table)
        path.unlink()
        return last

    with pytest.warns(cppr.AccuracyWarning, match="the sweep integrates"):
        integrated = swept()
    assert [float(integrated[f"tip_{axis}_m"]) for axis in "xyz"] == pytest.approx(right, abs=1e-5)
    assert "tube1_tension_N" in integrated
    with pytest.warns(cppr.AccuracyWarning) as told:
        modes = swept(margin=True)
    assert not any("the sweep integrates" in str(one.message) for one in told)
    assert "tube1_tension_N" not in modes and 0 < float(modes["margin_to_instability"]) < 1


def test_a_loop_has_a_tolerance() -> None:
    robot = uncut_ends()
    eq = robot.solve(pull=1e-3)

    def loop(tolerance: float) -> cppr.BundleEquilibrium:
        own = eq
        for pull in 1e-3 + 2e-5 * np.arange(1, 11):
            own = robot.solve(pull=pull, start=own, loop_tolerance=tolerance)
        return own

    fine, coarse = loop(1e-8), loop(1e-5)
    whole = robot.solve(pull=1.2e-3)
    assert np.linalg.norm(fine.tip_position - whole.tip_position) < 1e-6 * robot.length
    assert 0 < np.linalg.norm(coarse.tip_position - fine.tip_position) < 1e-4 * robot.length
    with pytest.raises(ValueError, match="give start"):
        robot.solve(pull=1e-3, loop_tolerance=1e-6)
    for wrong in (0.0, 1e-3, float("nan")):
        with pytest.raises(ValueError, match="at most 1e-4"):
            robot.solve(pull=1e-3, start=eq, loop_tolerance=wrong)
