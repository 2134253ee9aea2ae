"""Anyone's torch module as a model: derivatives by torch.func, and CasADi expressions where its graph allows."""

from collections.abc import Callable, Sequence
from enum import StrEnum
from functools import partial
from typing import Any

import casadi
import numpy as np
import torch
from torch import Tensor, nn
from torch.func import functional_call, grad, jacrev, vjp, vmap

from repro.errors import UserError
from repro.models.model import SAMPLES, EnergyExpressions, Model, Prepared, consecutive
from repro.models.module_graph import NotSymbolicError, as_array, symbolic
from repro.models.terms import Terms, stack_terms

LARGEST_SYMBOLIC = 2000  # weights: above this, expressions take longer to compile than they save
LARGEST_CHUNK = 512  # samples whose gradients are taken at a time


class Form(StrEnum):
    """What a module's `forward` stands for.

    lagrangian    L = module(q, qd)
    energies      T, V = module(q, qd)
    acceleration  qdd = module(q, qd, tau)
    port          M = module.mass(q), V = module.potential(q), and, where it exists, the friction matrix
                  D = module.dissipation(q): a port-Hamiltonian system with H = p' M^-1 p / 2 + V and R = diag(0, D)
    """

    LAGRANGIAN = "lagrangian"
    ENERGIES = "energies"
    ACCELERATION = "acceleration"
    PORT = "port"


