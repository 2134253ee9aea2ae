"""A model that is written as CasADi expressions alone: what the engines need of it follows by differentiation."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, cached_property
from typing import Any

import casadi
import numpy as np

from repro.codegen.array_evaluation import column_function, evaluate
from repro.codegen.lazy_torch import Tensor, torch
from repro.models.model import SAMPLES, Model, Prepared
from repro.models.terms import Terms, stack_terms


class ExpressionModel(Model):
    """Small models of any form: `energies` and, where L does not say all, `friction`, `port_form` or `momentum`.

    One output stack [tau | p | T | V | M, upper entries | p_tran, if any | eq. (12b) error] (..., n_rows) a sample.
    """

    def prepare(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, tau: np.ndarray) -> dict[str, np.ndarray]:
        """The samples themselves, (..., 4 n_q)."""
        return {"samples": np.concatenate([q, qd, qdd, tau], axis=-1)}

    def outputs(self, parameters: Tensor, prepared: Prepared, mass: bool) -> list[Tensor]:
        """The output stack (member, sample, n_rows)."""
        return [_differentiable()(parameters, prepared["samples"], self)]

    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """The stack, taken apart."""
        n_q, stack = self.n_q, outputs[0]
        rest = stack[..., 2 * n_q + 2 + n_q * (n_q + 1) // 2 :]
        if not self.transforms:
            return replace(stack_terms(stack, n_q), port_error=rest)
        transformed, error = rest[..., :n_q], rest[..., n_q:]
        return replace(stack_terms(stack, n_q), transformed_momentum=transformed, port_error=error)

    def without_weights(self, samples: np.ndarray) -> Terms:
        """The terms, as arrays, of a model without weights; samples (..., 4 n_q) are q, qd, qdd, tau."""
        stack: Any = evaluate(self.forward, samples)
        return self.terms([stack], {})

    def vjp(self, parameters: Tensor, prepared: Prepared, cotangents: list[Tensor]) -> Tensor:
        """Gradients with respect to all weights, (member, row, sample, n_parameters)."""
        arrays = arrays_of(parameters, prepared["samples"], cotangents[0])
        members = [
            np.stack([evaluate(self._reverse, samples, row, weights) for row in rows])
            for weights, samples, rows in zip(*arrays, strict=True)
        ]
        return torch.from_numpy(np.stack(members)).to(parameters.dtype)

    @cached_property
    def forward(self) -> casadi.Function:
        """(samples, parameters) -> the output stack."""
        sample, parameters, stack = self._symbols()
        return column_function("stack", [sample, parameters], stack)

    @cached_property
    def _reverse(self) -> casadi.Function:
        sample, parameters, stack = self._symbols()
        cotangent = casadi.SX.sym("cotangent", stack.numel())
        gradient = casadi.jtimes(stack, parameters, cotangent, True)
        return column_function("vjp", [sample, cotangent, parameters], gradient)

    def _symbols(self) -> tuple[casadi.SX, casadi.SX, casadi.SX]:
        q, qd, qdd, tau, parameters = self.symbols(*SAMPLES)
        energies, momentum = self.energies(q, qd, parameters), self.momentum(q, qd, parameters)
        mass = casadi.jacobian(momentum, qd)
        upper = [mass[c, d] for c in range(self.n_q) for d in range(c, self.n_q)]
        transformed = [self.transformed_momentum(q, qd, parameters)] if self.transforms else []
        stack = casadi.vertcat(
            self.inverse_dynamics(q, qd, qdd, parameters), momentum, energies.kinetic, energies.potential, *upper,
            *transformed, self.port_error(q, qd, qdd, tau, parameters),
        )  # fmt: skip
        return casadi.vertcat(q, qd, qdd, tau), parameters, stack


class Weightless(ExpressionModel):
    """A model that has nothing to fit."""

    n_parameters = 0

    def __init__(self, n_q: int) -> None:
        self.n_q = n_q

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """No weights, (member, 0)."""
        return np.zeros((len(generators), 0))


def arrays_of(*tensors: Tensor) -> list[np.ndarray]:
    """The values of tensors in float64."""
    return [tensor.detach().double().numpy() for tensor in tensors]


@cache
def _differentiable() -> Callable[[Tensor, Tensor, ExpressionModel], Tensor]:
    """(parameters, samples, model) -> the output stack (member, sample, n_rows), differentiable by the weights."""

    class Evaluated(torch.autograd.Function):
        """A class of torch's, so that it is made where torch is loaded."""

        @staticmethod
        def forward(ctx: Any, parameters: Tensor, samples: Tensor, model: ExpressionModel) -> Tensor:
            ctx.model = model
            ctx.save_for_backward(parameters, samples)
            pairs = zip(*arrays_of(parameters, samples), strict=True)
            stacks = [evaluate(model.forward, of_member, weights) for weights, of_member in pairs]
            return torch.from_numpy(np.stack(stacks)).to(parameters.dtype)

        @staticmethod
        def backward(ctx: Any, *cotangents: Tensor) -> Any:
            parameters, samples = ctx.saved_tensors
            rows = cotangents[0].unsqueeze(1)  # samples have no gradient
            return ctx.model.vjp(parameters, {"samples": samples}, [rows]).sum((1, 2)), None, None

    return Evaluated.apply
