"""The columns that say what a run was: which settings each of them shows, and how.

A setting is known by its dotted key in the configuration, such as `model.hidden`. This is the one place where a column
is tied to settings: whatever no column shows stands in the column `options`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

Settings = Mapping[str, object]
NOISES = ("data.tau_noise", "data.qdd_noise", "data.q_noise", "data.qd_noise")


@dataclass(frozen=True)
class Column:
    """One column."""

    kind: type  # type of its values
    keys: tuple[str, ...] = ()  # settings that it shows, so that `options` need not
    show: Callable[[Settings], object] | None = None  # its value; without it that of the first key that the run has

    def value(self, settings: Settings) -> object:
        """The value for a run of these settings; None where it has none."""
        if self.show is not None:
            return self.show(settings)
        return next((settings[key] for key in self.keys if key in settings), None)


def _layers(key: str) -> Callable[[Settings], str | None]:
    """10, 2x32 or 10-5: layers times width where all are equal."""

    def show(settings: Settings) -> str | None:
        hidden = settings.get(key)
        if not isinstance(hidden, list) or not hidden:
            return None
        if len(hidden) > 1 and len(set(hidden)) == 1:
            return f"{len(hidden)}x{hidden[0]}"
        return "-".join(str(units) for units in hidden)

    return show


def _joined(key: str) -> Callable[[Settings], str | None]:
    def show(settings: Settings) -> str | None:
        values = settings.get(key)
        return "-".join(f"{value:g}" for value in values) if isinstance(values, list) else None

    return show


def _optimiser(settings: Settings) -> str | None:
    if "optimiser.name" not in settings:
        return None
    penalised = settings.get("objective.l1_kinetic") or settings.get("objective.l1_potential")
    from_start = settings.get("optimiser.regularise_towards") == "start"
    return f"{settings['optimiser.name']}{'_l1' * bool(penalised)}{'_from_start' * from_start}"


def _file(settings: Settings) -> str | None:
    """Names of the files or folders of a recording, without their folders."""
    paths = settings.get("data.path")
    named = [paths] if isinstance(paths, str) else list(paths) if isinstance(paths, list | tuple) else []
    return ", ".join(str(path).rstrip("/").rpartition("/")[2] for path in named) or None


def _grid(settings: Settings) -> str | None:
    grid = settings.get("sequence.grid")
    return None if grid is None else f"{grid} of {settings['sequence.initial_angles']}"


def _pretraining_epochs(settings: Settings) -> object:
    if "sequence.pretraining_epochs" not in settings:
        return None
    return settings["sequence.pretraining_epochs"] or settings.get("optimiser.epochs")


def _controller(settings: Settings) -> object:
    return None if settings.get("control.kind") == "none" else settings.get("control.name")


def _number(settings: Settings, key: str) -> float:
    value = settings.get(key, 0.0)
    return float(value) if isinstance(value, int | float) else 0.0


def _intervals(settings: Settings) -> int:
    return int(_number(settings, "control.intervals") + _number(settings, "control.coarse_intervals"))


def _horizon(settings: Settings) -> float:
    fine = _number(settings, "control.intervals") * _number(settings, "control.time_step")
    coarse = _number(settings, "control.coarse_intervals") * _number(settings, "control.coarse_step")
    return round(fine + coarse, 9)  # a sum of decimal steps, without the rounding of binary fractions


# The values of `n_train` and `epochs` are measured by the run (see `run_card`).
RUN: Mapping[str, Column] = {
    "system": Column(str, ("system.name",)),
    "reading": Column(str, ("reading.name",)),
    "regime": Column(str, ("data.regime", "data.source")),
    "file": Column(str, ("data.path",), _file),
    "labels": Column(str, ("data.labels",)),
    "noise": Column(str, (), lambda settings: any(settings.get(key) for key in NOISES)),
    "model": Column(str, ("model.kind",)),
    "basis": Column(str, ("basis.name",)),
    "hidden": Column(str, ("model.hidden",), _layers("model.hidden")),
    "options": Column(str),
    "objective": Column(str, ("objective.kind",)),
    "optimiser": Column(str, ("optimiser.name", "optimiser.regularise_towards"), _optimiser),
    "sequence": Column(str, ("sequence.kind",)),
    "grid": Column(str, ("sequence.grid", "sequence.initial_angles"), _grid),
    "pretraining_epochs": Column(int, ("sequence.pretraining_epochs",), _pretraining_epochs),
    "reset": Column(str, ("data.reset",)),
    "tau_noise": Column(float, ("data.tau_noise",)),
    "qdd_noise": Column(float, ("data.qdd_noise",)),
    "damping": Column(str, ("system.damping",)),
    "samples": Column(int, ("data.samples",)),
    "n_train": Column(int, ("data.train_samples",)),
    "episode_steps": Column(int, ("data.episode_steps",)),
    "energies": Column(str, ("energies.gauge",)),
    "energy_form": Column(str, ("sequence.energy_form",)),
    "momentum_weight": Column(float, ("objective.momentum_weight",)),
    "momentum_hidden": Column(str, ("model.momentum_hidden",), _layers("model.momentum_hidden")),
    "curriculum": Column(str, ("curriculum.episodes",), _joined("curriculum.episodes")),
    "epochs": Column(int, ("optimiser.epochs",)),
    "control": Column(str, ("control.name",), _controller),
    "task": Column(str, ("task.name",)),
}

# The columns of a closed loop: those of its model, and what it had to do.
LOOP: Mapping[str, Column] = {
    **{name: RUN[name] for name in ("system", "model", "basis", "hidden", "objective", "optimiser", "energies")},
    "controller": Column(str, ("control.kind",)),
    "setting": Column(str, ("control.name",)),
    "intervals": Column(int, ("control.intervals",), _intervals),
    "horizon_s": Column(float, (), _horizon),
    "adaptive": Column(bool, ("control.adaptive",), lambda settings: bool(settings.get("control.adaptive"))),
    "discretisation": Column(str, ("control.discretisation",)),
    "solver": Column(str, ("control.solver",)),
    "task": Column(str, ("task.name",)),
    "seconds": Column(float, ("task.seconds",)),
    "mismatch": Column(float, ("task.mismatch",)),
    "mismatch_kind": Column(str, ("task.mismatch_kind",)),
    "noise": Column(float, ("task.noise",)),
    "disturbance": Column(float, ("task.disturbance",)),
    "delay": Column(float, ("task.delay",)),
    "friction": Column(str, ("task.damping",), _joined("task.damping")),
    "options": Column(str),
}
