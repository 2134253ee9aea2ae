"""Models made of trained sub-models: from settings, from run ids, opened again, exported."""

import numpy as np
import pytest
import torch

import repro
from repro import __main__ as cli
from repro.config.compose import compose
from repro.config.submodels import fit_of
from repro.errors import UserError
from repro.evaluation.predictions import predict
from repro.pipeline.plan import Pipeline
from repro.pipeline.run import execute
from repro.tracking.store import Store

TINY = ["scale=smoke", "data.samples=300", "data.episode_steps=20", "data.reset=random", "record=false"]
CART = "system=sip_rod basis=t1 optimiser=least_squares data.samples=200 data.episode_steps=20 data.reset=random"
ROD = "system=rod basis=rigid_body optimiser=least_squares data.samples=100 data.episode_steps=20 data.reset=random"
HINGED = ["system=dip", "model=hinged", "optimiser=least_squares"]


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("outputs")
        patch.setenv("REPRO_OUTPUTS", str(folder))
        yield folder


def _pipeline(*overrides, seeds="[4,7]"):
    composed = compose([*TINY, f"seeds={seeds}", *overrides])
    return Pipeline.of(composed.config, composed.command)


def _made(outputs, *overrides, seeds="[4,7]"):
    return execute(_pipeline(*overrides, seeds=seeds), Store(outputs))


@pytest.fixture(scope="module")
def hinged(outputs):
    return _made(outputs, *HINGED, f"model.parts=['{CART}','{ROD}']")


def test_sub_models_make_the_double_pendulum_without_a_sample_of_it(hinged):
    """The weights are those of the parts, and the errors are those of rounding."""
    run = repro.load_run(hinged.id)
    assert run.table("metrics").set_index(["split", "metric"]).value["test", "mae_qdd"].max() < 1e-10
    expected = np.array([0.4, 0.2 * 0.25 / 6, 0.05, 0.49, 0.1, 0.2 * 0.25 / 24, 1.96])
    np.testing.assert_allclose(run.parameters, [expected] * 2, rtol=1e-8)


def test_what_is_composed_opens_and_exports_like_any_other(hinged, tmp_path):
    run = repro.load_run(hinged.id)
    test = run.data.test
    said = predict(run.model, run.parameters, test.q, test.qd, test.qdd, test.tau)
    np.testing.assert_allclose(said.tau, test.tau, atol=1e-9)
    assert cli.main(["export", hinged.id, str(tmp_path / "exported")]) == 0
    assert (tmp_path / "exported" / "forward.casadi").is_file()


def test_a_part_may_be_the_id_of_a_run(outputs, hinged):
    """Settings and id name the same fit, and so the same weights; the seeds are picked by their number."""
    cart = repro.load_run(hinged.id).upstream["fit"].upstream["part_1"]
    run = next(r for r in Store(outputs).records("runs") if r.identity.upstream["fit"] == cart.id)
    assert fit_of(run.id).id == fit_of(cart.id).id == cart.id
    single = _made(outputs, *HINGED, f"model.parts=[{run.id}]", "model.rod=mass", seeds="[7]")
    weights = repro.load_run(single.id).parameters
    np.testing.assert_array_equal(weights[0, :4], repro.load_run(hinged.id).parameters[1, :4])
    assert weights[0, 4] == pytest.approx(0.2, rel=1e-8)


def test_frozen_parts_stay_and_others_are_fitted(outputs):
    options = ["system=dip", "model=extended", "model.hidden=[3]", "optimiser.iterations=5", "optimiser.restarts=1"]
    options += [f"model.parts=['{CART}']", "optimiser=levenberg_marquardt", "scale.iterations=1"]
    weights = [
        repro.load_run(_made(outputs, *options, f"model.frozen={frozen}").id).parameters[:, :4]
        for frozen in ("true", "false")
    ]
    (cart,) = (p.fit_stage.id for p in _pipeline(*options).part_pipelines)
    given = torch.from_numpy(np.load(outputs / "fits" / cart / "parameters.npz")["parameters"])
    assert torch.equal(weights[0], given)
    assert not torch.equal(weights[1], given)


def test_closed_form_fits_around_a_frozen_part(outputs):
    options = ["system=dip", "model=extended", "model.rest=basis", "basis=fxf", "optimiser=least_squares"]
    run = _made(outputs, *options, f"model.parts=['{CART}']")
    assert repro.load_run(run.id).table("metrics").set_index(["split", "metric"]).value["test", "mae_tau"].max() < 1e-9


def test_an_other_sub_model_is_an_other_run(outputs):
    """What a part is trained on is part of what the whole is."""
    more = CART.replace("samples=200", "samples=201")
    first, second = (_pipeline(*HINGED, f"model.parts=['{cart}','{ROD}']").fit_stage for cart in (CART, more))
    assert first.id != second.id
    assert first.upstream["part_1"] != second.upstream["part_1"]
    assert first.upstream["part_2"] == second.upstream["part_2"]


def test_settings_may_be_written_without_anything_to_quote(outputs):
    plain = [part.replace("=", ":").replace(" ", "+") for part in (CART, ROD)]
    one, other = (
        _pipeline(*HINGED, f"model.parts={parts}") for parts in (f"['{CART}','{ROD}']", f"[{','.join(plain)}]")
    )
    assert [p.fit_stage.id for p in one.part_pipelines] == [p.fit_stage.id for p in other.part_pipelines]


def test_seeds_that_a_part_does_not_have_are_named(outputs, hinged):
    cart = repro.load_run(hinged.id).upstream["fit"].upstream["part_1"]
    with pytest.raises(Exception, match=r"has the seeds \[4, 7\], and not \[5\]"):
        _made(outputs, *HINGED, f"model.parts=[{cart.id}]", "model.rod=mass", seeds="[5]")


def test_what_is_no_fit_is_refused(outputs, hinged):
    data = hinged.identity.upstream["data"]
    with pytest.raises(UserError, match="is one of data; give the id of a run"):
        fit_of(data)
