"""Equilibria: commands, derivatives, fields."""

from __future__ import annotations

import math
import threading

import numpy as np
import pytest
from conftest import uniform

import cppr


def test_numbers_for_tube_2_and_dicts_for_others(three: cppr.Robot) -> None:
    assert three.followers == (2, 3)
    bare = three.solve(pull=5e-4)
    named = three.solve(pull={2: 5e-4, 3: 0.0})
    assert (bare.tip_position == named.tip_position).all()
    assert three.solve(pull={3: 5e-4}).pull.tolist() == pytest.approx([0.0, 5e-4], abs=1e-12)


def test_motion_and_force_are_two_sides_of_one_equilibrium(r3: cppr.Robot) -> None:
    eq = r3.solve(pull=4e-3, rotate=0.3)
    back = r3.solve(tension=eq.tension[0], torque=eq.torque[0])
    assert back.pull[0] == pytest.approx(4e-3, abs=1e-9)
    assert back.rotation[0] == pytest.approx(0.3, abs=1e-7)
    assert np.abs(back.tip_position - eq.tip_position).max() < 1e-8
    assert back.inputs == (("tension", 2), ("torque", 2))


def test_jacobian_compliance_and_response_are_derivatives(three: cppr.Robot) -> None:
    force = np.array([0.0, 0.02, 0.03])
    command = {"pull": {2: 4e-4, 3: -2e-4}, "rotate": {2: 0.2}}
    eq = three.solve(**command, tip_force=force)
    assert eq.inputs == (("pull", 2), ("rotate", 2), ("pull", 3), ("rotate", 3))
    h = 1e-6
    for column, (means, tube) in enumerate(eq.inputs):
        ends = []
        for step in (h, -h):
            moved = {k: dict(v) for k, v in command.items()}
            moved[means][tube] = moved[means].get(tube, 0.0) + step
            ends.append(three.solve(**moved, tip_force=force))
        slope = (ends[0].tip_position - ends[1].tip_position) / (2 * h)
        assert np.allclose(eq.jacobian[:3, column], slope, rtol=1e-5, atol=1e-7)
        assert np.abs(slope).max() > 1e-4
        spin = (ends[0].tip_rotation - ends[1].tip_rotation) / (2 * h) @ eq.tip_rotation.T
        assert np.allclose(eq.jacobian[3:, column], [spin[2, 1], spin[0, 2], spin[1, 0]], atol=1e-4, rtol=1e-5)
        tension = (ends[0].tension - ends[1].tension) / (2 * h)
        assert np.allclose(eq.response[::2, column], tension, rtol=1e-4, atol=1e-6)
    for axis in range(3):
        ends = [three.solve(**command, tip_force=force + s * 1e-5 * np.eye(3)[axis]) for s in (1, -1)]
        slope = (ends[0].tip_position - ends[1].tip_position) / 2e-5
        assert np.allclose(eq.compliance[:3, axis], slope, rtol=1e-5, atol=1e-9)
        tension = (ends[0].tension - ends[1].tension) / 2e-5
        assert np.allclose(eq.response_by_wrench[::2, axis], tension, rtol=1e-4, atol=1e-5)
    turn = eq.tip_rotation.T
    assert np.allclose(eq.jacobian_body[:3], turn @ eq.jacobian[:3])
    assert np.allclose(eq.compliance, eq.compliance.T, atol=1e-9)


def test_every_field_has_its_shape(three: cppr.Robot) -> None:
    eq = three.solve(pull=5e-4, tip_force=(0, 0, 0.05))
    shapes = {
        "x": (11,), "centre": (11, 3), "rotation": (11, 3, 3), "curvature": (11, 3), "angles": (11, 2),
        "energy_density": (11,), "abscissa": (11, 3), "centroid": (11, 3, 3), "tube_rotation": (11, 3, 3, 3),
        "rate": (11, 3), "strain": (11, 3, 3), "stretch": (11, 3), "moment": (11, 3, 3), "force": (11, 3, 3),
    }  # fmt: skip
    shape = eq.sample(11)
    for name, wanted in shapes.items():
        values = getattr(shape, name)
        assert values.shape == wanted and values.dtype == np.float64 and np.isfinite(values).all(), name
    # Rotations by their columns: the first is the tangent.
    step = np.diff(eq.sample([0.0149, 0.0151]).centre, axis=0)[0]
    tangent = eq.sample([0.015]).rotation[0, :, 0]
    assert np.allclose(step / np.linalg.norm(step), tangent, atol=1e-5)
    assert np.allclose(shape.centre[-1], eq.tip_position) and np.allclose(shape.rotation[-1], eq.tip_rotation)
    # The tubes' axial and shear forces at the tip balance the tip force.
    total = np.einsum("tij,tj->i", shape.tube_rotation[-1], shape.force[-1])
    assert np.allclose(total, [0, 0, 0.05], atol=1e-3)


def test_a_lone_leader_is_a_rod() -> None:
    tube = cppr.StiffnessTube(0.0, 0.01, 0.01, 0.01, math.pi)
    rod = cppr.Robot(0.2, [tube])
    eq = rod.solve(tip_moment=(0, 0, 0.01))
    assert np.allclose(eq.shape.curvature[:, 2], 1.0, atol=1e-9)
    assert eq.pull.shape == (0,) and eq.jacobian.shape == (6, 0) and eq.shape.angles.shape == (101, 0)
    assert rod.solve_many(tip_force=np.zeros((4, 3))).pull.shape == (4, 0)


