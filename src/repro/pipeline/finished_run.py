"""A finished run, opened: what was chosen, its data, its model and the learned weights."""

from functools import cached_property
from pathlib import Path

from repro.codegen.lazy_torch import Tensor, torch
from repro.data.dataset import Dataset
from repro.errors import UserError
from repro.mechanics.system import System
from repro.models.model import Model
from repro.pipeline.stage_options import FitOptions
from repro.pipeline.stages.stored_fit import dataset, load_parameters, model_of, system_of
from repro.tracking.load import load_stage
from repro.tracking.plain_data import Json
from repro.tracking.record import Record


class OpenedRun(Record):
    """A stored run with the objects behind it.

    card     what was run, as the tables name it
    table    "metrics", "curves", "trajectories": data frames
    """

    @property
    def card(self) -> Json:
        """The run card."""
        return dict(self.summary["card"])

    @property
    def seeds(self) -> list[int]:
        """The seed of each member."""
        return list(self.card["seeds"])

    @cached_property
    def settings(self) -> FitOptions:
        """What the fit depends on: system, model, basis, objective, optimiser, sequence."""
        return FitOptions.stored(self._fit.identity.config)

    @cached_property
    def data(self) -> Dataset:
        """The dataset D, training part first."""
        return dataset(self.upstream["data"])

    @cached_property
    def system(self) -> System | None:
        """The true system; None for recordings of the user."""
        return system_of(self.settings) if self.settings.simulated else None

    @cached_property
    def model(self) -> Model:
        """The model; its weights are `parameters`."""
        return model_of(self.settings, self._fit.upstream)

    @cached_property
    def parameters(self) -> Tensor:
        """The learned weights (member, n_parameters); UserError when the model's code no longer fits them."""
        weights = torch.from_numpy(load_parameters(self._fit.folder))
        if weights.shape[1] != self.model.n_parameters:
            raise UserError(
                f"{self.id} has {weights.shape[1]} weights per seed, its model now takes {self.model.n_parameters}: "
                f"its code has changed; {self.provenance.command} makes it again"
            )
        return weights

    @cached_property
    def _fit(self) -> Record:
        return self.upstream["fit"]


def load_run(id: str, *, root: Path | str | None = None) -> Record:
    """Open a stored run.

    Parameters
    ----------
    id
        Of the run, its beginning, or the digits at its end.
    root
        Folder of the results; $REPRO_OUTPUTS, or `outputs`, by default.

    Returns
    -------
    OpenedRun or Record
        With `card`, `model`, `parameters` (member, n_parameters), `data`, `system` and `table(name)`; another stage
        comes with its tables alone.

    Raises
    ------
    UserError
        When none or several fit.
    """
    stage = load_stage(id, root=root)
    return OpenedRun(**vars(stage)) if stage.kind == "runs" else stage
