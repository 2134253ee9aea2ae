"""The output stack of a model of expressions, differentiable by torch."""

from collections.abc import Callable
from typing import Any

import numpy as np
import torch
from torch import Tensor

from repro.codegen.array_evaluation import evaluate
from repro.models.expression import ExpressionModel, arrays_of


class Evaluated(torch.autograd.Function):
    """The output stack as a differentiable function of the weights."""

    @staticmethod
    def forward(ctx: Any, parameters: Tensor, samples: Tensor, model: ExpressionModel) -> Tensor:
        """The stack (member, sample, n_rows)."""
        ctx.model = model
        ctx.save_for_backward(parameters, samples)
        pairs = zip(*arrays_of(parameters, samples), strict=True)
        stacks = [evaluate(model.forward, of_member, weights) for weights, of_member in pairs]
        return torch.from_numpy(np.stack(stacks)).to(parameters.dtype)

    @staticmethod
    def backward(ctx: Any, *cotangents: Tensor) -> Any:
        """The gradient of the weights (member, n_parameters); samples have none."""
        parameters, samples = ctx.saved_tensors
        rows = cotangents[0].unsqueeze(1)
        return ctx.model.vjp(parameters, {"samples": samples}, [rows]).sum((1, 2)), None, None


# torch does not annotate `apply`
evaluated: Callable[[Tensor, Tensor, ExpressionModel], Tensor] = Evaluated.apply
