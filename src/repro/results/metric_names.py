"""The metrics by name: how they are written for people, on which scale they average, and which way is better.

`mae_H_sum` is the error on the test part of D, `mae_H_sum@free` that on the test part of D_H.
"""

import re
from dataclasses import dataclass, replace
from typing import Literal


@dataclass(frozen=True)
class Metric:
    """One metric: `log` errors average on the log scale, `linear` ones plainly, `share` ones are 0 or 1 a member."""

    label: str
    meaning: str
    scale: Literal["log", "linear", "share"] = "log"
    lower_is_better: bool = True
    split: Literal["test", "train", "free"] = "test"


# Card values as people write them; any other stands as it is, with dashes for underscores.
NAMES = {
    "t1": "T1/V1",
    "t2": "T2/V1",
    "fxf": "F⊗F",
    "fxf_gauge": "F⊗F + gauge",
    "adam": "Adam",
    "adam_cosine": "Adam, cosine decay",
    "adam_l1": "Adam + L1",
    "adam_cosine_l1": "Adam, cosine decay + L1",
    "lasso": "Lasso",
    "lbfgs": "L-BFGS",
    "levenberg_marquardt": "Levenberg-Marquardt",
    "least_squares": "least squares",
    "least_squares_from_start": "least squares from a random start",
    "thresholded_least_squares": "thresholded least squares",
    "blackbox": "black box",
    "neural_potential": "neural V",
    "extended": "part + rest",
    "hinged": "parts, hinged",
    "port_hamiltonian": "port-Hamiltonian",
    "main": "D",
    "pretrain_only": "D_H",
    "pretrain": "D_H, then D",
    "joint": "D and D_H",
}
TEXT_COLUMNS = ("model", "basis", "hidden", "optimiser", "sequence", "objective", "energies", "curriculum")

