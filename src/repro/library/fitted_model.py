"""A fitted ensemble, and what can be done with it."""

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from repro.control.controller import ControllerOptions
from repro.control.task import LoopPlan, Task
from repro.data.dataset import Dataset
from repro.errors import UserError
from repro.evaluation.metric_options import MetricOptions
from repro.evaluation.pointwise import pointwise
from repro.learning.result import Progress, silent
from repro.library import choices
from repro.library.closed_loops import Controlled, closed_loops
from repro.library.datasets import for_members
from repro.library.ensemble_model import Ensemble
from repro.mechanics.system import System
from repro.models.gauge import Gauge

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from repro.library.fit_uncertainty import FitUncertainty

WEIGHTS, ABOUT = "weights.npz", "about.json"


@dataclass(frozen=True)
class FittedModel(Ensemble):
    """What `repro.fit` returns: an ensemble, and what is done with it."""

    def control(
        self,
        task: Task,
        controller: str | ControllerOptions = "mpc",
        *,
        plant: System | None = None,
        canonical: bool = True,
        progress: Progress = silent,
    ) -> Controlled:
        """Drive a plant with the model, from every start of a task; the members take turns.

        Parameters
        ----------
        task
            What `repro.task` returns: starts, goals, obstacle, disturbances.
        controller
            A name, or what `repro.controller` returns: horizon, weights, limits of the inputs.
        plant
            The system that is driven, by default the one that the model was fitted to.
        canonical
            Whether the energies in the cost are in the gauge in which T is 0 and least at rest.
        progress
            Called with the share that is done and a few words.

        Returns
        -------
        Controlled
            `loops`, each with time (s), states (n, 2 n_q), inputs (steps, n_u) and outcome; `success`, their share.

        Raises
        ------
        UserError
            Where no plant is known, the task or the controller does not fit it, or the model has no expressions.
        """
        system = self.system if plant is None else plant
        if system is None:
            raise UserError('control: no plant is known; give one, such as plant=repro.system("sip")')
        options = choices.controller(controller) if isinstance(controller, str) else controller
        problems = [*task.problems(system, options), *options.problems(system)]
        if not options.fits(system):
            problems.append(f"{options.kind} drives {options.drives}, not {system.name}")
        if problems:
            raise UserError("; ".join(problems))
        plan = LoopPlan(controller=options, task=task, loops=task.n_loops(self.members), canonical=canonical)
        return Controlled([loop for _, _, loop in closed_loops(self, system, plan, progress)])

    def score(self, data: Dataset | None = None, metric: str | MetricOptions = "none") -> "pd.DataFrame":
        """Errors on the test part of the data.

        Parameters
        ----------
        data
            Those of the fit by default; energies are compared where the true system is known.
        metric
            A further metric: a name, or what `repro.metric` returns.

        Returns
        -------
        pandas.DataFrame
            A row per metric with its unit, and a column per seed; names as in docs/results.md.

        Raises
        ------
        UserError
            For data with another number of members, and for a metric that does not exist.
        """
        import pandas as pd

        part = for_members(self.data if data is None else data, self.members).test
        chosen = choices.metric(metric) if isinstance(metric, str) else metric
        metrics = [
            *pointwise(self.model, self.weights_, part, self.system, "test", Gauge.CANONICAL),
            *chosen.measure(self.model, self.weights_, part, self.system, "test"),
        ]
        rows = {metric.name: (metric.unit, *metric.values) for metric in metrics}
        return pd.DataFrame.from_dict(rows, orient="index", columns=["unit", *self.seeds])

    def plot(self) -> "Figure":
        """Draw the first member over the test part.

        Returns
        -------
        matplotlib.figure.Figure
            Measured and predicted forces (N, N m), energies (J) and the learning curve.
        """
        from repro.library.plot import plot

        return plot(self)

    def record(self, path: Path | str) -> Path:
        """Write a rerun recording of the first member over the first test samples, with the learning curves.

        Parameters
        ----------
        path
            The file to write, `.rrd`; `rerun FILE` opens it, and `repro view FILE` does too.

        Returns
        -------
        Path
            The file. In a notebook, `repro.show(path)` shows it where the viewer allows.

        Raises
        ------
        UserError
            For a model without weights, which has no motion of its own.
        """
        from repro.library.run_recording import record_ensemble

        return record_ensemble(self, Path(path))

    def uncertainty(self) -> "FitUncertainty":
        """How well the data determine the weights.

        Of objective="path" it is the Fisher information of the fit. Otherwise the errors of tau over the training part
        are taken as independent between samples, of zero mean and of one variance for each component.

        Returns
        -------
        FitUncertainty
            `table` and `standard_errors` of the weights, and `tau(q, qd, qdd)`: the standard deviation of the predicted
            force (member, ..., n_q) in N or N m.

        Raises
        ------
        UserError
            For a model that predicts no tau.
        """
        from repro.library.fit_uncertainty import fit_uncertainty

        return fit_uncertainty(self)

    def export(self, folder: Path | str, member: int = 0) -> list[str]:
        """Write one member as CasADi functions, C and a torch module that need nothing of this project.

        Parameters
        ----------
        folder
            A new or an empty one.
        member
            From 0.

        Returns
        -------
        list of str
            The names of the files.

        Raises
        ------
        UserError
            When the folder has content, or the model has no symbolic form.
        """
        from repro.export.member import LearnedMember, write

        if self.model.not_symbolic is not None:
            raise UserError(f"export needs the model as expressions: {self.model.not_symbolic}")
        card: dict[str, object] = {"model": type(self.model).__name__, "data": dict(self.data.provenance)}
        name = "recorded" if self.system is None else self.system.name
        exported = LearnedMember(
            "fit", self.seeds[member], name, "repro.fit", card, self.model, self.weights_[member], self.data.coordinates
        )
        return write(exported, Path(folder))

    def save(self, folder: Path | str) -> None:
        """Write weights and data into a folder, for `load`.

        Parameters
        ----------
        folder
            Is made where it is missing.
        """
        folder = Path(folder)
        self.data.save(folder)
        arrays = {"weights": self.weights_} | ({} if self.information_ is None else {"information": self.information_})
        np.savez(folder / WEIGHTS, **arrays)  # type: ignore[arg-type]
        about = {"seeds": list(self.seeds), "status": list(self.status_), "seconds": self.seconds_}
        (folder / ABOUT).write_text(json.dumps(about, indent=2) + "\n")

    def load(self, folder: Path | str) -> "FittedModel":
        """Read back what `save` wrote.

        Parameters
        ----------
        folder
            That `save` has written.

        Returns
        -------
        FittedModel
            The same model with those weights and data.

        Raises
        ------
        UserError
            For a folder without a fitted model, or with weights of another model.
        """
        folder = Path(folder)
        try:
            about = json.loads((folder / ABOUT).read_text())
            with np.load(folder / WEIGHTS) as stored:
                weights, information = stored["weights"], stored.get("information")
        except (OSError, ValueError, KeyError) as error:
            raise UserError(f"{folder} holds no fitted model ({error})") from error
        if weights.shape[1] != self.model.n_parameters:
            raise UserError(f"{folder} has {weights.shape[1]} weights per seed, this model {self.model.n_parameters}")
        return replace(
            self, weights_=weights, information_=information, seeds=tuple(about["seeds"]), curves_=(),
            status_=tuple(about["status"]), seconds_=about["seconds"], data=Dataset.load(folder),
        )  # fmt: skip

    def _repr_html_(self) -> str:
        medians = self.score().drop(columns="unit").median(axis=1)
        shown = medians[[name for name in medians.index if "[" not in name]]
        body = "".join(f"<tr><td>{name}</td><td>{value:.3g}</td></tr>" for name, value in shown.items())
        return (
            f"<b>{type(self.model).__name__}</b>: {self.model.n_parameters} weights, {self.members} seeds, "
            f"{self.seconds_:.2f} CPU s<table><tr><th>median on test data</th><th></th></tr>{body}</table>"
        )
