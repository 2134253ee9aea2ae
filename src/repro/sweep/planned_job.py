"""A job of a sweep before it runs: what it will make, whether that is there already, and about how long it takes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

from repro.config.compose import Composed, plan
from repro.pipeline.plan import Pipeline
from repro.tracking.paths import Paths
from repro.tracking.record import Record
from repro.tracking.store import Store


@dataclass(frozen=True)
class Planned:
    """A job with its pipeline, and its record when it is finished already."""

    composed: Composed
    pipeline: Pipeline
    record: Record | None = None

    @classmethod
    def of(cls, composed: Composed, store: Store | None = None) -> Self:
        """The job of a checked configuration; without a store nobody looks whether it is finished."""
        pipeline = Pipeline.of(composed.config, composed.command)
        return cls(composed, pipeline, None if store is None else pipeline.finished(store))

    @property
    def run(self) -> str:
        """The id that its run has or will have."""
        return self.pipeline.run_stage.id

    @property
    def label(self) -> str:
        """A short name for progress lines."""
        return f"{self.pipeline.name} {self.run.rpartition('-')[2][:6]}"

    def failures(self, store: Store) -> list[Record]:
        """Those of its stages whose last attempt failed."""
        stages = [*self.pipeline.stages, self.pipeline.recording_stage]
        found = (store.failure(stage.id, kind=stage.kind) for stage in stages)
        return [record for record in found if record is not None]

    @property
    def expected_seconds(self) -> float:
        """A rough guess from what was measured on two cores; it orders the jobs and sharpens the time left."""
        return self._fit_seconds + self._loop_seconds

    @property
    def _loop_seconds(self) -> float:
        config = self.pipeline.config
        if config.control.kind == "none":
            return 0.0
        loops = min(config.task.n_loops(len(config.members)), config.scale.loops)
        a_second = 0.06 if config.system.name == "sip" else 0.15
        return 3 + loops * config.task.seconds * a_second

    @property
    def _fit_seconds(self) -> float:
        config, optimiser = self.pipeline.config, self.pipeline.config.optimiser
        members = len(config.members)
        if not config.model.fitted:
            return 1.0
        if optimiser.unit == "epochs":
            units = sum(getattr(config.model, "hidden", ())) or 1
            samples = getattr(config.data, "samples", 10_000)
            return 2 + members * optimiser.length * samples * units * 1e-8
        if optimiser.unit == "iterations":
            phases = 1 + len(config.curriculum.episodes)
            return 3 + members * phases * optimiser.length * 4e-3
        return 3.0


def planned(
    jobs: Sequence[tuple[str, ...]], paths: Paths, on_unknown: Callable[[], None] = lambda: None
) -> list[Planned]:
    """Compose, check and look up the jobs (the overrides of each); UserError before anything runs.

    `on_unknown` is called when there is a job that was not planned before, so that there is likely something to run.
    """
    store = Store(paths.root)
    return [Planned.of(composed, store) for composed in plan(jobs, paths.composed, on_unknown)]
