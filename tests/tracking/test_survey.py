"""Status tells every state of a stage, and why; the index only saves time."""

from __future__ import annotations

import json

import pytest

from repro.errors import UserError
from repro.tracking import code, index, load, lock, survey
from repro.tracking.paths import HOLDER_FILE
from repro.tracking.stage import Stage
from repro.tracking.store import StageFailed


def make_all(store, toy, **settings):
    for stage in toy.stages(**settings).values():
        store.compute(stage, lambda folder: {"card": {"system": "toy"}})


def list_runs(store, ids, scale="quick", experiment="basis", **more):
    file = store.paths.experiments / scale / f"{experiment}.json"
    file.parent.mkdir(parents=True, exist_ok=True)
    jobs = [{"overrides": [f"n={n}"], "run": id, "command": f"repro run n={n}"} for n, id in enumerate(ids)]
    file.write_text(json.dumps({"experiment": experiment, "scale": scale, "jobs": jobs, **more}))


def states(store, **options):
    return {item.id: item for item in survey.survey(store.paths, **options)}


def test_an_edit_makes_exactly_the_dependents_stale(store, toy):
    make_all(store, toy)
    ids = toy.ids()
    assert {item.state for item in states(store).values()} == {"done"}
    toy.edit("report/figure.py", "# how it looks", "# another comment")
    assert {item.state for item in states(store).values()} == {"done"}
    toy.edit("learning/loss.py", "error**2", "abs(error)")
    found = states(store)
    stale = {role for role, id in ids.items() if found[id].state == "stale"}
    assert stale == {"fit", "score", "figure"}
    assert found[ids["fit"]].why == (f"module {toy.name}.learning.loss changed",)
    (first, *others) = found[ids["figure"]].why
    assert first == f"module {toy.name}.learning.loss changed"
    assert set(others) == {f"{first} (upstream fit {ids['fit']})", f"{first} (upstream run {ids['score']})"}


def test_a_library_and_a_removed_module_are_named(store, toy, monkeypatch):
    make_all(store, toy)
    monkeypatch.setattr(code, "version", lambda name: "0.1")
    code.closure.cache_clear()
    reasons = states(store)[toy.ids()["data"]].why if toy.ids()["data"] in states(store) else ()
    (data,) = (item for item in states(store).values() if item.kind == "data")
    assert data.state == "stale"
    assert data.why[0].startswith("library numpy: ")
    assert data.why[0].endswith(" -> 0.1")
    assert reasons == ()
    monkeypatch.undo()
    (toy.folder / "data" / "make.py").unlink()
    code._file.cache_clear()
    code.closure.cache_clear()
    (data,) = (item for item in states(store).values() if item.kind == "data")
    assert "no module" in data.why[0]


def test_a_changed_default_is_named(store, toy):
    make_all(store, toy)
    list_runs(store, [toy.ids()["score"]])

    def expected(overrides):
        assert overrides == ["n=0"]
        return list(toy.stages(epochs=12).values())[:3]

    item = states(store, expected=expected)[toy.ids()["score"]]
    assert item.state == "stale"
    assert item.why == ("config epochs: 10 -> 12",)
    assert states(store, expected=lambda overrides: list(toy.stages().values())[:3])[item.id].state == "done"


def test_defaults_are_asked_for_only_where_the_settings_have_changed(store, toy):
    make_all(store, toy)
    list_runs(store, [toy.ids()["score"]], settings="abc")
    asked = []

    def expected(overrides):
        asked.append(overrides)
        return list(toy.stages().values())[:3]

    states(store, expected=expected, settings=lambda experiment: "abc")
    assert asked == []
    states(store, expected=expected, settings=lambda experiment: "abd")
    assert asked == [["n=0"]]


def test_a_listed_job_that_is_no_longer_accepted_is_stale(store, toy):
    make_all(store, toy)
    list_runs(store, [toy.ids()["score"]])

    def expected(overrides):
        raise UserError("no model lagrange")

    item = states(store, expected=expected)[toy.ids()["score"]]
    assert item.state == "stale"
    assert item.why == ("its settings are no longer accepted: no model lagrange",)


