# %% [markdown]
# Design a notch profile for a wanted curve: pulled by 6 mm, the robot is to bend in its outer half only. Five depths of
# the leader's notches are the unknowns, scipy.optimize does the search. Run it from the root of the repository:
# `python examples/python/notch_design.py`.

# %%
import dataclasses

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import least_squares

import cppr

PULL = 6e-3  # m
start = cppr.Robot.from_toml("robots/r3.toml")
leader, follower = start.tubes
x = np.linspace(0, start.length, 40)

# %% [markdown]
# The wanted curve in the plane: curvature rises from nothing to its full value around the middle.

# %%
curvature = -11.0 / (1 + np.exp(-(x - 0.075) / 0.012))
angle = np.concatenate([[0], np.cumsum(0.5 * np.diff(x) * (curvature[1:] + curvature[:-1]))])
steps = np.diff(x)[:, None] * 0.5 * (
    np.stack([np.cos(angle), np.sin(angle)], axis=1)[1:] + np.stack([np.cos(angle), np.sin(angle)], axis=1)[:-1]
)
wanted = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])


def robot_of(depths: np.ndarray) -> cppr.Robot:
    """The robot whose leader has these notch depths (m) at equal steps from base to tip."""
    return cppr.Robot(start.length, [dataclasses.replace(leader, depth=depths), follower], name="designed")


def distance(depths: np.ndarray) -> np.ndarray:
    """Between centreline and wanted curve (mm)."""
    shape = robot_of(depths).solve(pull=PULL).sample(x)
    return ((shape.centre[:, :2] - wanted) * 1e3).ravel()


# %% [markdown]
# Shallow notches (5.5 mm leave 3.5 mm of the tube) are stiff and hardly off centre, deep ones bend. The torsion constant,
# costly and idle in the plane, is left to the paper's formula meanwhile.

# %%
leader = dataclasses.replace(leader, torsion="polar")
first = np.full(5, 7.7e-3)
found = least_squares(distance, first, bounds=(4e-3, 8.4e-3), x_scale=1e-3, diff_step=1e-4)
print("depths (mm):", np.round(found.x * 1e3, 2), f"after {found.nfev} evaluations")
for name, depths in (("start", first), ("designed", found.x)):
    rms = np.sqrt(np.mean(np.sum(distance(depths).reshape(-1, 2) ** 2, axis=1)))
    print(f"{name}: rms distance to the wanted curve {rms:.2f} mm")

# %%
figure, ax = plt.subplots(layout="constrained")
ax.plot(*wanted.T * 1e3, "0.7", lw=4, label="wanted")
for name, depths, dashes in (("start", first, "k:"), ("designed", found.x, "k-")):
    ax.plot(*robot_of(depths).solve(pull=PULL).sample(x).centre[:, :2].T * 1e3, dashes, label=name)
ax.set(xlabel="x (mm)", ylabel="y (mm)", aspect="equal")
ax.legend()
figure.savefig("notch_design.png", dpi=150)
