"""torch, loaded when one of its functions is first used: it takes longer to load than a closed form takes to fit.

    from repro.codegen.lazy_torch import Tensor, torch

in the place of torch's own names, in every module that fits and evaluates models without networks as well. `Tensor` is
for annotations alone.
"""

from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    import torch
    from torch import Tensor
else:
    Tensor = TypeVar("Tensor")  # isinstance raises TypeError

    class _Torch:
        """The module, once an attribute of it is read."""

        def __getattr__(self, name: str) -> Any:
            import torch as loaded

            return getattr(loaded, name)

    torch = _Torch()

__all__ = ["Tensor", "torch"]