METRICS: dict[str, Metric] = {
    "mae_tau": Metric("MAE τ", "mean absolute error of the generalised force"),
    "mae_qdd": Metric("MAE q̈", "mean absolute error of the acceleration"),
    "median_ae_qdd": Metric("median AE q̈", "median absolute error of the acceleration"),
    "mae_L_raw": Metric("MAE L raw", "error of L as learned: moves with the gauge"),
    "mae_L_relative": Metric("MAE L relative", "error of L divided by the mean of its magnitude"),
    "mae_L_canonical": Metric("MAE L canonical", "error of L after the gauge is removed"),
    "mae_H_legendre": Metric("MAE H Legendre", "absolute error of p.qd - L"),
    "mae_H_centred": Metric("MAE H centred", "error of p.qd - L after one constant"),
    "mae_H_sum": Metric("MAE T + V", "error of the sum of the learned energies"),
    "mae_T": Metric("MAE T", "error of the kinetic energy"),
    "mae_V": Metric("MAE V", "error of the potential energy"),
    "gyroscopic_remainder": Metric("gauge remainder", "what of p(q, 0) is no gradient dF/dq"),
    "mae_p": Metric("MAE p", "mean absolute error of the momentum"),
    "mae_p_transformed": Metric("MAE M̂q̇", "mean absolute error of M(q) qd as momentum"),
    "median_ae_tau": Metric("median AE τ", "median absolute error of the force"),
    "min_eig_M": Metric(
        "min eig M",
        "least eigenvalue of the mass matrix over the test set",
        scale="linear",
        lower_is_better=False,
    ),
    "trapped": Metric(
        "trapped",
        "share of members that have the cart's momentum and little else: MAE H centred > 30 % of the trivial model's, "
        "min eig M < 10 % of the true one, or no invertible M at all",
        scale="share",
    ),
    "gravity": Metric(
        "gravity",
        "learned weight of the cosines in the energy at rest, over the true one",
        scale="linear",
        lower_is_better=False,
    ),
    "min_T": Metric(
        "min T",
        "least kinetic energy over the test set",
        scale="linear",
        lower_is_better=False,
    ),
    "coefficient_error": Metric("coefficient error", "greatest error of a coefficient"),
    "rollout_error": Metric("rollout error", "relative error of a rollout, geometric mean"),
    "onestep_euler_qd": Metric("one-step q̇", "velocity error of one explicit Euler step"),
    "onestep_exact_qd": Metric("one exact step q̇", "velocity error of one exact step"),
    "rollout_qd": Metric("rollout q̇", "velocity error of a 300-step rollout"),
    "momentum_transform": Metric("|M̂q̇ - p̂|", "mean gap between the two momenta"),
    "rank": Metric("rank", "combinations of terms that the training data see", scale="linear", split="train"),
    "null_directions": Metric(
        "unseen", "combinations of terms that the training data do not see", scale="linear", split="train"
    ),
    "condition_raw": Metric("condition", "condition number of the regression", split="train"),
    "condition_scaled": Metric("condition, unit columns", "after scaling", split="train"),
    "support_exact": Metric(
        "exact support", "share of members with the true terms", scale="share", lower_is_better=False
    ),
    "false_terms": Metric("false terms", "number of wrong terms", scale="linear"),
    "fit_seconds": Metric("fit", "CPU time of the fit", split="train"),
    "epochs": Metric("epochs", "epochs done", scale="linear", split="train"),
    "diverged": Metric("diverged", "share of members that diverged", scale="share", split="train"),
    "success": Metric("success", "share of closed loops that reach the goal", scale="share", lower_is_better=False),
    "passivity_margin": Metric(
        "passivity margin", "worst over random states, by the model's own energy", scale="linear"
    ),
    "passivity_margin_worst": Metric(
        "worst margin in training",
        "worst passivity margin over random states at any step of the training",
        scale="linear",
        split="train",
    ),
    "passivity_margin_plant": Metric(
        "margin by the plant", "worst passivity margin by the plant's energy", scale="linear"
    ),
    "gains_energy": Metric(
        "gains energy", "share of random states where the plant's energy would rise", scale="linear"
    ),
    "damping_error": Metric("damping error", "relative error of C (Frobenius), or of one joint"),
    "min_eig_C": Metric("min eig C", "least eigenvalue of C", scale="linear", lower_is_better=False),
    "energy_error_2s": Metric("energy 2 s", "largest energy error within 2 s of free motion"),
    "energy_error_10s": Metric("energy 10 s", "largest energy error within 10 s of free motion"),
    "energy_error_40s": Metric("energy 40 s", "largest energy error within 40 s of free motion"),
    "energy_error_100s": Metric("energy 100 s", "largest energy error within 100 s of free motion"),
    "energy_error_worst": Metric("worst energy", "largest energy error of any start"),
    **{
        f"chain_{name}_{links}": Metric(f"{label}, {links} links", meaning)
        for links in (2, 5, 10, 30, 100, 1000, 10000)
        for name, label, meaning in (
            ("error", "state", "relative state error of the chain after 10 s"),
            ("energy_error", "energy", "energy error of the chain after 10 s over its first energy"),
            ("seconds", "time", "processor time of building and simulating the chain"),
        )
    },
    **{
        f"whole_chain_{name}_{links}": Metric(f"{label}, {links} links", meaning)
        for links in (2, 5, 10, 30, 100)
        for name, label, meaning in (
            ("error", "whole: state", "relative state error after 10 s of a chain that was learned as a whole"),
            ("seconds", "whole: time", "processor time of learning and simulating it"),
        )
    },
    "skill_tau": Metric(
        "skill τ",
        "1 - error of the force / that of the trivial model",
        scale="linear",
        lower_is_better=False,
    ),
    "skill_qdd": Metric(
        "skill q̈",
        "1 - error of the acceleration / that of the trivial model",
        scale="linear",
        lower_is_better=False,
    ),
}


def metric_named(name: str) -> Metric:
    """Look a metric up; a component such as mae_tau[1] shares its parent's scale; an unknown one averages plainly."""
    bare, on_free, _ = name.partition("@free")
    if on_free:
        on_d = metric_named(bare)
        return replace(on_d, label=f"{on_d.label} on D_H", split="free")
    parent, component = _split(name)
    known = METRICS.get(parent)
    if known is None:
        return Metric(name, name, scale="linear")
    if not component:
        return known
    return replace(known, label=f"{known.label}{component}")


def written(column: str, value: str) -> str:
    """Write a card value, as text, for people."""
    if column == "hidden" and value.isdigit():
        return f"1x{value}"
    return NAMES.get(value, value.replace("_", " ")) if column in TEXT_COLUMNS else value


def _split(name: str) -> tuple[str, str]:
    match = re.fullmatch(r"(.*?)(\[\d+\])?", name)
    return (match[1], match[2] or "") if match else (name, "")
