"""A search by Optuna: its options, what it may choose from, and that it finds what is best."""

import pytest
from optional import needs_extra

from repro import __main__ as cli
from repro.errors import UserError
from repro.sweep import search
from repro.sweep.search import CHOSEN, SearchOptions, split


def test_without_the_sweeper_nothing_is_taken_away():
    assert split(["basis=t1,t2", "hydra/launcher=ray"]) == (["basis=t1,t2", "hydra/launcher=ray"], None)


def test_the_options_are_taken_out(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: True)
    given = [CHOSEN, "basis=t1,t2", "hydra.sweeper.n_trials=7", "hydra.sweeper.metric=mae_qdd"]
    rest, options = split(given)
    assert rest == ["basis=t1,t2"]
    assert options == SearchOptions(metric="mae_qdd", n_trials=7)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("n_trails=3", r"did you mean n_trials\?"),
        ("n_trials=0", "n_trials = '0': should be greater than 0"),
        ("n_trials=many", "should be a valid integer"),
        ("seed=-1", "should be greater than or equal to 0"),
        ("direction=down", "should be 'minimize' or 'maximize'"),
    ],
)
def test_a_wrong_option_is_one_line(given, said, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: True)
    with pytest.raises(UserError, match=said):
        split([CHOSEN, f"hydra.sweeper.{given}"])


def test_without_the_extra_the_line_says_what_to_install(monkeypatch, capsys):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert cli.main(["run", "-m", CHOSEN, "basis=t1,t2"]) == 2
    assert "pip install -e '.[search]'" in capsys.readouterr().err


@pytest.mark.extras
@needs_extra("search", "optuna")
def test_the_spaces_are_those_of_the_grammar():
    from optuna.distributions import CategoricalDistribution, FloatDistribution, IntDistribution

    assert search.distribution("basis=t1") is None
    assert search.distribution("basis=t1,t2") == CategoricalDistribution(("t1", "t2"))
    assert search.distribution("a=interval(0.1,0.5)") == FloatDistribution(0.1, 0.5)
    assert search.distribution("a=tag(log,interval(0.0001,0.1))") == FloatDistribution(1e-4, 0.1, log=True)
    assert search.distribution("a=int(interval(1,5))") == IntDistribution(1, 5)
    assert search.distribution("a=range(1,10,3)") == IntDistribution(1, 7, step=3)


@pytest.mark.extras
@needs_extra("search", "optuna")
def test_a_search_lists_its_runs_the_best_first(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path))
    fixed = ["basis=t1", "optimiser=least_squares", "scale=smoke", "seeds=1", "record=false"]
    options = ["hydra.sweeper.n_trials=3", "hydra.sweeper.metric=mae_tau"]
    assert cli.main(["run", "-m", CHOSEN, *options, *fixed, "data.tau_noise=interval(0.0,1.0)"]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines() if line.startswith("sip-")]
    values = [float(row[1]) for row in rows]
    assert len(values) == 3 and values == sorted(values)
    noises = [float(word.partition("=")[2]) for row in rows for word in row if word.startswith("data.tau_noise=")]
    assert noises == sorted(noises)  # the error of the force grows with its noise
