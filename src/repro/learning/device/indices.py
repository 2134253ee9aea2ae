"""Lists as indices, kept on the device."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import torch
from torch import Tensor
from torch.overrides import TorchFunctionMode


class KeptIndices(TorchFunctionMode):
    """Within it a list that indexes a tensor is sent to the tensor's device once, not at every use.

    A CUDA graph cannot be captured while numbers come from the host.
    """

    def __init__(self) -> None:
        super().__init__()
        self._kept: dict[tuple[tuple[int, ...], torch.device], Tensor] = {}

    def __torch_function__(
        self,
        func: Callable[..., Any],
        types: Sequence[type],
        args: tuple[Any, ...] = (),
        kwargs: Mapping[str, Any] | None = None,
    ) -> Any:
        """Pass everything on, indexing with its lists replaced."""
        if func is Tensor.__getitem__ and isinstance(args[1], tuple):
            args = args[0], tuple(self._index(part, args[0].device) for part in args[1])
        return func(*args, **(kwargs or {}))

    def _index(self, part: Any, device: torch.device) -> Any:
        if not isinstance(part, list):
            return part
        key = tuple(part), device
        if key not in self._kept:
            self._kept[key] = torch.tensor(part, device=device)
        return self._kept[key]
