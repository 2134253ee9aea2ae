"""Maximum likelihood of weights and motion together, from what sensors recorded."""

from dataclasses import dataclass, field

from repro.data.dataset import Dataset
from repro.learning.objectives import balance
from repro.learning.path.path_fit import PathOptions, fit_paths
from repro.learning.result import Fitted, Progress, Weights
from repro.models.model import Model


@dataclass(frozen=True)
class Options(balance.Options):
    """Options of objective=path, which starts from a fit of the momentum balance."""

    path: PathOptions = field(default_factory=PathOptions)

    @property
    def is_likelihood(self) -> bool:
        """Of the recorded positions and velocities."""
        return True

    @property
    def expects_unit_cost(self) -> bool:
        """Where the noise of the sensors is known."""
        return self.path.noise == "given"

    def finished(self, model: Model, dataset: Dataset, fitted: Fitted, initial: Weights, progress: Progress) -> Fitted:
        """Weights of maximum likelihood, and their information."""
        return fit_paths(model, dataset, self.path, fitted, initial, progress)
