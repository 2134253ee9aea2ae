"""Command lines that cannot work: each ends with the right code and one line that says what is wrong."""

import shlex

import pytest

from repro import __main__ as cli

LONG = "x" * 20_000
# By kind: a command line -> words of the one line that it is answered with.
COMMANDS = {
    "statsu": "Did you mean status?",
    "RUN": "no command RUN",
    "-m basis=t1": "no command -m",
    "''": "no command",
    "run1": "Did you mean run?",
    "../run": "no command",
    "run\n": "no command",
    "--verison": "no command --verison",
    "漢字": "no command 漢字",
}
OPTIONS = {
    "run --dryrun": "write --dry-run",
    "run --dry basis=t1": "write --dry-run",
    "run --dry-rum": "did you mean --dry-run?",
    "run --workers": "expected one argument",
    "run --workers 0": "1 or more",
    "run --workers -3": "1 or more",
    "run --workers=-3": "1 or more",
    "run --workers 1.5": "1 or more",
    "run --workers two": "1 or more",
    "run --workers 99999999999999999999": "1 or more",
    "run --timeout -1": "above 0",
    "run --timeout=-1": "above 0",
    "run --timeout 0": "above 0",
    "run --timeout nan": "above 0",
    "run --timeout inf": "above 0",
    "run --timeout soon": "above 0",
    "run --multirn": "did you mean --multirun?",
    "run -x": "unrecognized arguments: -x",
    "reproduce --workers 0": "1 or more",
    "sensitivity --workers 0": "1 or more",
    "status --why": "expected one argument",
    "status --wy x": "unrecognized arguments",
    "view": "the following arguments are required",
    "view x --at now": "invalid float value",
    "view x --web --screenshot y.png": "not allowed with",
    "export": "the following arguments are required",
    "export a b c": "unrecognized arguments: c",
    "report --scale tiny": "invalid choice: 'tiny'",
    "bench --scale huge": "invalid choice: 'huge'",
    "diff one": "the following arguments are required",
    "clean everything": "there is no everything to remove",
    "show": "the following arguments are required",
    "completion tcsh": "choose one of bash, zsh, fish",
    "completion": "choose one of bash, zsh, fish",
}
HYDRA_HABITS = {
    "run --hydra-help": "`repro run --help`",
    "run --info": "--cfg job",
    "run --info=all": "--cfg job",
    "run --config-dir=/tmp": "conf/GROUP/NAME.yaml",
    "run -cd /tmp": "conf/GROUP/NAME.yaml",
    "run --config-path conf": "conf/GROUP/NAME.yaml",
    "run --config-name other": "experiment=NAME",
    "run -cn other": "experiment=NAME",
    "run --resolve": "--cfg job",
    "run --package x": "--cfg job",
    "run -p x": "--cfg job",
    "run --shell-completion": "repro completion bash",
    "run -sc install=bash": "repro completion bash",
    "run --run": "without -m",
    "run --experimental-rerun x": "repro show",
    "run --cfg hydra": "--cfg job only",
    "run --cfg all": "--cfg job only",
    "run -c hydra": "--cfg job only",
    "run hydra.sweep.dir=elsewhere": "REPRO_OUTPUTS",
    "run -m hydra.sweep.subdir=x basis=t1,t2": "REPRO_OUTPUTS",
    "run hydra.run.dir=elsewhere": "REPRO_OUTPUTS",
    "run hydra.output_subdir=null": "REPRO_OUTPUTS",
    "run hydra.job.chdir=true": "REPRO_OUTPUTS",
    "run hydra.verbose=true": "repro show ID",
    "run hydra.mode=MULTIRUN": "-m runs many jobs",
    "run hydra/launcher=joblib": "allowed are submitit_slurm",
    "run hydra/launcher=": "allowed are submitit_slurm",
    "run hydra/sweeper=ax": "optuna",
    "run hydra/help=x": "`repro run --help`",
    "run ~control": "write control=none",
    "run ~basis": "a group cannot be removed",
    "run ~data.samples": "keys cannot be removed",
    "run +data.samples=100": "leave out the +",
    "run +new.key=1": "unknown key 'new'",
    "run ++new.key=1": "unknown key 'new'",
    "run ++data.sample=100": "did you mean samples?",
    "run -m 'basis=glob(z*)'": "fits nothing",
    "run -m 'seeds=glob(*)'": "glob is for groups and experiments",
    "run -m 'experiment=glob(zz*)'": "fits nothing",
    "run -m 'data.samples=interval(1,5)'": "hydra/sweeper=optuna",
    "run -m 'seeds=range(0,1)'": "seeds=[0],[1]",
}
OVERRIDES = {
    "run basis": "not understood",
    "run =": "unknown key",
    "run =t1": "unknown key",
    "run basis=": "allowed are",
    "run basis=T1": "did you mean t1?",
    "run system=SIP": "did you mean sip?",
    "run Basis=t1": "did you mean basis?",
    "run basis=t9": "allowed are",
    "run bsis=t1": "did you mean basis?",
    "run basis=t1 basis=t2": "given twice",
    "run basis==t1": "not understood",
    "run 'basis=t1 '": "allowed are",
    "run 'basis=[t1'": "not understood",
    "run 'basis=t1)'": "not understood",
    "run 'basis={a:1'": "not understood",
    "run 'basis=${system}'": "allowed are",
    "run 'data.samples=${oops}'": "oops",
    "run 'data.samples=${oc.env:NOT_SET_AT_ALL}'": "NOT_SET_AT_ALL",
    "run data.samples=": "data.samples",
    "run data.samples=null": "data.samples",
    "run data.samples=-5": "greater than or equal to 10",
    "run data.samples=0": "greater than or equal to 10",
    "run data.samples=1.5": "data.samples = 1.5",
    "run data.samples=many": "data.samples = 'many'",
    "run data.samples=nan": "data.samples = nan",
    "run data.samples=[1]": "data.samples = [1]",
    "run data.samples.x=1": "data.samples = {'x': 1}",
    "run data..samples=1": "not understood",
    "run data/samples=1": "data",
    "run data.smaples=100": "did you mean samples?",
    "run data=web": "allowed are",
    "run data=long,episodes": "add -m to run them all",
    "run seeds=-1": "give a number of members",
    "run seeds=0": "give a number of members",
    "run seeds=[]": "give a number of members",
    "run seeds=[0,0]": "a seed is given twice",
    "run seeds=1.5": "give a number of members",
    "run seeds=true": "give a number of members",
    "run seeds=x": "give a number of members",
    f"run seeds=[{2**70}]": "below 2**32",
    f"run seeds={2**40}": "below 2**32",
    f"run basis={LONG}": "allowed are",
    f"run {LONG}=1": "unknown key",
    "run device=tpu": "should be 'cpu' or 'cuda'",
    "run record=perhaps": "valid boolean",
    "run scale=tiny": "allowed are paper, quick, smoke",
    "run scale=PAPER": "did you mean paper?",
    "run model.hidden=10": "should be a valid list",
    "run 'model.hidden=[0]'": "greater than 0",
    "run optimiser.epochs=-1": "optimiser.epochs = -1",
    "run optimiser.learning_rate=inf": "optimiser.learning_rate",
    "run experiment=nothing": "experiment=nothing: allowed are",
    "run experiment=": "experiment=: allowed are",
    "run experiment=sip_basis": "add -m to run them all",
    "run -m --paired basis=t1,t2 seeds=1,2,3": "one length",
    "run system.m1=-1": "system",
    "run system.wheels=4": "wheels",
    "run task.seconds=1e9 control=sip": "task.seconds",
    "run chain=[2]": "use system=link",
    "run optimiser=least_squares": "needs model=lagrangian and a linear basis",
    "run data=file": "data.path: a value is needed",
    "run data=file data.path=nothing.csv": "no such file",
    "run data=file data.path=/dev/null/x.csv": "no such file",
    "run data=file data.path=/": "the folder has no file",
    "run data=file data.path=a,b.csv": "add -m to run them all",
    "identify basis=t2": "identify is for model=lagrangian",
    "identify basis=t9": "allowed are",
    "reproduce basis=t1": "reproduce takes scale= and experiment= only",
    "reproduce scale=tiny": "scale=tiny: allowed are",
    "reproduce experiment=nothing": "experiment=nothing: allowed are",
    "sensitivity nothing": "no assumption is called nothing",
}
STORE = {
    "show nothing": "no stage nothing",
    "show ''": "no stage",
    "show ../../etc": "no stage",
    "show '*'": "no stage",
    "diff a b": "no stage a",
    "export nothing folder": "no stage nothing",
    "view nothing": "no recordings",
    "view nothing.rrd": "no file nothing.rrd",
    "view a b": "no stage a",
    "status --why nothing": "no stage nothing",
    "runs basis": "write key=value",
    "report": "no experiment of scale quick has been run",
    "report --scale smoke": "no experiment of scale smoke has been run",
    "report --from /nowhere": "/nowhere",
    "report --interactive nothing": "no recordings",
    "mlflow": "the following arguments are required",
}
LINES = COMMANDS | OPTIONS | HYDRA_HABITS | OVERRIDES | STORE


