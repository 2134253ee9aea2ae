"""One member's weights and motion by maximum likelihood: Levenberg-Marquardt in the weights, the path eliminated.

Each iteration filters at the present path, takes a damped Gauss-Newton step in the weights, and moves the path to the
most likely one there. The loss at a linearisation is the profile of the whole least-squares problem.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

import numpy as np

from repro.data.dataset import Dataset
from repro.learning.full_batch import merge_curves
from repro.learning.optimisers.levenberg_marquardt import damped_step
from repro.learning.path.kalman import Linearised, smoothed, whitened
from repro.learning.path.windows import Windows
from repro.learning.result import Fitted, Notes, Progress, Weights, continued_curves, part
from repro.models.model import Model
from repro.models.step_model import StepModel, substeps_for
from repro.models.zeroed import Zeroed
from repro.plugins.options import Count, NotNegative, Options, Positive

LEAVE = 3e-3  # share of the loss below which a gain ends a stage that another one follows
SETTLED = 1e-4  # and the last one, where the rest is small beside what noise does to the weights
MOST_GROWTH = 256.0  # of the damping in one step, after which no step gains any more
ROUNDS = 3  # of the estimates of noise
UNEXPLAINED = 2.0  # cost per degree of freedom above which a network is fitted once more, through WIDER
WIDER = (30.0, 3.0, 0.3, 0.0)  # process noise that absorbs at first what a poor start gets wrong
OUT_OF_RANGE = np.errstate(over="ignore", invalid="ignore")  # what leaves float64 is refused by its infinite loss
LEAST_SPREAD = np.array([1e-16, 1e-14])  # variances of unknown motion in a step, so that no spread is singular


@dataclass(frozen=True)
class PathOptions(Options):
    """Options of the maximum likelihood of weights and motion: what each is stands in conf/objective/path.yaml."""

    window: Positive = 2.0
    substeps: Count | None = None
    noise: Literal["given", "estimated"] = "given"
    process: tuple[NotNegative, ...] | None = None
    initial: tuple[Positive, Positive] = (1.0, 30.0)
    iterations: Count = 60
    zeros: Literal["none", "angles"] = "none"


@dataclass(frozen=True)
class PathFit:
    """The weights, their information matrix (n_parameters, n_parameters), and how well the recording is explained.

    cost_per_dof: 1 where model and noise are right; noise: standard deviations (n_y,) of the sensors; losses: one after
    each iteration; zeros: of the encoders of the angles in rad, and their standard errors.
    """

    parameters: np.ndarray
    information: np.ndarray
    cost_per_dof: float
    noise: np.ndarray
    losses: Sequence[float]
    status: str
    zeros: np.ndarray
    zero_errors: np.ndarray


class MemberPath:
    """The path of one member, and where the fit stands."""

    def __init__(self, model: Model, dataset: Dataset, member: int, options: PathOptions) -> None:
        self.options, self.steps = options, StepModel(model)
        self.fixed = model.fixed
        self.windows = Windows.of(dataset, member, options.window)
        self.states = self.windows.cut(np.concatenate([dataset.q[member], dataset.qd[member]], axis=1))
        self.recorded = self.windows.cut(dataset.tau[member])
        self.tau = self.recorded.copy()
        self.substeps = options.substeps or substeps_for(dataset.qd[member], float(np.nanmax(self.windows.step)))
        self.initial = np.repeat(np.square(options.initial), dataset.n_q)
        self.process = 0.0  # standard deviation of unknown accelerations

    def linearised(self, states: np.ndarray, tau: np.ndarray, parameters: np.ndarray) -> Linearised:
        """The motion near a path (window, position, 2 n_q) under forces (window, position, n_q)."""
        # half as many sub-steps have errors far below what unknown accelerations allow
        substeps = self.substeps if self.process == 0 else -(-self.substeps // 2)
        found = self.steps(states, tau, self.windows.step, parameters, substeps)
        columns = found.columns
        columns[:, :-1, :, 0] -= states[:, 1:]
        columns[..., 0] += np.einsum("wkxi,wki->wkx", found.by_force, self.recorded - tau)
        interval = float(np.nanmedian(self.windows.step))
        sizes = np.array([0.0, (self.process * interval) ** 2]) + LEAST_SPREAD
        return Linearised(states, found.by_state, found.by_force, columns, np.repeat(sizes, self.windows.n_q))

    def regression(self, linear: Linearised) -> np.ndarray:
        """[e | E]'[e | E] of the whitened rows, 0 at fixed weights; infinite where float64 cannot hold it.

        A motion that the model amplifies by many orders of magnitude overflows, or rounds a variance below 0.
        """
        products: np.ndarray = np.full((linear.columns.shape[-1],) * 2, np.inf)
        if np.isfinite(linear.columns).all():
            rows = whitened(self.windows, linear, self.initial)
            rows[:, 1:][:, self.fixed] = 0.0
            if np.isfinite(found := rows.T @ rows).all():
                products = found
        return products

    @OUT_OF_RANGE
    def best_start(self, starts: np.ndarray) -> np.ndarray:
        """The weights of `starts` (start, n_parameters) that explain the recording best, the earlier at equal loss."""
        if len(starts) == 1:
            return np.asarray(starts[0])
        losses = [self.regression(self.linearised(self.states, self.tau, each))[0, 0] for each in starts]
        return np.asarray(starts[int(np.argmin(losses))])

    @OUT_OF_RANGE
    def descend(
        self, parameters: np.ndarray, losses: list[float], leave: float
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """Levenberg-Marquardt at one size of process noise; returns the weights and [e | E]'[e | E] there.

        None, and no loss, where the motion cannot be linearised at `parameters`. The damping follows the ratio of gain
        and expected gain (Nielsen 1999); a step to where the loss is not finite is one without a gain.
        """
        linear = self.linearised(self.states, self.tau, parameters)
        products = self.regression(linear)
        if not np.isfinite(products[0, 0]):
            return None
        losses.append(float(products[0, 0]))
        damping, growth, scale = 1e-3, 2.0, products.diagonal()[1:].copy()
        for _ in range(self.options.iterations):
            gram, gradient = products[1:, 1:], products[0, 1:]
            change = damped_step(gram, gradient, damping * scale)
            path = smoothed(self.windows, linear, change, self.initial)
            states, tau = self.states + path.deviations, self.recorded + path.force_errors
            trial = self.linearised(states, tau, parameters + change)
            tried = self.regression(trial)
            gain = losses[-1] - float(tried[0, 0])
            if gain > 0:
                ratio = gain / max(-float((2 * gradient + gram @ change) @ change), gain / 2)
                self.states, self.tau, parameters, linear, products = states, tau, parameters + change, trial, tried
                scale = np.maximum(scale, products.diagonal()[1:])
                damping, growth = damping * max(1 / 3, 1 - (2 * ratio - 1) ** 3), 2.0
                losses.append(float(products[0, 0]))
                if gain < leave * losses[-1]:
                    break
            else:
                damping, growth = damping * growth, 2 * growth
                if growth > MOST_GROWTH:
                    break
        return parameters, products

    def residual_noise(self) -> np.ndarray:
        """Standard deviations (n_y,) of the sensors, from what the path leaves of their recordings."""
        rest = self.windows.measured - self.states[..., : self.windows.measured.shape[2]]
        seen = int(np.isfinite(rest).sum())
        left = 1 - 2 * self.windows.n_q * len(rest) / seen
        noise: np.ndarray = np.sqrt(np.nanmean(rest**2, axis=(0, 1)) / left)
        return noise


def fit_path(
    model: Model, dataset: Dataset, member: int, starts: np.ndarray, options: PathOptions, progress: Progress
) -> PathFit:
    """Fit one member from the best of `starts` (start, n_parameters), of which one should explain the motion roughly.

    A network that does not explain the recording afterwards is fitted once more with more process noise at first, and
    the better fit is kept; noise that is estimated hides that, and is not examined. Its status is "diverged at step k"
    where the motion cannot be linearised in float64 any more, and its weights are those of the last stage that ended;
    the cost is infinite where none did.
    """
    found = _fit_through(stages_of(model, options), model, dataset, member, starts, options, progress)
    if options.process is None and not model.linear_in_weights and found.cost_per_dof > UNEXPLAINED:
        again = _fit_through(WIDER, model, dataset, member, starts, options, progress)
        found = min(found, again, key=lambda each: each.cost_per_dof)
    return found


def _fit_through(
    stages: tuple[float, ...],
    model: Model,
    dataset: Dataset,
    member: int,
    starts: np.ndarray,
    options: PathOptions,
    progress: Progress,
) -> PathFit:
    """The fit of one member with process noise of these sizes, in turn."""
    own = starts.shape[1]
    if options.zeros == "angles":
        model = _with_zeros(model, dataset.angles)
        starts = np.pad(starts, ((0, 0), (0, model.n_parameters - own)))
    path = MemberPath(model, dataset, member, options)
    rounds = ROUNDS if options.noise == "estimated" else 1
    schedule = [*stages, *[stages[-1]] * (rounds - 1)]
    path.process = schedule[0]
    parameters, products = path.best_start(starts), np.zeros((1 + model.n_parameters,) * 2)
    losses: list[float] = []
    status = "ok"
    for number, process in enumerate(schedule):
        if number >= len(stages):
            path.windows = replace(path.windows, variance=np.maximum(path.residual_noise(), 1e-9) ** 2)
        path.process = process
        found = path.descend(parameters, losses, LEAVE if number < len(stages) - 1 else SETTLED)
        if found is None:
            status = f"diverged at step {len(losses)}"
            break
        parameters, products = found
        progress((number + 1) / len(schedule), f"process noise {process}, loss {losses[-1]:.3e}")
    noise = path.residual_noise() if options.noise == "estimated" else np.sqrt(path.windows.variance)
    cost = losses[-1] / max(path.windows.count - len(parameters), 1) if losses else np.inf
    information, zero_errors = _without_zeros(products[1:, 1:], own)
    return PathFit(parameters[:own], information, cost, noise, losses, status, parameters[own:], zero_errors)


@lru_cache(maxsize=8)
def _with_zeros(model: Model, angles: tuple[int, ...]) -> Zeroed:
    # kept, so that what is compiled for one member serves the others
    return Zeroed(model, angles)


def _without_zeros(information: np.ndarray, own: int) -> tuple[np.ndarray, np.ndarray]:
    """The information of the first weights where the others are not known, and the standard errors of the others."""
    beside = np.linalg.pinv(information[own:, own:])
    shared = information[:own, own:]
    marginal = information[:own, :own] - shared @ beside @ shared.T
    errors: np.ndarray = np.sqrt(np.linalg.pinv(information, rcond=1e-14).diagonal()[own:])
    return marginal, errors


def stages_of(model: Model, options: PathOptions) -> tuple[float, ...]:
    """The sizes of process noise, in turn."""
    if options.process is not None:
        return options.process
    return (0.0,) if model.linear_in_weights else (1.0, 0.1, 0.0)


def fit_paths(
    model: Model, dataset: Dataset, options: PathOptions, start: Fitted, initial: Weights, progress: Progress
) -> Fitted:
    """The ensemble with weights of maximum likelihood and their information; dataset: the training part.

    initial: weights (member, n_parameters) before any fit, for members that they suit better. A balance with fewer
    rows than weights is met exactly by a network whose mass matrix is all but singular.
    """
    candidates = np.stack([np.asarray(each, dtype=float) for each in (start.parameters, initial)], axis=1)
    if model.linear_in_weights:  # solved in closed form, from nothing
        candidates = candidates[:, :1]
    members, fits = len(candidates), []
    for member, starts in enumerate(candidates):
        fits.append(fit_path(model, dataset, member, starts, options, part(progress, member, members, "path: ")))
    curves = merge_curves([dict(enumerate(each.losses)) for each in fits], "path_loss")
    own = Notes(cost_per_dof=[each.cost_per_dof for each in fits], noise=[each.noise.tolist() for each in fits])
    if options.zeros != "none":
        own["zeros"] = [each.zeros.tolist() for each in fits]
        own["zero_errors"] = [each.zero_errors.tolist() for each in fits]
    return replace(
        start,
        parameters=np.stack([each.parameters for each in fits]),
        curves=continued_curves(start.curves, curves),
        status=[old if old != "ok" else each.status for old, each in zip(start.status, fits, strict=True)],
        notes=start.notes | own,
        information=np.stack([each.information for each in fits]),
    )
