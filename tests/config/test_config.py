"""A mistake in the settings is one clear line that names key, value and what is allowed, before anything runs."""

import pytest
from optional import without_device

from repro import __main__ as cli
from repro.plugins.plugin import plugin_names

MISTAKES = {
    "system=spi": "system=spi: allowed are {systems} (did you mean sip?)",
    "system.m2=0.1": "system: unknown constant of sip 'm2': choose one of m0, g, m1, L1",
    "system=sip system.m2=0.1": "system: unknown constant of sip 'm2': choose one of m0, g, m1, L1",
    "sytem=sip": "unknown key 'sytem' (did you mean system?); allowed are basis, ",
    "optimiser.epoch=3": "optimiser.epoch: unknown key (did you mean epochs?); allowed are batch_size,",
    "optimiser=adam optimiser.restarts=3": "optimiser.restarts: unknown key; allowed are batch_size, budget_s",
    "optimiser.epochs=ten": "optimiser.epochs = 'ten': should be a valid integer",
    "optimiser.epochs=0": "optimiser.epochs = 0: should be greater than 0",
    "optimiser.learning_rate=-1": "optimiser.learning_rate = -1: should be greater than or equal to 0",
    "optimiser.kind=sgd": "optimiser.kind = 'sgd': allowed are adam, basis_selection, lbfgs",
    "basis=t3": "basis=t3: allowed are {bases}",
    "basis.name=t3": "basis.name = 't3': allowed are {bases}",
    "model.kind=mlp": "model.kind = 'mlp': allowed are blackbox, degenerate, extended, hamiltonian, hinged, lagrangian",
    "model.hidden=10": "model.hidden = 10: should be a valid list",
    "model.hidden=[10,0]": "model.hidden.1 = 0: should be greater than 0",
    "model.activation=relu": "model.activation = 'relu': should be 'softplus' or 'tanh'",
    "seeds=[0,0]": "seeds = [0, 0]: a seed is given twice",
    "seeds=2 seeds=3": "seeds is given twice: seeds=2 and seeds=3; give it once",
    "seeds=0": "seeds = 0: give a number of members (1 or more), a list of seeds",
    "seeds=[]": "seeds = []: give a number of members",
    "seeds=[1,a]": "seeds = [1, 'a']: give a number of members",
    "data.samples=0": "data.samples = 0: should be greater than or equal to 10",
    "data.train_fraction=1": "data.train_fraction = 1",
    "data.regime=looong": "data.regime = 'looong': should be 'episodes' or 'long'",
    "data.time_step=nan": "data.time_step = nan: should be a finite number",
    "data.source=web": "data.source = 'web': allowed are 'random_force', 'file'",
    "data=file": "data.path: a value is needed",
    "data=file data.path=nothing.csv": "data.path = 'nothing.csv': no such file",
    "system.damping=[0.1]": "system: damping of sip needs 2 non-negative numbers (x, theta)",
    "system.damping=[-1,0]": "system.damping.0 = -1: should be greater than or equal to 0",
    "scale=tiny": "scale=tiny: allowed are paper, quick, smoke",
    "record=perhaps": "record = 'perhaps': should be a valid boolean",
    "+foo=1": "unknown key 'foo'; allowed are basis",
    "+data.foo=1": "keys cannot be added",
    "~data.samples": "keys cannot be removed; give another value",
    "basis": "basis: not understood",
    "reading=physical,printed": "this makes 2 jobs: add -m to run them all",
    "experiment=sip_basics": "did you mean sip_basis?",
    "experiment=sip_basis": "jobs: add -m to run them all",
    "hydra/launcher=slurm": "hydra/launcher=slurm: allowed are submitit_slurm, submitit_local, ray",
    "hydra.verbose=true": "a failed job's log and trace are in `repro show ID`",
    "hydra.sweep.dir=elsewhere": "REPRO_OUTPUTS=/some/folder chooses another place",
    "hydra/job_logging=none": "settings of Hydra itself go with hydra/launcher=",
    "basis=T1": "did you mean t1?",
    "system=SIP": "did you mean sip?",
    "~control": "a group cannot be removed; write control=none",
    "~basis": "a group cannot be removed; choose one of engineered, ",
    "++data.sample=100": "data.sample: unknown key (did you mean samples?)",
    "basis=glob(z*)": "fits nothing; allowed are engineered",
    "seeds=glob(*)": "glob is for groups and experiments",
    "data.samples=interval(1,5)": "an interval is for a search (hydra/sweeper=optuna)",
    f"seeds=[{2**70}]": "is below 2**32",
    "seeds=range(0,1)": "for a job per seed write seeds=[0],[1]",
}
COMBINATIONS = {
    "basis=t2 optimiser=least_squares": "library, rigid_body, spring, t1), not lagrangian, t2",
    "basis=t1 optimiser=least_squares objective=forward": "use objective=inverse or balance, not forward",
    "model=blackbox": "model=blackbox predicts accelerations only; use objective=forward",
    "model=blackbox objective=forward sequence=joint": "use sequence=main",
    "data.measured=positions": "data.measured=positions has no accelerations; use data.labels=smoothed",
    "data.sample_step=0.03": "no whole multiple of it",
    "data.quantisation=[0.1]": "two steps",
    "objective=path": "use data.labels=smoothed, not exact",
    "objective=balance sequence=joint": "use sequence=main, not joint",
    "objective=balance device=cuda": "use device=cpu",
    "objective=balance model=port_hamiltonian model.structure=free": "use model.structure=canonical",
    "objective=balance model=blackbox": "objective.kind = 'balance': model=blackbox predicts accelerations only",
    "objective=path data.labels=smoothed basis=library optimiser=lasso": "use optimiser=least_squares, not lasso",
    "model=blackbox objective=forward energies=anchor": "use energies=raw",
    "objective.momentum_weight=1": "Omega_tran needs both, or neither",
    "model.momentum_hidden=[8]": "Omega_tran needs both, or neither",
    "basis=t2 objective.l1_kinetic=0.1": "act on coefficients under optimiser=adam and a linear basis",
    "objective.equal_weight_share=0.2": "equal weights at the end need other weights before: objective.error_scale",
    "model=structured model.factor=triangular model.rank=5": "use model.factor=wide",
    "device=cuda optimiser=lbfgs": "device = 'cuda': runs optimiser=adam or adam_cosine, not lbfgs; use device=cpu",
    "device=cuda model=port_hamiltonian": "runs model=blackbox, lagrangian, structured, not model=port_hamiltonian",
    "device=cuda model=structured model.factor=triangular": "not model.factor=triangular; use device=cpu",
    "chain=[2]": "joins copies of a link; use system=link",
    "system=sip whole_chain=[2]": "is sampled from the true chain; use system=link",
    "objective=prediction": "objective.kind = 'prediction': needs model=blackbox, symoden, not model=lagrangian",
    "objective=implicit": "objective.kind = 'implicit': needs model=sparse, not model=lagrangian",
    "model=symoden objective=prediction optimiser=levenberg_marquardt": "has no Jacobian; use optimiser=adam",
    "model=hamiltonian": "model=hamiltonian predicts accelerations only; use objective=port",
    "model=sparse objective=forward optimiser=least_squares": "is linear in tau only; use objective=implicit",
    "objective=port": "objective.kind = 'port': needs model=hamiltonian, port_hamiltonian",
    "sequence=joint system.damping=[0.1,0.1]": "D_H keeps its energy only without friction",
    "data=file data.path={file} sequence=joint": "data=file goes with sequence=main",
    "data=file data.path={file} model=degenerate": "is made from the true system",
    "data=file data.path={file} curriculum=growing_episodes": "data=file goes with curriculum=none",
    "data=file data.path={file} control=sip": "drives the true system, which data=file does not include",
    "model=degenerate control=sip": "needs a model with energies and an invertible mass matrix, not model=degenerate",
    "system=dip model=truth control=energy_shaping": "drives a cart with one link by one force; system=dip has 1 input",
    "system=rod model=truth control=energy_shaping": (
        "control = 'energy_shaping': drives a cart with one link by one force; system=rod has 3 inputs and coordinates "
        "x, y, theta; use system=sip, sip_rod"
    ),
    "system=acrobot model=degenerate": "model=degenerate: is the momentum of a cyclic coordinate that an input drives",
    "system=motor_pendulum model=structured": "system=motor_pendulum has forces between its rates, as a motor has",
    "system=furuta reading=printed model=truth": "reading = printed: is for the links of the paper; system=furuta",
    "system=spring_row model=truth data.start=hanging": "unknown start of spring_row 'hanging': choose one of rest",
    "system=link model=truth control=sip task=swing_up task.end=rest": "task.start = 'hanging': system=link rests at",
    "system=rod model=truth control=sip control.stage_cost.position={z:1}": "cost.position.z: system=rod has x, y",
    "model=truth control=sip task.tolerance.phi=0.1": "task.tolerance.phi: system=sip has coordinates x, theta",
    "system=acrobot model=truth control=swing_up task=swing_up task.mismatch=0.1": (
        "task.mismatch = 0.1: model=truth: has no coefficients for system=acrobot; use task.mismatch_kind=physical"
    ),
    "model=truth control=sip task.delay=0.04": "must be shorter than control.time_step = 0.04",
    "model=truth control=sip task.damping=[0.1]": "task.damping = [0.1]: needs 2 numbers, or none",
}


