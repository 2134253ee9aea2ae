"""One training step, loss and gradient, in the two engines of this project."""

from collections.abc import Callable

import numpy as np
import torch
from torch import Tensor

from repro.bench.training_case import Equation, TrainingCase
from repro.errors import UserError
from repro.learning.native import native

Step = Callable[[], tuple[np.ndarray, np.ndarray]]  # loss (member,), gradient (member, n_parameters)


def torch_step(case: TrainingCase, equation: Equation) -> Step:
    """Jets of the network in torch, and one backward pass; the features' derivatives are prepared beforehand."""
    problem = case.problem(equation)
    return differentiated(problem.loss, case.parameters)


def native_step(case: TrainingCase, equation: Equation) -> Step:
    """Compiled C, member by member. Raises UserError for a model without compiled code."""
    compiled = native(case.problem(equation))
    if compiled is None:
        raise UserError("no compiled code for this model: it needs a C compiler, and a kernel or a small model")
    weights = list(case.parameters.numpy())

    def step() -> tuple[np.ndarray, np.ndarray]:
        losses, gradients = zip(*(compiled.loss_and_gradient(m, w) for m, w in enumerate(weights)), strict=True)
        return np.array(losses), np.stack(gradients)

    return step


def differentiated(loss: Callable[[Tensor], Tensor], parameters: Tensor) -> Step:
    """A step from a loss (member,) of the weights (member, n_parameters), by autograd."""

    def step() -> tuple[np.ndarray, np.ndarray]:
        weights = parameters.detach().requires_grad_()
        value = loss(weights)
        (gradient,) = torch.autograd.grad(value.sum(), weights)
        return value.detach().numpy(), gradient.numpy()

    return step
