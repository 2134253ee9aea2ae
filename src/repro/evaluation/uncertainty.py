"""What the Fisher information of a fit says of its weights: standard errors, unseen directions, expected errors."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import casadi
import numpy as np

from repro.codegen.array_evaluation import column_function, evaluate
from repro.data.dataset import Dataset
from repro.evaluation.identifiability import Identifiability, identifiability
from repro.evaluation.pointwise import ACCELERATION, FORCE, MetricValues
from repro.models.inverse_jacobians import inverse_model
from repro.models.model import Model
from repro.models.step_model import StepModel, substeps_for

CUTOFF = 1e-11  # of the largest eigenvalue of the information scaled to a unit diagonal: below it nothing is known
PARTICIPATES = 1e-4  # share of a weight in a null direction from which it has no standard error
LEADING = 0.1  # of the largest entry of a combination, below which a term is not written
STATES = 500  # test samples over which expected errors are averaged
GAUSSIAN = float(np.sqrt(2 / np.pi))  # mean absolute value of a standard normal


@dataclass(frozen=True)
class Uncertainty:
    """What the information says of the weights (n,) of one member."""

    covariance: np.ndarray  # (n, n), within what is known
    null: np.ndarray  # directions (k, n) of unit size that are not known
    eigenvalues: np.ndarray  # (n,) of the information scaled to a unit diagonal, rising
    directions: np.ndarray  # (n, n), its eigenvectors
    scale: np.ndarray  # (n,) of that scaling

    @classmethod
    def of(cls, information: np.ndarray) -> "Uncertainty":
        """From the Fisher information (n, n) of a member's weights."""
        diagonal = information.diagonal()
        scale = np.where(diagonal > 0, 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1)), 0.0)
        values, vectors = np.linalg.eigh(information * np.outer(scale, scale))
        known = values > CUTOFF * values[-1]
        spread = (vectors[:, known] / np.sqrt(values[known])) * scale[:, None]
        return cls(spread @ spread.T, vectors[:, ~known].T, values, vectors.T, scale)

    @property
    def standard_errors(self) -> np.ndarray:
        """Standard error (n,) of every weight; infinite where it takes part in what is not determined."""
        unseen = (self.null**2).sum(0) > PARTICIPATES
        return np.asarray(np.where(unseen, np.inf, np.sqrt(self.covariance.diagonal())))

    @property
    def least_known(self) -> np.ndarray:
        """The combination (n,) of weights that is known least of those that are known, its largest entry being 1.

        0 where nothing is known, as after a fit that diverged.
        """
        known = np.flatnonzero(self.eigenvalues > CUTOFF * self.eigenvalues[-1])
        if not len(known):
            return np.zeros_like(self.scale)
        direction = self.directions[known[0]] * self.scale
        return np.asarray(direction / direction[np.abs(direction).argmax()])

    def identified(self, names: Sequence[str], n_kinetic: int) -> Identifiability:
        """Rank and null directions in words, as of a regression; names: (n,) of the coefficients."""
        root = np.sqrt(np.maximum(self.eigenvalues, 0))[:, None] * self.directions
        unit = np.where(self.scale > 0, self.scale, 1.0)
        return identifiability(root / unit, names, n_kinetic, cutoff=CUTOFF**0.5)


def uncertainty_metrics(
    model: Model, parameters: np.ndarray, information: np.ndarray, part: Dataset
) -> Iterator[MetricValues]:
    """Standard errors; expected errors at test samples. parameters: (member, n); information: (member, n, n)."""
    members = [Uncertainty.of(each) for each in information]
    yield MetricValues("train", "unseen_directions", np.array([float(len(each.null)) for each in members]), "1")
    if model.coefficient_names:
        for number, errors in enumerate(np.stack([each.standard_errors for each in members]).T):
            yield MetricValues("train", f"standard_error[{number}]", errors, "kg, kg m, kg m^2, J")
    bounds = np.array(
        [expected_errors(model, *each, part) for each in zip(parameters, members, range(len(members)), strict=True)]
    )
    yield MetricValues("test", "bound_mae_tau", bounds[:, 0], FORCE)
    yield MetricValues("test", "bound_mae_qdd", bounds[:, 1], ACCELERATION)


def in_words(model: Model, parameters: np.ndarray, information: np.ndarray, n_kinetic: int) -> dict[str, str]:
    """Of one member with named coefficients: each with its standard error, and what is known least or not at all."""
    names, known = model.coefficient_names, Uncertainty.of(information)
    pairs = zip(names, parameters, known.standard_errors, strict=True)
    words = {
        name: f"{value:.6g} +- {error:.2g}" if np.isfinite(error) else f"{value:.6g}, not determined alone"
        for name, value, error in pairs
    }
    for number, direction in enumerate(known.identified(names, n_kinetic).words, start=1):
        words[f"not determined, {number}"] = direction
    leading = known.least_known
    terms = [f"{leading[i]:.3g} {names[i]}" for i in np.argsort(-np.abs(leading)) if abs(leading[i]) > LEADING]
    return words | ({"known least": " + ".join(terms).replace("+ -", "- ")} if terms else {})


def expected_errors(
    model: Model, parameters: np.ndarray, known: Uncertainty, member: int, part: Dataset
) -> tuple[float, float]:
    """Mean absolute errors of tau and of qdd that the covariance predicts, at samples of a member."""
    every = slice(None, None, max(1, part.samples // STATES))
    q, qd, qdd = (array[member, every] for array in (part.q, part.qd, part.qdd))
    slopes = inverse_model(model).linear(np.concatenate([q, qd, qdd], axis=1), parameters)[..., 1:]
    symbols = model.symbols("q", "qd")
    inertia = column_function("mass", symbols, casadi.vec(model.mass_matrix(*symbols)))
    mass = evaluate(inertia, q, qd, parameters).reshape(-1, model.n_q, model.n_q)
    means = []
    for rows in (slopes, np.linalg.solve(mass, slopes)):
        variance = np.einsum("niw,wv,niv->ni", rows, known.covariance, rows, optimize=True)
        means.append(GAUSSIAN * float(np.sqrt(np.maximum(variance, 0)).mean()))
    return means[0], means[1]


def motion_errors(
    model: Model, parameters: np.ndarray, information: np.ndarray, motion: np.ndarray, part: Dataset
) -> np.ndarray:
    """Standard errors (member, point, 2 n_q) of a roll-out by the errors of the weights, exact at each restart.

    parameters: (member, n); information: (member, n, n); motion: the roll-out (member, point, 2 n_q) over the first
    samples of `part` and under their force.
    """
    steps, points = StepModel(model), motion.shape[1]
    restart = np.append(True, np.diff(part.episode[:points]) != 0)
    interval = np.where(restart[1:], np.nan, part.time_step)
    errors = np.zeros_like(motion)
    for member, (weights, known) in enumerate(zip(parameters, information, strict=True)):
        covariance = Uncertainty.of(known).covariance
        substeps = substeps_for(part.qd[member], part.time_step)
        step = steps(motion[member, :-1], part.tau[member, : points - 1], interval, weights, substeps)
        slope = np.zeros((motion.shape[2], len(weights)))
        for k, (by_state, by_weights) in enumerate(zip(step.by_state, step.columns[..., 1:], strict=True), start=1):
            slope = by_state @ slope + by_weights  # both are 0 at a restart
            errors[member, k] = np.sqrt(np.maximum(np.einsum("xw,wv,xv->x", slope, covariance, slope), 0))
    return errors