SYSTEMS, BASES = (", ".join(plugin_names(folder)) for folder in ("mechanics.systems", "models.bases"))


@pytest.mark.parametrize("overrides", [*MISTAKES, *COMBINATIONS])
def test_a_mistake_is_one_line_and_nothing_runs(overrides, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path / "outputs"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "recording.csv").write_text("time\n0\n")
    given = overrides.replace("{file}", str(tmp_path / "recording.csv"))
    assert cli.main(["run", *given.split()]) == 2
    told = capsys.readouterr().err.strip()
    assert (MISTAKES | COMBINATIONS)[overrides].replace("{systems}", SYSTEMS).replace("{bases}", BASES) in told
    assert told.startswith("repro: ")
    assert len(told.splitlines()) == 1
    assert not (tmp_path / "outputs" / "data").exists()


def test_every_mistake_is_told_at_once(capsys):
    assert cli.main(["run", "data.samples=0", "seeds=0"]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 2


def test_one_wrong_job_stops_a_sweep_before_it_starts(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path))
    assert cli.main(["run", "-m", "basis=t1,t2", "optimiser=least_squares", "scale=smoke"]) == 2
    assert "not lagrangian, t2" in capsys.readouterr().err
    assert not (tmp_path / "data").exists()


@pytest.mark.parametrize(
    "arguments",
    [["--cfg", "job", "basis=t1"], ["--cfg", "basis=t1"], ["basis=t1", "--cfg"], ["-m", "basis=t1", "--cfg", "job"]],
)
def test_the_configuration_is_printed_as_hydra_users_expect(arguments, capsys):
    import yaml

    assert cli.main(["run", *arguments]) == 0
    shown = yaml.safe_load(capsys.readouterr().out)
    assert shown["basis"] == {"name": "t1"}
    assert shown["optimiser"]["epochs"] == 1000


def test_help_lists_every_choice_in_the_words_of_its_file(capsys):
    with pytest.raises(SystemExit):
        cli.main(["run", "--help"])
    text = capsys.readouterr().out
    assert "optimiser=least_squares                closed form, for linear bases" in text
    assert "experiment=sip_basis" in text
    assert "record=true" in text
    bare = [line for line in text.partition("choices:")[2].splitlines() if line and not line[40:].strip()]
    assert bare == []


@without_device
def test_a_machine_without_the_device_is_told_before_any_work(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path / "outputs"))
    assert cli.main(["run", "-m", "device=cuda", "basis=t1,t2", "scale=smoke"]) == 2
    told = capsys.readouterr().err.strip()
    assert "use device=cpu, or run where there is one" in told and len(told.splitlines()) == 1
    assert not (tmp_path / "outputs" / "data").exists()