@pytest.fixture
def nothing_starts(monkeypatch, tmp_path):
    monkeypatch.setenv("REPRO_OUTPUTS", str(tmp_path / "outputs"))
    for command in ("run", "reproduce", "sensitivity"):
        monkeypatch.setattr(f"repro.commands.{command}.start_server", lambda preload: None)


@pytest.mark.parametrize("line", LINES, ids=lambda line: line[:60])
def test_a_hostile_line_is_answered_with_one_line(line, nothing_starts, capfd):
    assert cli.main(shlex.split(line.replace("\n", r"$'\n'"))) == 2
    out, err = capfd.readouterr()
    assert LINES[line] in err and err.startswith("repro: ") and err.endswith("\n")
    assert len(err.splitlines()) == 1 and len(err) <= 2 * cli.LONGEST_LINE
    assert "Traceback" not in err and not out


def test_there_are_lines_of_every_kind():
    assert len(LINES) >= 120


@pytest.mark.parametrize(
    ("line", "jobs"),
    [
        ("-m 'basis=glob(t*)'", 2),
        ("-m 'experiment=glob(sip_s*)' scale=smoke", None),
        ("-m 'data.samples=range(100,103)'", 3),
        ("-m 'optimiser.epochs=range(1,10,3)'", 3),
        ("-m 'basis=choice(t1,t2)'", 2),
        ("-m 'data.samples=sort(300,100,200)'", 3),
        ("++data.samples=100", 1),
        ("++basis=t1", 1),
        ("-m seeds=[0],[1]", 2),
    ],
)
def test_a_habit_of_hydra_works(line, jobs, nothing_starts, capsys):
    assert cli.main(["run", "--dry-run", *shlex.split(line)]) == 0
    listed = capsys.readouterr().out.splitlines()[-1]
    assert jobs is None or listed.startswith(f"{jobs} job")


def test_a_configuration_is_printed_by_either_name(nothing_starts, capsys):
    assert cli.main(["run", "--cfg", "job", "basis=t1"]) == 0
    printed = capsys.readouterr().out
    assert cli.main(["run", "-c", "job", "basis=t1"]) == 0
    assert capsys.readouterr().out == printed and "name: t1" in printed
