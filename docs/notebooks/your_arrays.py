# %% [markdown]
# # Fit your arrays
#
# A recording is a few arrays: positions, velocities, forces. Here they come from the simulator of a cart with a link,
# so that the truth is known; replace them by yours.

# %%
import numpy as np

import repro

recorded = repro.simulate("sip", samples=1500, reset="random", episode_steps=50, tau_noise=0.05)
q, qd, qdd, tau = recorded.q[0], recorded.qd[0], recorded.qdd[0], recorded.tau[0]
q.shape

# %% [markdown]
# Besides the samples a structured model needs the names of the coordinates, which of them are angles, and which are
# cyclic (neither energy depends on them).

# %%
data = repro.dataset(
    q, qd, tau, qdd=qdd, episode=recorded.episode, time_step=0.04,
    coordinates=["x", "theta"], angles=["theta"], cyclic=["x"],
)  # fmt: skip
fitted = repro.fit(data, "structured", seeds=2)
fitted

# %% [markdown]
# Measured and predicted forces on samples that the fit has not seen, the energies that it has learned, and the loss.

# %%
fitted.plot()

# %% [markdown]
# The mass matrix with the link upright, one per seed; the truth is [[0.8, 0.1], [0.1, 0.05]].

# %%
fitted.mass_matrix([0.0, 0.0]).round(3)

# %% [markdown]
# Without force the learned energy must stay what it is.

# %%
states = fitted.rollout([0.0, 3.0], [0.0, 0.0], np.zeros((100, 2)))
energy = fitted.energies(states[0, :, :2], states[0, :, 2:]).hamiltonian
energy.max(axis=1) - energy.min(axis=1)
