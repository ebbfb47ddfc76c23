# %% [markdown]
# Closed-loop tracking of a circle with the tip. The controller knows a model, the "real" robot differs from it: its tubes are
# a fifth stiffer or softer and a force that nobody told the controller pulls at its tip. Run it from the root of the
# repository: `python examples/python/tip_tracking.py`.

# %%
import dataclasses
import time

import matplotlib.pyplot as plt
import numpy as np

import cppr

RATE = 200.0  # Hz
PERIOD = 2.0  # s for one turn of the circle
RADIUS = 5e-3  # m
GAIN = 20.0  # 1/s

model = cppr.Robot.from_toml("robots/childs3.toml")
changed = [
    dataclasses.replace(tube, bending_z=factor * tube.bending_z)
    for tube, factor in zip(model.tubes, (1.2, 0.8, 1.2))
]
real = cppr.Robot(model.length, changed, name="real")
disturbance = (0.0, 0.02, -0.03)  # N

# %% [markdown]
# In every cycle the controller measures the tip, solves its model where the motors stand, starting at the last equilibrium,
# and turns the error into motor speeds with the Jacobian of the two translations (resolved rates). Its part of the
# cycle is timed; the simulated robot's is not.

# %%
steps = int(PERIOD * RATE)
dt = 1.0 / RATE
phase = 2 * np.pi * np.arange(steps) / steps
wanted = RADIUS * np.stack([np.cos(phase), np.sin(phase)], axis=1)
speed = np.gradient(wanted, dt, axis=0)

motors = np.zeros(2)
eq = model.solve()
body = real.solve(tip_force=disturbance)
cost, path, moved = [], [], []
for k in range(steps):
    body = real.solve(pull={2: motors[0], 3: motors[1]}, tip_force=disturbance, start=body)
    tip = body.tip_position[1:]
    start = time.perf_counter()
    eq = model.solve(pull={2: motors[0], 3: motors[1]}, start=eq)
    jacobian = eq.jacobian[1:3, ::2]  # y and z of the tip by the two translations
    motors = motors + dt * np.linalg.solve(jacobian, speed[k] + GAIN * (wanted[k] - tip))
    cost.append(time.perf_counter() - start)
    path.append(tip)
    moved.append(motors)

# %%
error = np.linalg.norm(np.array(path) - wanted, axis=1)
settled = error[steps // 4 :]
print(f"tracking at {RATE:.0f} Hz: error {1e3 * settled.max():.3f} mm at most after a quarter turn")
print(f"the controller takes {1e6 * np.median(cost):.0f} us per cycle: up to {1 / np.median(cost):.0f} Hz")
print(f"late cycles: {np.mean(np.array(cost) > dt):.1%}")

figure, ax = plt.subplots(layout="constrained")
ax.plot(*wanted.T * 1e3, "0.6", label="wanted")
ax.plot(*np.array(path).T * 1e3, "k--", label="tip")
ax.set(xlabel="y (mm)", ylabel="z (mm)", aspect="equal")
ax.legend()
figure.savefig("tip_tracking.png", dpi=150)
