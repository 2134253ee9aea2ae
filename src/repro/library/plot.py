"""What a fit looks like: forces, energies and the learning curve of one member."""

import numpy as np
from matplotlib.figure import Figure

from repro.data.dataset import units
from repro.library.ensemble_model import Ensemble

POINTS = 300
STYLES = {"measured": {"color": "#111111", "ls": "-"}, "model": {"color": "#d55e00", "ls": "--"}}


def plot(fitted: Ensemble) -> Figure:
    """One axis for each force, one for the energies, one for the learning curve; of the first member."""
    first, model = fitted.member(0), fitted.model
    part = first.data.test
    shown = slice(0, min(POINTS, part.samples))
    q, qd, qdd, tau = (array[0, shown] for array in (part.q, part.qd, part.qdd, part.tau))
    time = part.time[shown] - part.time[0]
    if model.inverse:
        name, quantity, measured, predicted = "force on", "tau", tau, first.tau(q, qd, qdd)[0]
    else:
        name, quantity, measured, predicted = "acceleration of", "qdd", qdd, first.acceleration(q, qd, tau)[0]
    names = units(part.coordinates)[quantity]
    figure = Figure(figsize=(7, 1.9 * (part.n_q + 2)), layout="constrained")
    axes = figure.subplots(part.n_q + 2)
    for index, (axis, coordinate) in enumerate(zip(axes, part.coordinates, strict=False)):
        axis.plot(time, measured[:, index], label="measured", **STYLES["measured"])
        axis.plot(time, predicted[:, index], label="model", **STYLES["model"])
        axis.set(ylabel=f"{name} {coordinate.name}, {names[index]}", xlabel="time, s")
        axis.legend(loc="upper right")
    if model.energetic:
        energies = first.energies(q, qd)
        for label, values, style in (
            ("T", energies.kinetic, ":"), ("V", energies.potential, "--"), ("H", energies.hamiltonian, "-")
        ):  # fmt: skip
            axes[-2].plot(time, values[0], style, color="#111111", label=label)
        axes[-2].legend(loc="upper right")
    axes[-2].set(ylabel="energy, J", xlabel="time, s")
    losses = [(step, values[0]) for step, label, values in first.curves_ if label == "loss"]
    if losses:
        axes[-1].semilogy(*np.transpose(losses), color="#111111")
    axes[-1].set(ylabel="loss", xlabel="step of the optimiser")
    return figure
