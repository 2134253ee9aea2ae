# %% [markdown]
# # Control a learned pendulum
#
# A structured model is learned from 1,000 noisy samples of a cart with a link, and drives the true plant: the
# controller minimises the learned kinetic energy and maximises the learned potential energy over a horizon of 1.8 s.

# %%
import numpy as np
from matplotlib.figure import Figure

import repro

data = repro.simulate("sip", samples=1000, reset="random", episode_steps=50, tau_noise=0.1)
learned = repro.fit(data, "structured", system=repro.system("sip"))
learned

# %% [markdown]
# Ten random starts around hanging; the link must be upright and the cart at its place for the last 2 s of 10 s, without
# touching the disc.

# %%
task = repro.task(initial_states=10, x_des=[0.8, -0.8], start_seed=1)
controller = repro.controller("mpc", intervals=15, coarse_intervals=15, force_limit=4.0,
                              stage_cost={"potential": 1, "position": 1, "force": 0.01})  # fmt: skip
done = learned.control(task, controller)
done.success

# %% [markdown]
# The angle from upright in each of the loops; the dashed lines are 5 degrees.

# %%
figure = Figure(figsize=(7, 3), layout="constrained")
axes = figure.subplots()
for loop in done.loops:
    axes.plot(loop.time, np.degrees(np.angle(np.exp(1j * loop.states[:, 1]))), color="#444444", lw=0.8)
for bound in (-5, 5):
    axes.axhline(bound, color="#d55e00", ls="--", lw=0.8)
axes.set(xlabel="time, s", ylabel="angle from upright, deg")
figure
