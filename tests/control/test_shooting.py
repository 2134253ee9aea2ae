"""The compiled programme of multiple shooting against CasADi's evaluation of the same programme."""

from contextlib import nullcontext
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from compilation import unoptimised
from optional import needs_compiler

from repro.control.optimal_control_problem import NodeWeights, Obstacle
from repro.control.predictive_model import PredictiveModel
from repro.control.programme import programme
from repro.control.solver import Limits, compiled_programme
from repro.control.transcription import Transcription
from repro.mechanics.system import load
from repro.models.bases import fxf
from repro.models.kinds import neural_potential, structured
from repro.models.kinds.neural_potential import NeuralPotential
from repro.models.kinds.structured import Structured
from repro.models.kinds.truth import Truth
from repro.models.lagrangian import Lagrangian

pytestmark = needs_compiler

SCALE = np.array([0.9, 5.0])
LARGE = {"angle_error": "square", "stage_cost": NodeWeights(kinetic=0.3, angle=2.0, position=1.0, rates=0.1)}
BY_NAME = NodeWeights(potential=0.2, position={"x": 1.0, "theta": 0.5}, force={"left_thrust": 0.1}, rates=0.1)
HARD = Obstacle(constraint=True, midpoints=True)
CASES = {
    "soft": ("sip", Truth, {}),
    "hard": ("sip", Truth, {"obstacle": HARD}),
    "nodes": ("sip", Truth, {"obstacle": Obstacle(constraint=True, midpoints=False)}),
    "four": ("sip", Truth, {"substeps": 4}),
    "free": ("sip", Truth, {"obstacle": None} | LARGE),
    "structured": (
        "sip",
        lambda system: Structured(2, SCALE, structured.Options(hidden=(4,))),
        {"intervals": (0.04,) * 8},
    ),
    "double": (
        "dip",
        Truth,
        {"obstacle": HARD, "intervals": (0.04,) * 7 + (0.08,) * 2},
    ),
    "two inputs": (
        "quadrotor",
        lambda system: NeuralPotential(np.ones(3), np.ones(3), (2,), neural_potential.Options(hidden=(2,))),
        {"obstacle": HARD, "intervals": (0.04,) * 5, "potential_goal": "goal", "stage_cost": BY_NAME},
    ),
    "torque between": (
        "acrobot",
        lambda system: NeuralPotential(np.ones(2), np.ones(2), (0, 1), neural_potential.Options(hidden=(2,))),
        {"intervals": (0.04,) * 3, "potential_goal": "minimum", "stage_cost": NodeWeights(angle=1.0, force=0.1)},
    ),
    "basis": ("dip", lambda system: Lagrangian(fxf, 3), {"intervals": (0.04,) * 2}),
}
# The long ones, of statements that the other cases compile with all optimisations.
LONG = ("double", "two inputs", "torque between", "basis")


@pytest.mark.parametrize("case", CASES)
def test_every_function_is_that_of_the_programme(problem, case):
    name, make, changes = CASES[case]
    changes = dict(changes)
    substeps = changes.pop("substeps", 2)
    system = load(name)
    model = make(system)
    of = Transcription(PredictiveModel(model, system), replace(problem, **changes), "shooting", substeps)
    with unoptimised() if case in LONG else nullcontext():
        library = compiled_programme(of, Limits()).library
    made = programme(of)
    inputs = [made.inputs[name] for name in ("x", "p", "lam_f", "lam_g")]
    names = ("f", "g", "grad_f_x", "jac_g_x", "grad_gamma_x", "hess_gamma_x_x")
    results = [made.outputs[name] for name in names]
    reference = ca.Function("reference", inputs, results)
    compiled = {name: ca.external(f"nlp_{name}", library) for name in ("f", "g", "grad_f", "jac_g", "hess_l", "grad")}
    generator = np.random.default_rng(0)
    (weights,) = model.initial([generator])
    for _ in range(2):
        x = generator.normal(size=of.n_variables)
        p = of.parameters(generator.normal(size=of.n_x), generator.normal(size=system.n_q), weights)
        multipliers = 0.7, generator.normal(size=sum(of.rows))
        f, g, grad_f, jac_g, grad_l, hess_l = (np.asarray(part) for part in reference(x, p, *multipliers))
        gradient, hessian = compiled["hess_l"](x, p, *multipliers)
        pairs = [(compiled["f"](x, p), f), (compiled["g"](x, p), g), (compiled["grad_f"](x, p), grad_f)]
        pairs += zip(compiled["jac_g"](x, p), (g, jac_g), strict=True)
        pairs += [(gradient, grad_l), (hessian, hess_l)]
        pairs += zip(compiled["grad"](x, p, *multipliers)[:3], (f, g, grad_l), strict=True)
        for ours, expected in pairs:
            scale = 1 + np.abs(expected).max()
            np.testing.assert_allclose(np.asarray(ours), expected, rtol=0, atol=1e-11 * scale)


@pytest.mark.parametrize("case", ["double", "structured"])
def test_sines_of_recent_angles_are_those_of_their_angles(problem, case):
    """Back at a point after many others its Hessian has the same bits, also where an angle or a lane is 0."""
    name, make, changes = CASES[case]
    system = load(name)
    model = make(system)
    of = Transcription(PredictiveModel(model, system), replace(problem, **changes), "shooting")
    hessian = ca.external("nlp_hess_l", compiled_programme(of, Limits()).library)
    generator = np.random.default_rng(1)
    (weights,) = model.initial([generator])
    p = of.parameters(generator.normal(size=of.n_x), generator.normal(size=system.n_q), weights)
    points = np.concatenate([np.zeros((1, of.n_variables)), generator.normal(size=(40, of.n_variables))])
    multipliers = 1.0, generator.normal(size=sum(of.rows))
    there = [np.asarray(hessian(x, p, *multipliers)[1]) for x in points]
    back = [np.asarray(hessian(x, p, *multipliers)[1]) for x in points[::-1]]
    np.testing.assert_array_equal(there, back[::-1])
    nothing = np.asarray(programme(of).function("hessian", ["hess_gamma_x_x"])(points[0], p, *multipliers))
    np.testing.assert_allclose(there[0], nothing, rtol=0, atol=1e-11 * (1 + np.abs(nothing).max()))
