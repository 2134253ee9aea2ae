"""The code that a stage executes is the code that its identity names: an edit of it makes the result stale."""

import inspect
import sys

import pytest

from repro.config.compose import compose
from repro.pipeline.plan import Pipeline
from repro.pipeline.run import execute
from repro.tracking import code
from repro.tracking.store import Store

# What a stage may execute without naming it, and why.
EXEMPT = {
    "repro.errors": "texts of errors",
    "repro.tracking": "where results lie and what is reported on the way",
    "repro.pipeline.run": "hands options and upstream stages over",
    "repro.pipeline.card": "describes a run; no number that is measured depends on it",
    "repro.results": "as the card",
    "repro.config": "as the card; what stages depend on are the options that it makes, which are in their identity",
}
TINY = ("scale=smoke", "data.samples=120", "data.episode_steps=40", "seeds=1")
CASES = {
    "closed form": ("basis=t1", "optimiser=least_squares", "energies=canonical_anchor", "energies.horizons=[0.2]"),
    "pretrained": ("model=structured", "optimiser=levenberg_marquardt", "sequence=pretrain", "record=false"),
    "port": ("model=port_hamiltonian", "objective=port", "optimiser=lbfgs", "record=false"),
    "curriculum": ("curriculum=growing_episodes", "objective.passivity_states=5", "record=false"),
    "chains": ("system=link", "model=neural_potential", "optimiser=lbfgs", "chain=[2]", "whole_chain=[2]"),
    "loop": ("model=truth", "control=energy_shaping", "task.seconds=2"),
    "predictive loop": ("model=truth", "control=sip_adaptive", "control.intervals=5", "task.seconds=2", "record=false"),
    "parts": ("system=dip", "model=extended", "model.rest=basis", "basis=fxf", "optimiser=least_squares"),
}


def _is_exempt(module):
    return any(module == name or module.startswith(f"{name}.") for name in EXEMPT)


def _functions_of(module, frame, event):
    """Whether an event is the call of a function of this package.

    Bodies of modules and classes are imports; `<string>` holds the methods that dataclasses generate, which caches call
    to compare what earlier tests have left there.
    """
    own = module.startswith("repro.") and frame.f_code.co_filename != "<string>"
    return event == "call" and own and frame.f_code.co_flags & inspect.CO_OPTIMIZED


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_a_stage_names_the_code_that_it_executes(case, tmp_path, monkeypatch):
    executed, stages = {}, {}
    compute = Store.compute

    def profiled(store, stage, work):
        modules = executed.setdefault(stage.id, set())
        stages[stage.id] = stage

        def collect(frame, event, _):
            module = frame.f_globals.get("__name__", "")
            if _functions_of(module, frame, event):
                modules.add(module)

        def traced(folder):
            sys.setprofile(collect)
            try:
                return work(folder)
            finally:
                sys.setprofile(None)

        return compute(store, stage, traced)

    monkeypatch.setattr(Store, "compute", profiled)
    composed = compose((*TINY, *CASES[case]))
    execute(Pipeline.of(composed.config, composed.command), Store(tmp_path))
    for id, stage in stages.items():
        named = set(code.closure(stage.modules).code)
        for upstream in stage.upstream.values():
            named |= set(code.closure(stages[upstream].modules).code)
        missing = sorted(module for module in executed[id] - named if not _is_exempt(module))
        assert executed[id] and not missing, f"{stage.kind} executes {', '.join(missing)}"