def test_loads_come_back_as_given(r3: cppr.Robot) -> None:
    loads = (
        cppr.Wrench(force=(0.0, 0.1, 0.0), at=0.06),
        cppr.Wrench(moment=(0.0, 0.0, 1e-3), frame="section"),
        cppr.DistributedForce((0.0, -1.0, 0.0), 0.0, 0.1),
        cppr.Gravity((0.0, -9.81, 0.0)),
        cppr.Thread(0.1, (0.15, -0.1, 0.0), radius=4e-3, side="right"),
    )
    eq = r3.solve(pull=2e-3, loads=loads)
    assert eq.loads == loads
    assert abs(eq.tip_position[1] - r3.solve(pull=2e-3).tip_position[1]) > 1e-4


def test_settings_change_what_is_solved() -> None:
    robot = uniform()
    rigid = robot.solve(pull=2e-3, tip_force=(5, 0, 0))
    soft = robot.solve(pull=2e-3, tip_force=(5, 0, 0), settings=cppr.Settings(stretch=True))
    assert np.abs(soft.shape.stretch[:, 0]).max() > 1e-6 and not rigid.shape.stretch.any()
    plane = robot.solve(pull=2e-3, settings=cppr.Settings(planar=True))
    assert np.abs(plane.tip_position - robot.solve(pull=2e-3).tip_position).max() < 1e-10
    r4 = cppr.Robot.from_toml("robots/r4.toml")
    printed = r4.solve(pull=11e-3, settings=cppr.Settings(planar=True, formulation="printed"))
    assert printed.tension[0] == pytest.approx(3.777, abs=1e-3) and math.isnan(printed.margin)


def test_a_start_saves_steps(r3: cppr.Robot) -> None:
    eq = r3.solve(pull=10e-3)
    near = r3.solve(pull=10.01e-3, start=eq)
    cold = r3.solve(pull=10.01e-3)
    assert near.iterations < cold.iterations
    assert np.abs(near.tip_position - cold.tip_position).max() < 1e-10
    with pytest.raises(ValueError, match="another robot"):
        uniform().solve(start=eq)


def test_two_threads_solve_at_the_same_time(r3: cppr.Robot) -> None:
    pulls = np.linspace(-8e-3, 8e-3, 60)
    wanted = [r3.solve(pull=p).tip_position for p in pulls]
    found: dict[int, list[np.ndarray]] = {}

    def work(number: int) -> None:
        found[number] = [r3.solve(pull=p).tip_position for p in pulls]

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all((np.array(found[i]) == wanted).all() for i in range(4))


def test_accuracy_is_told_and_adapts(r3: cppr.Robot) -> None:
    found = r3.solve(pull=4e-3)
    own = found.accuracy
    assert own is not None and own["against"] == "integration"
    assert 0 <= own["tip"] < 1e-4 * r3.length
    # Beyond what four times as many modes reach.
    with pytest.warns(cppr.AccuracyWarning, match="of the length only"):
        r3.solve(pull=4e-3, accuracy=1e-15)
    finer = r3.solve(pull=4e-3, accuracy=1e-8)
    assert finer.accuracy is not None and finer.accuracy["tip"] <= own["tip"]
    assert np.linalg.norm(found.tip_position - own["reference_tip"]) == pytest.approx(own["tip"])
    bare = r3.solve(pull=4e-3, accuracy=None).accuracy
    assert bare is not None and bare["tip"] == pytest.approx(own["tip"], rel=1e-3)
    for wrong in (0.0, -1.0, 2.0, float("nan")):
        with pytest.raises(ValueError, match="part of the robot's length"):
            r3.solve(pull=4e-3, accuracy=wrong)


def test_few_modes_for_a_loop(r3: cppr.Robot) -> None:
    ends = [{"pull": 0.0}, {"pull": 4e-3, "tip_force": (0.0, 0.0, 0.02)}]
    few = r3.fewest_modes(ends, accuracy=1e-2)
    assert few.refine < 1 < r3.fewest_modes(ends, accuracy=1e-9).refine
    usual, coarse = (r3.solve(**ends[1], settings=own, accuracy=None) for own in (None, few))
    assert 0 < np.linalg.norm(usual.tip_position - coarse.tip_position) < 1e-2 * r3.length
    kept = r3.fewest_modes(ends, settings=cppr.Settings(stretch=True, refine=4))
    assert kept.stretch and kept.refine <= 1
    for wrong, error, said in [
        ({"accuracy": 0.0}, ValueError, "above 0"),
        ({"settings": cppr.Settings(formulation="printed")}, cppr.NoEquilibrium, "printed"),
    ]:
        with pytest.raises(error, match=said):
            r3.fewest_modes(ends, **wrong)
    with pytest.raises(ValueError, match="it has no push"):
        r3.fewest_modes([{"push": 1e-3}])
    with pytest.raises(cppr.CommandError):
        r3.fewest_modes([{"pull": float("nan")}])
