# %% [markdown]
# A controller at 1 kHz with an observer in the loop. The tip is to follow a curve in space; meanwhile somebody leans on it with a force that nobody
# measures. In every cycle the controller reads tension, torque and a tip tracker, **senses** what force its model lacks, and **steps** towards
# the next point of the curve. Run it from the root of the repository: `python examples/python/control_loop.py`.

# %%
import gc
import time

import matplotlib.pyplot as plt
import numpy as np

import cppr

RATE = 1000.0  # Hz
PERIOD = 1.0  # s for one turn of the curve
TENSION_NOISE, TORQUE_NOISE, TIP_NOISE = 0.01, 1e-4, 1e-4  # N, N m, m: load cells and an electromagnetic tracker
SMOOTHING = 0.05  # of the sensed force, per cycle

robot = cppr.Robot.from_toml("robots/r1.toml")
random = np.random.default_rng(1)
steps = int(PERIOD * RATE)
at = np.arange(steps) / RATE
turn = 2 * np.pi * at / PERIOD

# %% [markdown]
# The curve: where the tip goes, without a force, while the follower is pulled and turned. From 0.3 s on somebody leans on the tip.

# %%
pulls, turns = 3e-3 + 1e-3 * np.cos(turn), 0.5 * np.sin(turn)
wanted = robot.solve_many(pull=pulls, rotate=turns).tip_position
pushed = np.where(at < 0.3, 0.0, 0.05)[:, None] * np.array([0.0, 0.6, -0.8])  # N

# %% [markdown]
# One turn, paced by the clock. The simulated robot and its noise take their part of the cycle too, but only the controller is timed: from the readings to
# the new motor values.

# %%
pull, rotate = pulls[0], turns[0]
body = model = robot.solve(pull=pull, rotate=rotate)
force = np.zeros(3)
cost, late, tips, sensed = np.zeros(steps), np.zeros(steps), np.zeros((steps, 3)), np.zeros((steps, 3))
gc.disable()  # a collection in mid-cycle would be a late cycle
begin = time.perf_counter() + 0.01
for k in range(steps):
    tick = begin + k / RATE
    while (now := time.perf_counter()) < tick:
        if tick - now > 3e-4:  # asleep for most of the wait, awake for its end
            time.sleep(tick - now - 2e-4)
    late[k] = now - tick
    body = robot.solve(pull=pull, rotate=rotate, tip_force=pushed[k], start=body)
    tension = body.tension[0] + TENSION_NOISE * random.standard_normal()
    torque = body.torque[0] + TORQUE_NOISE * random.standard_normal()
    tip = body.tip_position + TIP_NOISE * random.standard_normal(3)

    start = time.perf_counter()
    model = robot.solve(pull=pull, rotate=rotate, tip_force=force, start=model)
    lacks = model.sense(
        tension=tension,
        torque=torque,
        position=tip,
        tension_deviation=TENSION_NOISE,
        torque_deviation=TORQUE_NOISE,
        position_deviation=TIP_NOISE,
    )
    force = force + SMOOTHING * lacks.force
    step = np.linalg.lstsq(model.jacobian[:3], wanted[(k + 1) % steps] - model.tip_position, rcond=None)[0]
    pull, rotate = pull + step[0], rotate + step[1]
    cost[k] = time.perf_counter() - start
    tips[k], sensed[k] = body.tip_position, force
gc.enable()

# %% [markdown]
# With two actuators the tip moves in a surface, which the force shifts: the curve is out of reach then, and its distance from the surface is left.

# %%
settled = at > 0.5
off, left, near = np.zeros(steps), np.zeros(steps), []
for k in range(steps - steps // 2, steps, 10):
    pressed = robot.solve(pull=pulls[k], rotate=turns[k], tip_force=pushed[k])
    start = time.perf_counter()
    best = pressed.reach(position=wanted[k], near=True)
    near.append(time.perf_counter() - start)
    off[k], left[k] = np.linalg.norm(tips[k] - best.equilibrium.tip_position), best.distance
print(f"tip at most {1e3 * off.max():.3f} mm from the nearest place it can go to, once the force is known")
print(f"which is up to {1e3 * left.max():.3f} mm from the curve; found from the pose that is known in {1e3 * np.median(near):.3f} ms")
error = np.linalg.norm((sensed - pushed)[settled].mean(axis=0))
print(f"force sensed to {error:.4f} N (standard deviation {sensed[settled].std(axis=0).max():.4f} N)")
worst = np.quantile(cost, 0.99)
print(f"controller: {1e3 * np.median(cost):.3f} ms median, {1e3 * worst:.3f} ms in 99 of 100 cycles, {1e3 * cost.max():.3f} ms at most")
print(f"cycles begin late by {1e6 * np.median(late):.1f} us median, {1e6 * np.quantile(late, 0.99):.1f} us in 99 of 100")
print(f"cycles of {1e3 / RATE:.0f} ms that were missed: {np.count_nonzero(late > 1 / RATE)} of {steps}")

figure, (way, times) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
for i, (axis, line) in enumerate(zip("xyz", ("-", "--", ":"))):
    way.plot(1e3 * at, 1e3 * sensed[:, i], f"k{line}", lw=1, label=f"sensed, {axis}")
    way.plot(1e3 * at, 1e3 * pushed[:, i], color="0.6", ls=line, lw=2)
way.set(xlabel="time (ms)", ylabel="force on the tip (mN), true in grey")
way.legend(loc="center right", bbox_to_anchor=(1.0, 0.75))
times.hist(1e3 * cost, bins=np.linspace(0, 1.2 * 1e3 * worst, 40), color="0.5")
times.axvline(1e3 / RATE, color="k", ls="--", label="one cycle")
times.set(xlabel="time of the controller (ms)", ylabel="cycles")
times.legend()
figure.savefig("control_loop.png", dpi=150)
