# %% [markdown]
# # Compare your network with ours
#
# A network for L(q, qd) as most people would write it, and the structured model, on the same data and with the same
# loss.

# %%
import pandas as pd
import torch
from torch import nn

import repro


class MyLagrangian(nn.Module):
    """One network for L, of cosines, sines and velocities."""

    def __init__(self):
        super().__init__()
        self.net = nn.Sequential(nn.Linear(4, 12), nn.Softplus(), nn.Linear(12, 1))

    def forward(self, q, qd):
        theta = q[..., 1:]
        return self.net(torch.cat([torch.cos(theta), torch.sin(theta), qd], dim=-1))


data = repro.simulate("sip", samples=1000, reset="random", episode_steps=50, seeds=3)
system = repro.system("sip")

# %% [markdown]
# Both are fitted by Levenberg-Marquardt. Where torch.fx can trace a module, compiled code fits it.

# %%
chosen = repro.optimiser("levenberg_marquardt", iterations=100, restarts=2)
mine = repro.fit(data, MyLagrangian, optimiser=chosen, seeds=3, system=system)
ours = repro.fit(data, "structured", optimiser=chosen, seeds=3, system=system)
mine.model.not_symbolic is None

# %% [markdown]
# The median over the seeds. A small error of the force says little alone: the energy and the least eigenvalue of the
# mass matrix say whether a Lagrangian was learned.

# %%
names = ["mae_tau", "mae_qdd", "mae_H_centred", "min_eig_M"]
pd.DataFrame(
    {
        label: fit.score().loc[names, list(fit.seeds)].median(axis=1)
        for label, fit in {"one network for L": mine, "structured": ours}.items()
    }
)

# %% [markdown]
# The same motion, by both models: the angle after 2 s of a swing from 3 rad, one per seed.

# %%
force = torch.zeros(50, 2).numpy()
{
    label: fit.rollout([0.0, 3.0], [0.0, 0.0], force)[:, -1, 1].round(3)
    for label, fit in {"one network for L": mine, "structured": ours}.items()
}
