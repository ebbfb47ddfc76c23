"""Figures, tables, the interactive page."""

from __future__ import annotations

import html
import json
import re
from pathlib import Path

import matplotlib
import numpy as np
import pytest

import cppr

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


@pytest.fixture
def loaded(three: cppr.Robot) -> cppr.Equilibrium:
    loads = [cppr.Wrench((0, 0, -0.5)), cppr.DistributedForce((0, 0, -1), 0.005, 0.02)]
    return three.solve(pull={2: 1e-3, 3: -5e-4}, rotate=0.5, loads=loads)


def test_a_planar_robot_is_drawn_in_its_plane(r3: cppr.Robot) -> None:
    eq = r3.solve(pull=5e-3, loads=[cppr.Thread(0.1, (0.15, -0.2, 0)), cppr.Gravity((0, -9.81, 0))])
    ax = eq.plot()
    assert ax.name == "rectilinear" and ax.get_xlabel() == "x (mm)" and ax.get_aspect() == 1.0
    leader = ax.lines[0].get_xydata()
    assert np.allclose(leader, eq.shape.centroid[:, 0, :2] * 1e3)
    texts = [t.get_text().strip() for t in ax.texts]
    assert "0.1 N" in texts and "9.81 m/s²" in texts
    labels = [t.get_text() for t in ax.get_legend().get_texts()]
    assert labels == ["tube 1 (leader)", "tube 2", "centre"]
    plt.close("all")


def test_a_robot_out_of_plane_is_drawn_in_space(loaded: cppr.Equilibrium) -> None:
    ax = loaded.plot()
    assert ax.name == "3d" and ax.get_zlabel() == "z (mm)"
    with pytest.raises(ValueError, match='projection="3d"'):
        loaded.plot(plt.figure().add_subplot())
    with pytest.raises(ValueError, match='"auto", "2d" or "3d"'):
        loaded.plot(view="side")
    flat = loaded.plot(view="2d")
    assert flat.name == "rectilinear"
    plt.close("all")


def test_the_page_needs_nothing_else(loaded: cppr.Equilibrium, tmp_path: Path) -> None:
    view = loaded.show()
    assert not re.search(r"https?://|src=|import ", view.page)
    data = json.loads(re.search(r"const data = (.*);\n", view.page).group(1))
    assert len(data["tubes"]) == 3 and len(data["loads"]) == 8
    assert np.allclose(data["centre"][-1], loaded.tip_position, atol=1e-6)
    view.save(tmp_path / "view.html")
    assert (tmp_path / "view.html").read_text() == view.page and len(view.page) < 200_000
    assert html.escape(view.page[:40], quote=True) in view._repr_html_()


def test_a_name_cannot_end_the_script(r3: cppr.Robot) -> None:
    robot = cppr.Robot(r3.length, r3.tubes, name="</script><b>")
    assert "</script><b>" not in robot.solve().show().page


def test_the_page_shows_what_notches_leave(r3: cppr.Robot) -> None:
    page = r3.solve(pull=-20e-3).show().page
    leader, follower = (
        np.array(t) for t in json.loads(re.search(r"const data = (.*);\n", page).group(1))["tubes"]
    )
    width = np.linalg.norm(follower[:, 0] - follower[:, -1], axis=-1)
    # Whole where the uncut part has come up, 20 mm, and open at both ends of every notch beyond: all 15, since the tips are joined.
    cut = np.flatnonzero(width > 1e-3)
    assert len(cut) == 2 * 15 and np.all(width[: cut[0]] < 1e-9)
    assert 20e-3 < follower[cut[0], :, 0].mean() < 26e-3
    # Teeth between them are whole.
    assert np.count_nonzero(np.linalg.norm(leader[:, 0] - leader[:, -1], axis=-1) > 1e-3) == 2 * 15


def test_tables(loaded: cppr.Equilibrium) -> None:
    frame = loaded.to_dataframe(sections=5)
    assert len(frame) == 15 and frame.tube.tolist()[:4] == [1, 2, 3, 1]
    assert not frame.isna().any().any()
    shape = loaded.sample(5)
    assert np.allclose(frame.moment_z_Nm, shape.moment[:, :, 2].ravel())
    assert np.allclose(frame.centre_y_m[frame.tube == 3], shape.centre[:, 1])
    data = loaded.to_xarray(sections=5)
    assert data.force.attrs["units"] == "N" and data.attrs["robot"] == "Childs3"
    assert np.allclose(data.centroid.sel(tube=2, axis="z"), shape.centroid[:, 1, 2])
    assert set(data.data_vars) == {n for n in dir(shape) if not n.startswith("_")} - {"x"}
