"""The order of the samples, drawn where the samples are."""

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor


def drawn(seeds: Sequence[int], samples: int, epoch: int, device: torch.device) -> Tensor:
    """A fresh order of each member's samples, (member, sample), from (seed, epoch) alone: a resumed fit sees the same.

    It is another than the host's: there a shuffle takes longer than an epoch of the steps on a device.
    """
    generator, rows = torch.Generator(device), []
    for seed in seeds:
        generator.manual_seed(int(np.random.SeedSequence([seed, 11, epoch]).generate_state(1, np.uint64)[0]))
        rows.append(torch.randperm(samples, generator=generator, device=device))
    return torch.stack(rows)
