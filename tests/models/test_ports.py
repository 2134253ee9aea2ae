"""The interconnection of port-Hamiltonian systems is port-Hamiltonian, with the sum of their energies."""

import subprocess
import sys
from pathlib import Path

import casadi
import numpy as np
import pytest

from repro.codegen.array_evaluation import evaluate
from repro.mechanics.system import load
from repro.models.bases import spring
from repro.models.damped import Damped
from repro.models.lagrangian import Lagrangian
from repro.models.ports import ChainLink, PortSystem, interconnect, link_chain

LINK = load("link", damping=[0.3])
STATUS = Path("/proc/self/status")
# prints by how many KiB the peak of a process of its own grows while it builds a chain of 3,000 links
GROWTH = """
import re
from pathlib import Path
from repro.models.ports import ChainLink, link_chain

def peak():
    return int(re.search(r"VmHWM:\\s*(\\d+) kB", Path("/proc/self/status").read_text())[1])

before = peak()
link_chain(ChainLink(1.0, 0.1, lambda s: s**2), 3000)
print(peak() - before)
"""


def _random_system(n, ports, seed):
    generator = np.random.default_rng(seed)
    x = casadi.SX.sym(f"x{seed}", n)
    a, b, g = (casadi.SX(casadi.DM(generator.normal(size=size))) for size in ((n, n), (n, n), (n, ports)))
    turned = casadi.cos(x[0]) * a
    return PortSystem(x, casadi.sumsqr(x) + casadi.cos(x[0] * x[1]), turned - turned.T, b @ b.T, g)


def _skew(n, seed=0):
    a = np.random.default_rng(seed).normal(size=(n, n))
    return casadi.DM(a - a.T)


def _values(whole, *expressions):
    function = casadi.Function("values", [whole.state], [casadi.densify(casadi.vertcat(*map(casadi.vec, expressions)))])
    return evaluate(function, np.random.default_rng(1).normal(size=(20, whole.state.numel())))


def test_energies_add_and_structure_is_kept():
    parts = [_random_system(3, 2, 1), _random_system(2, 1, 2)]
    resistive = np.random.default_rng(3).normal(size=(3, 3))
    whole = interconnect(parts, _skew(3), casadi.DM(resistive @ resistive.T))
    np.testing.assert_allclose(_values(whole, whole.energy - parts[0].energy - parts[1].energy), 0, atol=1e-12)
    np.testing.assert_allclose(_values(whole, whole.interconnection + whole.interconnection.T), 0, atol=1e-12)
    n = whole.state.numel()
    r = _values(whole, whole.resistance).reshape(-1, n, n)
    assert np.linalg.eigvalsh((r + r.swapaxes(1, 2)) / 2).min() > -1e-12


def test_what_is_gained_is_what_flows_in_less_what_the_parts_lose():
    """The dissipation of the whole is the union of the parts'; the skew interconnection does no work."""
    parts = [_random_system(3, 2, 1), _random_system(2, 1, 2)]
    whole = interconnect(parts, _skew(3))
    inputs = casadi.DM([0.3, -1.0, 2.0])
    gained = casadi.dot(whole.gradient, whole.rate(casadi.SX(inputs)))
    supplied = casadi.dot(whole.output, inputs)
    lost = sum(casadi.dot(part.gradient, part.resistance @ part.gradient) for part in parts)
    np.testing.assert_allclose(_values(whole, gained - supplied + lost), 0, atol=1e-10)


def test_every_part_sees_the_others_through_its_ports():
    parts = [_random_system(3, 2, 1), _random_system(2, 1, 2)]
    skew = _skew(3)
    whole = interconnect(parts, skew)
    inputs = skew @ casadi.vertcat(parts[0].output, parts[1].output)
    separate = casadi.vertcat(parts[0].rate(inputs[:2]), parts[1].rate(inputs[2:]))
    np.testing.assert_allclose(_values(whole, whole.rate() - separate), 0, atol=1e-10)


def test_an_interconnection_that_makes_power_is_refused():
    with pytest.raises(ValueError, match="not skew-symmetric"):
        interconnect([_random_system(2, 1, 1), _random_system(2, 1, 2)], casadi.DM([[0, 1], [1, 0]]))


@pytest.mark.parametrize("links", [1, 4])
def test_a_chain_obeys_the_equations_of_its_masses(links):
    """m a_i = f_(i+1) - f_i, with f_i the force of the spring and the damper before mass i."""
    chain = link_chain(ChainLink.true(LINK), links)
    generator = np.random.default_rng(0)
    s, v = generator.normal(size=(2, links))
    rate = evaluate(
        casadi.Function("rate", [chain.state], [casadi.densify(chain.rate())]), np.concatenate([s, 0.5 * v])
    )
    stretching = np.diff(v, prepend=0.0)
    force = 20 * s + 40 * s**3 + 0.3 * stretching
    np.testing.assert_allclose(rate[:links], stretching, atol=1e-12)
    np.testing.assert_allclose(rate[links:], np.append(force[1:], 0.0) - force, atol=1e-12)


def test_a_learned_link_is_read_off_its_model():
    model = Damped(Lagrangian(spring, 1), "diagonal")
    learned = ChainLink.learned(model, np.array([0.25, 10.0, 10.0, 0.3]))
    true = ChainLink.true(LINK)
    assert (learned.mass, learned.damping) == pytest.approx((true.mass, true.damping))
    s = casadi.SX.sym("s")
    gap = casadi.Function("gap", [s], [learned.spring(s) - true.spring(s)])
    np.testing.assert_allclose(evaluate(gap, np.linspace(-1, 1, 9)[:, None]), 0, atol=1e-14)


def test_a_link_has_one_coordinate_and_constant_mass():
    with pytest.raises(ValueError, match="one coordinate"):
        ChainLink.learned(Lagrangian(spring, 2), np.zeros(3))


@pytest.mark.skipif(not STATUS.exists(), reason="the system does not say the peak of a process")
def test_a_long_chain_takes_no_memory_for_what_is_not_joined():
    done = subprocess.run([sys.executable, "-c", GROWTH], capture_output=True, text=True, check=True)
    assert int(done.stdout) * 1024 < 0.1 * 8 * (2 * 3000) ** 2
