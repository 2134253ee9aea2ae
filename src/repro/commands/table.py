"""The commands, without loading any."""

COMMANDS = {  # by name: a line of help, and an example of the arguments
    "reproduce": ("run every experiment and make the report", "scale=quick"),
    "run": ("run one configuration, or many with -m", "-m basis=t1,t2"),
    "sensitivity": ("change one assumption at a time", "data_start"),
    "status": ("what is done, stale, failed, missing", "--why 9f3c2a81bd"),
    "runs": ("list stored runs", "basis=t2"),
    "show": ("one run in full", "9f3c2a81bd"),
    "diff": ("how two runs differ", "9f3c2a81bd 04be7d1f6a"),
    "report": ("make tables, figures and verdicts from stored runs", ""),
    "identify": ("which terms of a linear basis data determine", "system=dip basis=fxf"),
    "view": ("open a run's recording, or several in one", "9f3c2a81bd 04be7d1f6a"),
    "export": ("a learned model for CasADi, C and torch", "9f3c2a81bd exported"),
    "mlflow": ("copy finished runs to an MLflow tracking store", "sqlite:///mlflow.db basis=t2"),
    "bench": ("time this project against others", ""),
    "completion": ("completion of words for bash, zsh or fish", "bash"),
    "clean": ("remove leftovers, never a current result", "--yes"),
}
