# %% [markdown]
# From a first robot to its shape. Run it from the root of the repository: `python examples/python/first_robot.py`.
# Editors that know cells (`# %%`) run it step by step.

# %%
import math

import matplotlib.pyplot as plt
import numpy as np

import cppr

# %% [markdown]
# Two printed tubes of 150 mm. The notches of the leader open towards -Y (pi), those of the follower towards +Y (0), so that
# their centroids lie on opposite sides: pulling the follower bends the robot. All numbers are SI.

# %%
pla = cppr.Material(youngs_modulus=5.39e9, poissons_ratio=0.35, density=1240)
leader = cppr.NotchedTube(
    outer_radius=4.5e-3,
    inner_radius=3.7e-3,
    depth=(8.2e-3, 7.2e-3),  # base and tip, linear between
    opening=math.pi,
    material=pla,
)
follower = cppr.NotchedTube(
    outer_radius=3.2e-3,
    inner_radius=2.4e-3,
    depth=(5.6e-3, 4.95e-3),
    opening=0.0,
    material=pla,
)
robot = cppr.Robot(0.150, [leader, follower], name="first")

# %% [markdown]
# Pull the follower by 5 mm. One solve gives shape, force and stability.

# %%
eq = robot.solve(pull=5 * cppr.mm)
print(eq)
print(f"bent by {math.degrees(math.acos(eq.tip_rotation[0, 0])):.1f} degrees")
print(f"pulled with {eq.tension[0]:.3f} N; margin to instability {eq.margin:.2f}")

# %% [markdown]
# Turn it, load it, look at it in space; in a notebook `eq.show()` alone shows a view that turns with the mouse.

# %%
eq = robot.solve(pull=5 * cppr.mm, rotate=20 * cppr.deg, tip_force=(0, 0, 0.05))
eq.plot()
eq.show().save("first_robot.html")
plt.savefig("first_robot.png", dpi=150)

# %% [markdown]
# A whole range at once: the tip's path and the force while the follower is pushed and pulled.

# %%
pull = np.linspace(-8e-3, 8e-3, 161)
many = robot.solve_many(pull=pull)
figure, (left, right) = plt.subplots(1, 2, figsize=(8, 4), width_ratios=(1, 2), layout="constrained")
left.plot(*many.tip_position[:, :2].T * 1e3)
left.set(xlabel="tip x (mm)", ylabel="tip y (mm)", aspect="equal")
right.plot(pull * 1e3, many.tension[:, 0])
right.set(xlabel="pull (mm)", ylabel="tension (N)")
figure.savefig("first_robot_range.png", dpi=150)
stiffness = np.gradient(many.tension[:, 0], pull)[80] * 1e-3
print(f"{many}; stiffness of the actuator at rest {stiffness:.3f} N/mm")
