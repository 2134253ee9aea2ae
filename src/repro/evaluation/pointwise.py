"""The errors of a fitted ensemble, one value per seed: pointwise, gauge-aware, and structural."""

from collections.abc import Iterator
from dataclasses import dataclass

import casadi
import numpy as np

from repro.codegen.array_evaluation import evaluate
from repro.data.dataset import Dataset
from repro.evaluation.canonical import RestStates, in_gauge
from repro.evaluation.predictions import predict, truth
from repro.mechanics.derive import dynamics_of
from repro.mechanics.system import System
from repro.models.gauge import Gauge
from repro.models.model import Model
from repro.models.terms import Terms, least_eigenvalue

FORCE, ACCELERATION, MOMENTUM = "N, N m", "m/s^2, rad/s^2", "kg m/s, kg m^2/s"
LARGEST_ENERGY_ERROR = 0.3  # of the trivial model's, after one constant; above it a model has not learned the energy
SMALLEST_INERTIA = 0.1  # of the true least eigenvalue; below it a mass matrix has lost a direction of motion
SMALLEST_WEIGHT = 0.1  # of the deviation of the energy at rest; below it a cosine has no weight to compare with


@dataclass(frozen=True)
class MetricValues:
    """One named error: values (member,) with its unit and the split it was taken on."""

    split: str
    name: str
    values: np.ndarray
    unit: str


def pointwise(
    model: Model, parameters: np.ndarray, part: Dataset, system: System | None, split: str, gauge: Gauge
) -> Iterator[MetricValues]:
    """All errors that need single samples only; the true energies are compared where the true system is known."""
    arrays = (part.q, part.qd, part.qdd, part.tau)
    predicted = predict(model, parameters, *arrays)
    yield from _equation_errors(predicted, part, split)
    least = None if predicted.mass is None else least_eigenvalue(predicted.mass)
    if predicted.energy is not None and system is not None:
        error = _centred(predicted.energy - truth(system, *arrays).hamiltonian(part.qd))
        yield MetricValues(split, "mae_H_centred", error, "J")
    if least is not None and model.energetic:
        yield MetricValues(split, "min_eig_M", least, "kg, kg m^2")
    if predicted.transformed_momentum is not None:
        gap = np.abs(predicted.transformed_momentum - predicted.momentum).mean((1, 2))
        yield MetricValues(split, "momentum_transform", gap, MOMENTUM)
    if system is not None and model.energetic:
        true = truth(system, *arrays)
        yield from _energy_errors(predicted, true, part.qd, least, split)
        yield from _part_energy_error(model, parameters, part, system, split)
        rest = RestStates(model, parameters, system, part.q)
        yield from _gravity(rest, split)
        read = in_gauge(predicted, rest, part.qd, gauge)
        yield MetricValues(split, "mae_H_sum", np.abs(read.energy_sum - true.energy_sum).mean(1), "J")
        yield MetricValues(split, "mae_T", np.abs(read.kinetic - true.kinetic).mean(1), "J")
        yield MetricValues(split, "mae_V", np.abs(read.potential - true.potential).mean(1), "J")
        yield MetricValues(split, "min_T", read.kinetic.min(1), "J")
        canonical = in_gauge(predicted, rest, part.qd, Gauge.CANONICAL_ANCHOR)
        error = np.abs(canonical.lagrangian - true.lagrangian).mean(1)
        yield MetricValues(split, "mae_L_canonical", error, "J")
        yield MetricValues(split, "gyroscopic_remainder", rest.remainder, MOMENTUM)
        if predicted.transformed_momentum is not None:
            error = np.abs(predicted.transformed_momentum - true.momentum).mean((1, 2))
            yield MetricValues(split, "mae_p_transformed", error, MOMENTUM)


def _equation_errors(predicted: Terms, part: Dataset, split: str) -> Iterator[MetricValues]:
    for name, ours, measured, unit in (
        ("tau", predicted.tau, part.tau, FORCE),
        ("qdd", predicted.acceleration, part.qdd, ACCELERATION),
    ):
        if ours is None:
            continue
        error = finite_or_infinite(np.abs(ours - measured))
        yield MetricValues(split, f"mae_{name}", error.mean((1, 2)), unit)
        for component, coordinate in enumerate(part.coordinates):
            own_unit = coordinate.force_unit if name == "tau" else f"{coordinate.unit}/s^2"
            yield MetricValues(split, f"mae_{name}[{component}]", error[..., component].mean(1), own_unit)
        yield MetricValues(split, f"median_ae_{name}", np.median(error, axis=(1, 2)), unit)
        with np.errstate(divide="ignore"):
            skill = 1 - error.mean((1, 2)) / np.abs(measured).mean((1, 2))
        yield MetricValues(split, f"skill_{name}", skill, "1")


