"""What the rules accept can be run: every system, model, basis and objective, each for one step of an optimiser."""

import itertools
from pathlib import Path

import pytest
from configurations import changed

from repro.config.registry import groups
from repro.errors import UserError
from repro.pipeline.plan import Pipeline
from repro.pipeline.run import execute
from repro.tracking.store import Store

SMALL = (
    *("scale=smoke", "seeds=1", "record=false", "data.samples=60", "data.episode_steps=20", "data.reset=random"),
    *("optimiser=lbfgs", "optimiser.iterations=1"),
)
OBJECTIVES = groups()["objective"]
PAIRS = [*itertools.product(groups()["system"], groups()["model"])]
# The paper's system with every model, every system with the general model and two anchor rows; the others are slow.
QUICK = {pair for pair in PAIRS if pair[0] == "sip" or pair[1] in ("structured", "truth", "degenerate")}
MARKED = [pair if pair in QUICK else pytest.param(*pair, marks=pytest.mark.slow) for pair in PAIRS]


def _bases(model: str) -> list[str]:
    """The bases that make a difference to a model."""
    return groups()["basis"] if model == "lagrangian" else ["t2"]


def _accepted(system: str, model: str, basis: str, objective: str) -> Pipeline | None:
    try:
        config = changed(SMALL, system=system, model=model, basis=basis, objective=objective)
    except UserError:
        return None
    return Pipeline.of(config, "")


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    """One store for all, so that the data of a system are made once."""
    return Store(Path(tmp_path_factory.mktemp("combinations")))


@pytest.mark.parametrize(("system", "model"), MARKED)
def test_an_accepted_pair_of_system_and_model_runs(system, model, store):
    """With the first basis and objective that are accepted."""
    candidates = (_accepted(system, model, *rest) for rest in itertools.product(_bases(model), OBJECTIVES))
    pipeline = next((candidate for candidate in candidates if candidate is not None), None)
    if pipeline is not None:
        assert execute(pipeline, store).summary["median"]


@pytest.mark.slow
@pytest.mark.parametrize(("system", "model"), PAIRS)
def test_every_accepted_basis_and_objective_runs(system, model, store):
    failed = []
    for basis, objective in itertools.product(_bases(model), OBJECTIVES):
        pipeline = _accepted(system, model, basis, objective)
        if pipeline is not None:
            try:
                execute(pipeline, store)
            except Exception as error:
                failed.append(f"basis={basis} objective={objective}: {error}")
    assert not failed, "\n".join(failed)
