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
    from repro.pipeline.finished_run import open_run as load_run
    from repro.recording.notebook import show
    from repro.tracking.load import load_runs

# Public name -> the module that holds it, and its name there: loaded when it is used first.
PUBLIC = {
    "FittedModel": ("repro.library.fitted_model", "FittedModel"),
    "controller": ("repro.library.choices", "controller"),
    "dataset": ("repro.library.datasets", "dataset"),
    "dataset_from_frame": ("repro.library.datasets", "dataset_from_frame"),
    "fit": ("repro.library.fitting", "fit"),
    "load_run": ("repro.pipeline.finished_run", "open_run"),
    "load_runs": ("repro.tracking.load", "load_runs"),
    "metric": ("repro.library.choices", "metric"),
    "model": ("repro.library.choices", "model"),
    "objective": ("repro.library.choices", "objective"),
    "optimiser": ("repro.library.choices", "optimiser"),
    "sequence": ("repro.library.choices", "sequence"),
    "show": ("repro.recording.notebook", "show"),
    "simulate": ("repro.library.datasets", "simulate"),
    "system": ("repro.library.choices", "system"),
    "task": ("repro.library.choices", "task"),
}
__all__ = [
    "FittedModel", "controller", "dataset", "dataset_from_frame", "fit", "load_run", "load_runs", "metric", "model",
    "objective", "optimiser", "sequence", "show", "simulate", "system", "task",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in PUBLIC:
        raise AttributeError(f"module 'repro' has no attribute {name!r}; it has {', '.join(__all__)}")
    module, attribute = PUBLIC[name]
    return getattr(import_module(module), attribute)


def __dir__() -> list[str]:
    return __all__
