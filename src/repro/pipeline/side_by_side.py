"""Several runs in one recording: their models beside the one plant that all were tested on."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from repro.errors import UserError
from repro.library.run_recording import recording_of, tested_by
from repro.mechanics.system_options import SYSTEMS
from repro.pipeline.finished_run import OpenedRun, load_run
from repro.plugins.plugin import plugin_module
from repro.recording.contents import FILENAME
from repro.recording.viewer import KIND
from repro.recording.writer import write_recording
from repro.results.metric_names import written
from repro.results.table_schema import as_text
from repro.tracking.load import digits
from repro.tracking.paths import outputs_root
from repro.tracking.plain_data import Json
from repro.tracking.stage import Stage
from repro.tracking.store import Store

MOST = 6
# The columns of a run card that set models apart, in the order in which people name them.
NAMING = ("model", "basis", "objective", "optimiser", "sequence", "hidden", "energies", "curriculum", "options")


def compared(ids: Sequence[str], root: Path | None = None) -> Path:
    """The recording of several runs, by their ids or the digits at their ends; made where it is missing.

    Raises UserError for runs that were not tested on the same data, and for ones that have no motion to show.
    """
    where = root or outputs_root()
    runs = [_opened(id, where) for id in ids]
    if not 2 <= len(runs) <= MOST:
        raise UserError(f"{len(runs)} runs: 2 to {MOST} can be distinguished in one recording")
    if len({run.id for run in runs}) < len(runs):
        raise UserError("the same run is named twice; name each once")
    tested_on = {run.id: run.identity.upstream["data"] for run in runs}
    if len(set(tested_on.values())) > 1:
        listed = "".join(f"\n  {id}: {data}" for id, data in tested_on.items())
        raise UserError(f"these runs were tested on different data, so there is no one plant to show:{listed}")
    common = set.intersection(*(set(run.seeds) for run in runs))
    if not common:
        raise UserError("these runs have no seed in common, so there is no motion that all were tested on")
    system = runs[0].settings.system
    if system is None:
        raise UserError("these runs were tested on a recording, whose true motion and energy are not known")
    labels = _labels({run.id: run.card for run in runs})
    stage = Stage(
        KIND,
        f"comparison-{system.name}",
        {"labels": labels, "member": min(common)},
        {f"run_{number}": run.id for number, run in enumerate(runs, start=1)},
        (plugin_module("pipeline.stages", "record_run"), plugin_module(SYSTEMS, system.name)),
        f"repro view {' '.join(labels)}",
    )
    record = Store(where).compute(stage, lambda folder: _record(folder, stage, runs, labels))
    return record.path(FILENAME)


def _opened(id: str, root: Path) -> OpenedRun:
    run = load_run(id, root=root)
    if not isinstance(run, OpenedRun):
        raise UserError(f"{run.id} is one of the {run.kind}, not a run; `repro runs` lists the runs")
    if run.card.get("control"):
        raise UserError(f"{run.id} is a closed loop: each has a motion of its own; view it alone")
    if run.system is None or not run.summary.get("simulated"):
        raise UserError(f"{run.id} has no motion of a plant and a model to show")
    return run


def _record(folder: Path, stage: Stage, runs: Sequence[OpenedRun], labels: Mapping[str, str]) -> Json:
    system = runs[0].system
    assert system is not None
    member = stage.identity.config["member"]
    tested = {labels[run.id]: tested_by(run.table("trajectories"), member) for run in runs}
    curves = {labels[run.id]: run.table("curves") for run in runs}
    learned = {label: rows[rows["member"] == member] for label, rows in curves.items()}
    card: Json = {"seed": member}
    for run in runs:
        named = {name: value for name in NAMING if (value := run.card.get(name))}
        card[labels[run.id]] = {"run": run.id, **named, **run.summary["median"]}
    card["command"] = stage.command
    title = f"{system.name}: {len(runs)} models"
    write_recording(folder / FILENAME, recording_of(stage.id, title, card, tested, learned, system))
    return {"member": member}


def _labels(cards: Mapping[str, Json]) -> dict[str, str]:
    """Run -> as few words as set it apart from the others; its digits too where words do not tell."""
    words: dict[str, list[str]] = {id: [] for id in cards}
    for name in NAMING:
        more = {id: [*words[id], written(name, as_text(card.get(name)))] for id, card in cards.items()}
        if len(set(map(tuple, more.values()))) > len(set(map(tuple, words.values()))):
            words = more
    labels = {id: ", ".join(filter(None, parts)) for id, parts in words.items()}
    texts = list(labels.values())
    return {
        id: label if label and texts.count(label) == 1 else f"{label} {digits(id)}".strip()
        for id, label in labels.items()
    }
