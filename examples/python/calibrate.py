# %% [markdown]
# Calibrate the prototypes R1 and R2 from measured tip positions: one centroid offset factor and one Young's modulus for
# both. Run it from the root of the repository: `python examples/python/calibrate.py`.

# %%
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import cppr

robots = [cppr.Robot.from_toml(f"robots/{name}.toml") for name in ("r1", "r2")]
data = pd.read_csv("examples/calibration/measured.csv")
print(data.groupby("robot").size().to_dict(), "measured points")

# %%
fit = cppr.calibrate(robots, data, ["centroid_offset_factor", "youngs_modulus"])
print(fit)
outliers = [residual for residual in fit.residuals if residual.outlier]
print(f"correlation {fit.correlation[0, 1]:+.2f}; {len(outliers)} outliers")

# %% [markdown]
# Motions of an unloaded robot do not show a common modulus (Remark 19 of the paper). It is refused, not guessed.

# %%
unloaded = data[data.tip_force_y_N == 0]
try:
    cppr.calibrate(robots, unloaded, ["centroid_offset_factor", "youngs_modulus"])
except cppr.CalibrationError as problem:
    print("without loads:", str(problem).split(":")[0])

# %% [markdown]
# Before and after: how far the computed tips lie from the measured ones.

# %%
figure, axes = plt.subplots(1, 2, figsize=(9, 4), sharey=True, layout="constrained")
for ax, before, after in zip(axes, robots, fit.robots):
    own = data[data.robot == before.name]
    pull = own.pull2_mm.to_numpy()
    force = np.zeros((len(own), 3))
    force[:, 1] = own.tip_force_y_N
    for robot, marker, label in ((before, "kx", "as designed"), (after, "ko", "calibrated")):
        many = robot.solve_many(pull=pull * 1e-3, tip_force=force)
        gap = many.tip_position * 1e3 - own[["x_mm", "y_mm", "z_mm"]]
        distance = np.linalg.norm(gap, axis=1)
        print(f"{before.name} {label}: rms distance {np.sqrt(np.mean(distance**2)):.3f} mm")
        ax.plot(pull, distance, marker, fillstyle="none", label=label)
    ax.set(xlabel="pull (mm)", title=before.name)
axes[0].set_ylabel("distance to the measured tip (mm)")
axes[0].legend()
figure.savefig("calibrate.png", dpi=150)