def _energy_errors(
    predicted: Terms, true: Terms, qd: np.ndarray, least: np.ndarray | None, split: str
) -> Iterator[MetricValues]:
    lagrangian = np.abs(predicted.lagrangian - true.lagrangian).mean(1)
    yield MetricValues(split, "mae_L_raw", lagrangian, "J")
    yield MetricValues(split, "mae_L_relative", lagrangian / np.abs(true.lagrangian).mean(1), "1")
    energy = true.hamiltonian(qd)
    error = predicted.hamiltonian(qd) - energy
    yield MetricValues(split, "mae_H_legendre", np.abs(error).mean(1), "J")
    yield MetricValues(split, "mae_H_centred", _centred(error), "J")
    yield MetricValues(split, "mae_p", np.abs(predicted.momentum - true.momentum).mean((1, 2)), MOMENTUM)
    yield MetricValues(split, "trapped", _trapped(_centred(error), _centred(energy), true.mass, least), "1")


def _part_energy_error(
    model: Model, parameters: np.ndarray, part: Dataset, system: System, split: str
) -> Iterator[MetricValues]:
    """Error of H_S, the energy of the first sub-system inside an interconnection, after one constant."""
    q, qd, weights = model.symbols("q", "qd")
    energies, true = model.part_energies(q, qd, weights), system.first_part
    if not energies or true is None:
        return
    lagrangian = energies[0].kinetic - energies[0].potential
    own = casadi.Function("H_S", [q, qd, weights], [casadi.jtimes(lagrangian, qd, qd) - lagrangian], {"cse": True})
    states = [(part.q[m], part.qd[m]) for m in range(part.members)]
    energy = dynamics_of(true).hamiltonian
    errors = [
        evaluate(own, *state, member)[:, 0] - evaluate(energy, *(rows[:, : true.n_q] for rows in state))[:, 0]
        for state, member in zip(states, parameters, strict=True)
    ]
    yield MetricValues(split, "mae_H_part", np.array([np.abs(e - e.mean()).mean() for e in errors]), "J")


def _centred(energy: np.ndarray) -> np.ndarray:
    """Mean size (member,) of what is left of an energy (member, sample) after one constant."""
    return np.asarray(np.abs(energy - energy.mean(1, keepdims=True)).mean(1))


def _trapped(error: np.ndarray, trivial: np.ndarray, mass: np.ndarray, least: np.ndarray | None) -> np.ndarray:
    """1 where a member has the cart's momentum and little else: L = p_x^2 / (2 m) has a small error of tau.

    A model without an invertible mass matrix, as L = p_x^2 / (2 m) itself, is trapped by definition. error, trivial: of
    its energy and of a constant one, after one constant; mass: the true one; least: its own least eigenvalue.
    """
    if least is None:
        return np.ones_like(error)
    trapped = ~(error <= LARGEST_ENERGY_ERROR * trivial) | (least < SMALLEST_INERTIA * least_eigenvalue(mass))
    return np.asarray(trapped, dtype=float)


def _gravity(rest: RestStates, split: str) -> Iterator[MetricValues]:
    """Learned over true weight of each cos(angle), where that is not 0, in the energy at rest, which has no gauge."""
    system, q = rest.system, rest.q
    zero, angles = np.zeros_like(q), list(system.angles)
    energy = truth(system, q, zero, zero, zero).hamiltonian(zero)
    learned, true = (_cosine_weights(q[..., angles], values) for values in (rest.terms.hamiltonian(zero), energy))
    weighty = np.abs(true).min(0) > SMALLEST_WEIGHT * energy.std()
    if not weighty.any():
        return
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = (learned / true)[:, weighty]
    yield MetricValues(split, "gravity", ratio.mean(1), "1")
    for index, angle in enumerate(np.array(angles)[weighty]):
        yield MetricValues(split, f"gravity[{angle}]", ratio[:, index], "1")


def _cosine_weights(angles: np.ndarray, energy: np.ndarray) -> np.ndarray:
    """Least-squares weights (member, angle) of the cosines in an energy (member, sample), beside a constant."""
    columns = np.concatenate([np.cos(angles), np.ones((*angles.shape[:2], 1))], axis=-1)
    usable = np.where(np.isfinite(energy), energy, 0.0)
    return np.stack([np.linalg.lstsq(c, e, rcond=None)[0] for c, e in zip(columns, usable, strict=True)])[:, :-1]


def finite_or_infinite(error: np.ndarray) -> np.ndarray:
    """Errors in which what is no number counts as infinite."""
    return np.where(np.isfinite(error), error, np.inf)