class ModuleModel(Model):
    """An ensemble of copies of one module, in float64; the weights of a copy are one row of the parameters.

    factory: returns a new module with its random start; every tensor that it is handed is one sample, (n_q,), under
    torch.func.vmap. Its form is read off it, see `form_of`.
    """

    def __init__(self, factory: Callable[[], nn.Module], n_q: int) -> None:
        self.n_q, self.factory = n_q, factory
        self.module = factory().double().eval()
        self._methods = _Methods(self.module)
        self.form = form_of(self.module, n_q)
        self.energetic = self.inverse = self.form != Form.ACCELERATION
        self.shapes = {name: weight.shape for name, weight in self.module.named_parameters()}
        sizes = [shape.numel() for shape in self.shapes.values()]
        self.places = dict(zip(self.shapes, consecutive(*sizes), strict=True))
        self.n_parameters = sum(sizes)
        self.not_symbolic = self._not_symbolic()

    def _not_symbolic(self) -> str | None:
        """Why the module has no CasADi form, or None where it has one."""
        if self.n_parameters > LARGEST_SYMBOLIC:
            return f"{type(self.module).__name__} has {self.n_parameters} weights, more than {LARGEST_SYMBOLIC}"
        q, qd, tau, parameters = self.symbols("q", "qd", "tau")
        try:
            if self.energetic:
                self.energies(q, qd, parameters)
                self.friction(q, qd, parameters)
            else:
                self.acceleration(q, qd, tau, parameters)
        except NotSymbolicError as error:
            return str(error)
        return None

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """The start that the module's own constructor draws, one per generator."""
        starts = []
        for generator in generators:
            with torch.random.fork_rng(devices=[]):
                torch.manual_seed(int(generator.integers(2**31)))
                weights = [weight.detach().double().flatten() for weight in self.factory().parameters()]
            starts.append(torch.cat(weights).numpy())
        return np.stack(starts)

    def outputs(self, parameters: Tensor, prepared: Prepared, mass: bool) -> list[Tensor]:
        """Rows (member, sample, n_rows): [tau | p | T | V | upper entries of M, with `mass`], or the acceleration."""
        samples = [prepared[name] for name in SAMPLES]
        of_member = vmap(self._stack(mass), in_dims=(None, 0, 0, 0, 0))
        return [vmap(of_member)(parameters, *samples)]

    def terms(self, outputs: list[Tensor], prepared: Prepared) -> Terms:
        """The stack, taken apart."""
        return stack_terms(outputs[0], self.n_q) if self.energetic else Terms(acceleration=outputs[0])

    def vjp(self, parameters: Tensor, prepared: Prepared, cotangents: list[Tensor]) -> Tensor:
        """Gradients with respect to all weights, (member, row, sample, n_parameters)."""
        (rows,) = cotangents
        full = 2 * self.n_q + 2 + self.n_q * (self.n_q + 1) // 2
        stack = self._stack(mass=self.energetic and rows.shape[-1] == full)

        def of_sample(weights: Tensor, cotangent: Tensor, *sample: Tensor) -> Tensor:
            pull = vjp(lambda w: stack(w, *sample), weights)[1]
            gradients: Tensor = vmap(lambda row: pull(row)[0])(cotangent)
            return gradients

        of_member = vmap(of_sample, in_dims=(None, 1, 0, 0, 0, 0), out_dims=1, chunk_size=LARGEST_CHUNK)
        samples = [prepared[name] for name in SAMPLES]
        members = zip(parameters, rows, *samples, strict=True)
        return torch.stack([of_member(*member) for member in members])

    def energies(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> EnergyExpressions:
        """T and V as CasADi expressions; NotSymbolicError where the module has none."""
        if not self.energetic:
            return super().energies(q, qd, parameters)

        def called(method: str, *inputs: np.ndarray) -> Any:
            return self._traced(method, [casadi.vertcat(*each) for each in inputs], parameters)

        position, rates = (np.array(casadi.vertsplit(each), dtype=object) for each in (q, qd))
        kinetic, potential = self._energies(called, position, rates, 0 * rates)
        return EnergyExpressions(_scalar(kinetic), _scalar(potential))

    def friction(self, q: casadi.SX, qd: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """D(q) qd, where the module has a dissipation."""
        if not hasattr(self.module, "dissipation"):
            return super().friction(q, qd, parameters)
        rows = self._traced("dissipation", [q], parameters)
        matrix: casadi.SX = casadi.vertcat(*(casadi.horzcat(*row) for row in rows))
        return matrix @ qd

    def acceleration(self, q: casadi.SX, qd: casadi.SX, tau: casadi.SX, parameters: casadi.SX) -> casadi.SX:
        """qdd as a CasADi expression."""
        if self.energetic:
            return super().acceleration(q, qd, tau, parameters)
        qdd: casadi.SX = casadi.vertcat(*self._traced("forward", [q, qd, tau], parameters))
        return qdd

    def port_values(self, weights: np.ndarray, q: np.ndarray, qd: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """dH/dx and (J - R) dH/dx, by torch.func where the module has no symbolic form."""
        if self.not_symbolic is None or not self.energetic:
            return super().port_values(weights, q, qd)
        member = torch.from_numpy(np.ascontiguousarray(weights, dtype=float))

        def of_sample(position: Tensor, velocity: Tensor) -> Tensor:
            push = grad(lambda place: torch.sub(*self._energy_values(member, place, velocity)))(position)
            friction = torch.zeros_like(velocity)
            if hasattr(self.module, "dissipation"):
                friction = self._called(member, "dissipation", position) @ velocity
            return torch.cat([-push, velocity, velocity, push - friction])

        arrays = [np.asarray(array, dtype=float) for array in (q, qd)]
        flat = [torch.from_numpy(array.reshape(-1, self.n_q).copy()) for array in np.broadcast_arrays(*arrays)]
        rows = vmap(of_sample)(*flat).detach().numpy().reshape(*np.broadcast_shapes(*map(np.shape, arrays))[:-1], -1)
        gradient, drift = np.split(rows, 2, axis=-1)
        return gradient, drift

    def _traced(self, method: str, inputs: list[casadi.SX], parameters: casadi.SX) -> Any:
        entries = np.array(casadi.vertsplit(parameters), dtype=object)
        weights = {name: entries[place].reshape(self.shapes[name]) for name, place in self.places.items()}
        return symbolic(self.module, method, inputs, weights)

    def _stack(self, mass: bool) -> Callable[[Tensor, Tensor, Tensor, Tensor, Tensor], Tensor]:
        """(weights, q, qd, qdd, tau) of one sample -> its row of `outputs`."""
        if not self.energetic:
            return lambda weights, q, qd, qdd, tau: self._called(weights, "forward", q, qd, tau)

        def stack(weights: Tensor, q: Tensor, qd: Tensor, qdd: Tensor, tau: Tensor) -> Tensor:
            def lagrangian(position: Tensor, velocity: Tensor) -> Tensor:
                kinetic, potential = self._energy_values(weights, position, velocity)
                return kinetic - potential

            momentum = grad(lagrangian, 1)
            # by reverse passes alone: not every operation of torch has a forward derivative
            coupling, inertia = jacrev(momentum, (0, 1))(q, qd)
            force = coupling @ qd + inertia @ qdd - grad(lagrangian)(q, qd)
            if hasattr(self.module, "dissipation"):
                force = force + self._called(weights, "dissipation", q) @ qd
            kinetic, potential = self._energy_values(weights, q, qd)
            parts = [force, momentum(q, qd), kinetic.reshape(1), potential.reshape(1)]
            if mass:
                rows, columns = torch.triu_indices(self.n_q, self.n_q)
                parts.append(inertia[rows, columns])
            return torch.cat(parts)

        return stack

    def _energies(self, called: Callable[..., Any], q: Any, qd: Any, still: Any) -> Any:
        """T and V; `called`: what a method of the module returns for tensors, or for arrays of expressions."""
        match self.form:
            case Form.LAGRANGIAN:
                moving, resting = called("forward", q, qd), called("forward", q, still)
                return moving - resting, -resting
            case Form.ENERGIES:
                return called("forward", q, qd)
            case _:
                return qd @ called("mass", q) @ qd / 2, called("potential", q)

    def _energy_values(self, weights: Tensor, q: Tensor, qd: Tensor) -> list[Tensor]:
        """T and V as tensors without axes."""
        energies = self._energies(partial(self._called, weights), q, qd, torch.zeros_like(qd))
        return [energy.reshape(()) for energy in energies]

    def _called(self, weights: Tensor, method: str, *inputs: Tensor) -> Any:
        named = {f"module.{name}": weights[place].reshape(self.shapes[name]) for name, place in self.places.items()}
        return functional_call(self._methods, named, (method, *inputs))


def form_of(module: nn.Module, n_q: int) -> Form:
    """The form that a module has by its methods and by what it returns; UserError where it fits none."""
    if hasattr(module, "mass") and hasattr(module, "potential"):
        return Form.PORT
    zero = torch.zeros(n_q, dtype=torch.float64)
    name, failures = type(module).__name__, []
    for inputs, forms in (((zero, zero), (Form.LAGRANGIAN, Form.ENERGIES)), ((zero,) * 3, (Form.ACCELERATION,))):
        try:
            value = module(*inputs)
        except (TypeError, RuntimeError, ValueError, IndexError) as error:
            failures.append(f"{len(inputs)} arguments: {' '.join(str(error).split())}")
            continue
        if isinstance(value, tuple) and len(value) == 2 and len(forms) == 2:
            return Form.ENERGIES
        sizes = {Form.LAGRANGIAN: 1, Form.ACCELERATION: n_q}
        if isinstance(value, Tensor) and value.numel() == sizes[forms[0]]:
            return forms[0]
        failures.append(f"{len(inputs)} arguments: it returns {_described(value)}")
    raise UserError(
        f"{name} is none of L = module(q, qd), (T, V) = module(q, qd), qdd = module(q, qd, tau), and it has no mass(q) "
        f"and potential(q), for q of {n_q} numbers. {'; '.join(failures)}"
    )


class _Methods(nn.Module):
    """All methods of a module by their name, for torch.func, which calls `forward` alone."""

    def __init__(self, module: nn.Module) -> None:
        super().__init__()
        self.module = module

    def forward(self, method: str, *inputs: Tensor) -> Any:
        return getattr(self.module, method)(*inputs)


def _described(value: object) -> str:
    return f"a tensor of shape {tuple(value.shape)}" if isinstance(value, Tensor) else f"a {type(value).__name__}"


def _scalar(value: Any) -> casadi.SX:
    (entry,) = as_array(value).ravel()
    return casadi.SX(entry)