def test_failed_missing_running_interrupted(store, toy, stage):
    def fails(folder):
        raise ValueError("no")

    with pytest.raises(StageFailed):
        store.compute(stage(a=1), fails)
    with pytest.raises(KeyboardInterrupt):
        store.compute(stage(a=2), lambda folder: (_ for _ in ()).throw(KeyboardInterrupt))
    list_runs(store, ["toy-0123456789"])
    seen = {}

    def looks(folder):
        seen.update(states(store))
        return {}

    running = store.compute(stage(a=3), looks)
    assert seen[stage(a=1).id].state == "failed"
    assert seen[stage(a=1).id].why == ("ValueError: no",)
    assert seen[stage(a=1).id].command == "repro run toy"
    assert seen[stage(a=2).id].state == "interrupted"
    assert seen[running.id].state == "running"
    assert "process" in seen[running.id].why[0]
    assert seen["toy-0123456789"].state == "missing"
    assert seen["toy-0123456789"].experiments == ("quick/basis",)
    assert seen["toy-0123456789"].command == "repro run n=0"
    assert states(store)[running.id].state == "done"


def test_damage_shows_and_verify_reads_every_byte(store, stage):
    good = store.compute(stage(a=1), lambda folder: (folder / "a.txt").write_text("abc") and {})
    bad = store.compute(stage(a=2), lambda folder: {})
    bad.path("run.json").write_text("{")
    found = states(store)
    assert found[bad.id].state == "damaged"
    assert found[good.id].state == "done"
    good.path("a.txt").write_text("abd")
    assert states(store)[good.id].state == "done"
    assert states(store, verify=True)[good.id].state == "damaged"
    assert good.id not in states(store)


def test_a_broken_experiment_list_is_named(store):
    list_runs(store, ["x"])
    (store.paths.experiments / "quick" / "basis.json").write_text("[]")
    with pytest.raises(UserError, match=r"basis\.json cannot be read"):
        survey.survey(store.paths)


def test_a_job_without_a_run_is_missing(store):
    list_runs(store, [None])
    (item,) = survey.survey(store.paths)
    assert (item.id, item.state) == ("repro run n=0", "missing")


def test_ids_may_be_cut(store, stage):
    made = [store.compute(stage(a=a), lambda folder: {}).id for a in range(3)]
    assert load.resolve(store.paths, made[1]).name == made[1]
    assert load.resolve(store.paths, made[1][-10:]).name == made[1]
    assert load.resolve(store.paths, made[1][-10:-4]).name == made[1]
    with pytest.raises(UserError, match="fits 3 stages"):
        load.resolve(store.paths, "toy-fit")
    with pytest.raises(UserError, match="no stage nothing"):
        load.resolve(store.paths, "nothing")


def many_runs(store, stage, count):
    """Copies of one finished run under other ids, as an old store would hold them."""
    base = store.compute(
        Stage("runs", "toy", {f"key{n}": list(range(5)) for n in range(40)}, {}, stage().modules),
        lambda folder: {"card": {"system": "sip", "model": "lagrangian", "seeds": list(range(10)), "epochs": 1000}},
    )
    text = base.path("run.json").read_text()
    for number in range(1, count):
        folder = store.paths.folder("runs", f"toy-{number:010x}")
        folder.mkdir()
        (folder / "run.json").write_text(text.replace(base.id, folder.name))
    list_runs(store, store.paths.ids("runs"))


def test_status_of_many_runs_reads_each_once_and_its_code_once(store, stage, monkeypatch):
    """What takes time with thousands of runs: their files, and the comparison of the code that made them."""
    many_runs(store, stage, 200)
    read, compared = [], []
    entry, reasons = index._entry, survey._code_reasons
    monkeypatch.setattr(index, "_entry", lambda file, id, *rest: read.append(id) or entry(file, id, *rest))
    monkeypatch.setattr(survey, "_code_reasons", lambda stored: compared.append(1) or reasons(stored))
    for times in (1, 2):
        items = survey.survey(store.paths)
        assert [item.state for item in items] == ["done"] * 200
        assert len(read) == len(set(read)) == 200 and len(compared) == times


def test_holder_is_readable_while_waiting(store, stage, tmp_path):
    assert lock.holder_text(tmp_path / HOLDER_FILE) == "another process"
    (tmp_path / HOLDER_FILE).write_text(json.dumps({"pid": 12, "host": "node7"}))
    assert lock.holder_text(tmp_path / HOLDER_FILE) == "process 12 on node7"


def test_a_whole_id_wins_over_longer_ones():
    names = ["sip-t2-aa1", "sip-t2-aa12", "dip-aa1f"]
    assert load.matching(names, "sip-t2-aa1") == ["sip-t2-aa1"]
    assert load.matching(names, "aa1") == names
    assert load.matching(names, "dip") == ["dip-aa1f"]
    assert load.matching(names, "t2") == []
