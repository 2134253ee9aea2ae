"""Learned Lagrangians, port-Hamiltonian structure and energy-based control, from Python.

>>> import repro
>>> data = repro.simulate("sip", samples=1000, reset="random")
>>> fitted = repro.fit(data, "lagrangian", basis="t1", optimiser="least_squares")
>>> fitted.mass_matrix([0.0, 0.5]).shape
(1, 2, 2)
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from repro.library.choices import controller, metric, model, objective, optimiser, sequence, system, task
    from repro.library.datasets import dataset, dataset_from_frame, simulate
    from repro.library.fitted_model import FittedModel
    from repro.library.fitting import fit
    from repro.pipeline.finished_run import load_run
    from repro.recording.notebook import show
    from repro.tracking.load import load_runs

# Module -> the public names in it: loaded when one of them is used first.
PUBLIC = {
    "library.choices": ("controller", "metric", "model", "objective", "optimiser", "sequence", "system", "task"),
    "library.datasets": ("dataset", "dataset_from_frame", "simulate"),
    "library.fitted_model": ("FittedModel",),
    "library.fitting": ("fit",),
    "pipeline.finished_run": ("load_run",),
    "recording.notebook": ("show",),
    "tracking.load": ("load_runs",),
}
__all__ = [
    "FittedModel", "controller", "dataset", "dataset_from_frame", "fit", "load_run", "load_runs", "metric", "model",
    "objective", "optimiser", "sequence", "show", "simulate", "system", "task",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    for module, names in PUBLIC.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{module}"), name)
    raise AttributeError(f"module 'repro' has no attribute {name!r}; it has {', '.join(__all__)}")


def __dir__() -> list[str]:
    return __all__
