"""Options of Hydra's own command line, and what takes their place here."""

from collections.abc import Sequence

from repro.errors import UserError

INSTEAD = {
    "--hydra-help": "`repro run --help` lists options and choices",
    ("--info", "-i"): "`repro run --cfg job` prints the configuration, `repro show ID` where a result comes from",
    ("--config-dir", "-cd"): "own options are files in the checkout: conf/GROUP/NAME.yaml, experiments/NAME.yaml",
    ("--config-path", "-cp"): "own options are files in the checkout: conf/GROUP/NAME.yaml, experiments/NAME.yaml",
    ("--config-name", "-cn"): "conf/config.yaml is the only one; experiment=NAME takes settings from experiments/",
    ("--shell-completion", "-sc"): "`repro completion bash` (zsh, fish) prints a script to source",
    "--resolve": "`--cfg job` prints the resolved configuration as it is",
    ("--package", "-p"): "`--cfg job` prints all of the configuration",
    ("--run", "-r"): "leave it out: without -m one job runs",
    "--experimental-rerun": "`repro show ID` prints the command that repeats a run",
    ("--dryrun", "--dry"): "write --dry-run",
}


def refuse_hydras(words: Sequence[str]) -> None:
    """UserError with what takes the place of an option that Hydra's own programs have."""
    for spellings, instead in INSTEAD.items():
        for word in words:
            name = word.partition("=")[0]
            if name == spellings or (isinstance(spellings, tuple) and name in spellings):
                raise UserError(f"{name} is an option of Hydra that is not needed here: {instead}")
