"""Measure a fitted ensemble and write metrics, trajectories and learning curves as tables."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from shutil import copyfile

import numpy as np
import pandas as pd

from repro.data.dataset import Dataset
from repro.evaluation.coefficients import coefficient_errors
from repro.evaluation.dissipation import damping_errors, passivity
from repro.evaluation.doubts import doubts, mean_predictor_errors
from repro.evaluation.energy_drift import energy_curves, energy_errors, free_motion_energies
from repro.evaluation.identifiability import Identifiability
from repro.evaluation.pointwise import MetricValues, pointwise
from repro.evaluation.rollouts import (
    ModelRollout,
    can_simulate,
    first_points,
    one_step_errors,
    rollout_errors,
    window_error,
)
from repro.evaluation.uncertainty import in_words, uncertainty_metrics
from repro.learning.objectives import inverse
from repro.learning.sequences import main
from repro.library.ensemble_model import Ensemble
from repro.library.signals import signals
from repro.models.damped import without_damping
from repro.models.gauge import Gauge
from repro.models.lagrangian import Lagrangian
from repro.models.model import Model
from repro.pipeline.stage_options import FitOptions, RunOptions
from repro.pipeline.stages import close_loops, examine
from repro.pipeline.stages.fit import training_data
from repro.pipeline.stages.stored_fit import CURVES, ensemble_of, free_data, system_of
from repro.plugins.plugin import plugin
from repro.tracking import progress
from repro.tracking.plain_data import Json
from repro.tracking.record import Record

METRICS, TRAJECTORIES = "metrics.parquet", "trajectories.parquet"
ON_D_H = ("mae_tau", "mae_qdd", "mae_H_legendre", "mae_H_sum", "mae_L_raw", "min_eig_M")
TRAIN_SAMPLES = 20_000  # of the training part, enough for its mean errors


def make(folder: Path, options: RunOptions, upstream: Mapping[str, Record]) -> Json:
    """Measure a fitted ensemble, and take over the tables of its closed loops, where there are any.

    upstream: fit, and control
    """
    fitted = upstream["fit"]
    fit, inputs = ensemble_of(options.fit, fitted), fitted.upstream
    identified = _identified(options.fit, fit.model, inputs)
    if identified:
        examine.keep(folder, identified, fit.seeds)
    others = [
        *(examine.metrics([*identified.values()][-1]) if identified else ()),
        *_chains(options, fit),
        *_watched(fitted, fit.seeds),
        *_uncertainty(fit),
        *options.metric.measure(fit.model, fit.weights_, fit.data.test, fit.system, "test"),
    ]
    summary = measure(folder, fit, options.gauge, free_data(inputs), others, options.horizons)
    copyfile(fitted.path(CURVES), folder / CURVES)
    if "control" in upstream:
        closed = upstream["control"]
        for name in (close_loops.LOOPS, close_loops.TRAJECTORIES):
            copyfile(closed.path(name), folder / name)
        summary["median"] |= {"success": closed.summary["success"]}
    simulated = options.fit.simulated and can_simulate(fit.model)
    return summary | {"simulated": simulated} | _coefficients(fit)


def measure(
    folder: Path,
    fit: Ensemble,
    gauge: Gauge,
    free: Dataset | None = None,
    others: Sequence[MetricValues] = (),
    horizons: Sequence[float] = (),
) -> Json:
    """All metrics on the test part, the equation errors on the training part, and the first test points as curves.

    free: D_H, whose test part is measured too (split `free`); others: metrics that were taken elsewhere; horizons: s of
    free motion after which the energies of plant and model are compared.
    """
    model, weights, data, system = fit.model, fit.weights_, fit.data, fit.system
    rollout = first_points(model, weights, data.test, system) if can_simulate(model) else None
    metrics = [*_metrics(fit, gauge, rollout), *others]
    if free is not None:
        metrics += [m for m in pointwise(model, weights, free.test, system, "free", gauge) if m.name in ON_D_H]
    if system is None:
        metrics += mean_predictor_errors(data)
        for doubt in doubts(metrics, data):
            progress.notice(f"{data.provenance.get('file', 'data')}: {doubt}")
    motion = None
    if system is not None and horizons and rollout is not None:
        motion = free_motion_energies(model, weights, system, max(horizons))
        metrics += energy_errors(motion, horizons)
    rows = [
        (seed, metric.split, metric.name, float(value), metric.unit)
        for metric in metrics
        for seed, value in zip(fit.seeds, metric.values, strict=True)
    ]
    table = pd.DataFrame(rows, columns=["member", "split", "metric", "value", "unit"])
    table.to_parquet(folder / METRICS, index=False)
    trajectories = [*signals(fit, rollout), *(() if motion is None else energy_curves(motion, fit.seeds))]
    pd.DataFrame(trajectories, columns=["member", "name", "t", "value"]).to_parquet(folder / TRAJECTORIES, index=False)
    medians = {m.name: float(np.median(m.values)) for m in metrics if m.split == "test" and "[" not in m.name}
    return {"median": medians}


def _identified(options: FitOptions, model: Model, upstream: Mapping[str, Record]) -> dict[str, list[Identifiability]]:
    """What the data show of the model; of one without weights to fit, what they would show under the usual loss."""
    training = options.training
    objective = inverse.Options() if training is None else training.objective
    sequence = main.Options() if training is None else training.sequence
    return examine.identified(model, objective, sequence, training_data(options, upstream))


def _chains(options: RunOptions, fit: Ensemble) -> Iterator[MetricValues]:
    """Errors of chains of links; their code is loaded, and part of the stage, only where there are any."""
    if options.chain and (system := system_of(options.fit)) is not None:
        chains = plugin("evaluation", "chains")
        yield from chains.chain_errors(fit.model, fit.weights_, system, options.chain)
    if options.whole_chain and fit.system is not None:
        whole = plugin("evaluation", "whole_chain")
        yield from whole.whole_chain_errors(fit.data, fit.seeds, fit.system, options.tau_noise, options.whole_chain)


def _watched(fit: Record, seeds: Sequence[int]) -> Iterator[MetricValues]:
    """The worst passivity margin on the way, one value per seed, where it was watched."""
    curves = fit.table("curves")
    margins = curves[curves["name"] == "passivity_margin"].groupby("member")["value"].max()
    if len(margins):
        yield MetricValues("train", "passivity_margin_worst", margins.reindex(list(seeds)).to_numpy(), "1")


def _uncertainty(fit: Ensemble) -> Iterator[MetricValues]:
    """What the information of a fit says of its accuracy, and how well its recording is explained."""
    if fit.information_ is None:
        return
    yield MetricValues("train", "cost_per_dof", np.array(fit.notes_["cost_per_dof"], dtype=float), "1")
    for number, values in enumerate(np.array(fit.notes_["noise"]).T):
        yield MetricValues("train", f"sensor_noise[{number}]", values, "m, rad, m/s, rad/s")
    for number, zeros in enumerate(np.array(fit.notes_.get("zeros", [])).T):
        yield MetricValues("train", f"encoder_zero[{number}]", zeros, "rad")
    yield from uncertainty_metrics(fit.model, fit.weights_, fit.information_, fit.data.test)


def _coefficients(fit: Ensemble) -> Json:
    """For people: the first member's coefficients with their standard errors."""
    learned = without_damping(fit.model)
    if fit.information_ is None or not isinstance(learned, Lagrangian) or not learned.linear:
        return {}
    n_kinetic = len(learned.kinetic_features)
    words = in_words(fit.model, fit.weights_[0], fit.information_[0], n_kinetic)
    return {"first member": words, "cost_per_dof": float(np.median(fit.notes_["cost_per_dof"]))}


