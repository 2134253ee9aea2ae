"""`repro identify`: what a user reads of a basis and a sequence."""

import pytest

from repro import __main__ as cli

SMALL = ("scale=smoke", "seeds=2", "data.samples=200", "sequence.initial_angles=5")


@pytest.fixture
def identify(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path))

    def run(*overrides):
        code = cli.main(["identify", *overrides, *SMALL])
        told = capsys.readouterr()
        return code, told.out + told.err

    return run


def test_free_motion_leaves_the_cart_momentum_open(identify):
    code, text = identify("system=dip", "basis=fxf", "sequence=pretrain_only")
    assert code == 0
    assert text.startswith("D_H: rank 27 of 30 terms\n")
    assert "    (xd + 0.15 theta1d cos(theta1) + 0.05 theta2d cos(theta2))^2\n" in text
    assert text.count("theta1d^2") == text.count("theta2d^2") == 1


def test_each_phase_is_told(identify):
    _, text = identify("system=dip", "basis=fxf_gauge", "sequence=pretrain", "sequence.energy_form=sum")
    assert "D_H: rank 36 of 40 terms" in text and "D: rank 28 of 40 terms" in text
    assert "T: cos(theta1), V: cos(theta1)" in text


def test_a_basis_without_freedom_says_so(identify):
    _, text = identify("basis=t1")
    assert "rank 4 of 4 terms" in text and "every term is determined" in text and "none the next" in text


@pytest.mark.parametrize(
    "overrides", [["basis=t2"], ["model=trivial"], ["basis=t1", "objective=forward"]], ids=["net", "anchor", "forward"]
)
def test_what_is_no_linear_regression_is_refused(identify, overrides, tmp_path):
    code, text = identify(*overrides)
    assert code == 2 and "identify is for model=lagrangian with a linear basis" in text
    assert not any(tmp_path.iterdir())


def test_a_path_fit_says_how_well_each_coefficient_is_known(identify):
    sensors = ("data.measured=positions", "data.labels=smoothed", "data.q_noise=0.001", "data.episode_steps=50")
    code, said = identify("basis=t1", "optimiser=least_squares", "objective=path", "data.reset=random", *sensors)
    assert code == 0
    assert "cost per degree of freedom" in said
    assert "+-" in said
    assert "1 % takes" in said