def _metrics(fit: Ensemble, gauge: Gauge, rollout: ModelRollout | None) -> Iterator[MetricValues]:
    model, weights, test, system = fit.model, fit.weights_, fit.data.test, fit.system
    yield from pointwise(model, weights, test, system, "test", gauge)
    early = min(TRAIN_SAMPLES, fit.data.n_train)
    head = fit.data.select(slice(early), early)
    for metric in pointwise(model, weights, head, None, "train", gauge):
        if metric.name in ("mae_tau", "mae_qdd"):
            yield metric
    learned = without_damping(model)
    if system is not None and isinstance(learned, Lagrangian) and learned.linear:
        yield from coefficient_errors(learned, weights[:, : learned.n_parameters], system)
    if system is not None and model.energetic:
        yield from damping_errors(model, weights, test, system)
    if rollout is not None:
        yield from rollout_errors(rollout, test)
        for errors in (one_step_errors, window_error, passivity):
            yield from errors(model, weights, test, system)
    each = np.ones(fit.members)
    yield MetricValues("train", "fit_seconds", each * fit.seconds_ / fit.members, "s")
    yield MetricValues("train", "epochs", each * fit.notes_.get("epochs", 0), "1")
    yield MetricValues("train", "diverged", np.array([float(status != "ok") for status in fit.status_]), "1")
