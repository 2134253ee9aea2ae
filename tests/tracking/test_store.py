"""The store makes a stage once, keeps it whole, and tells failures as data."""

from __future__ import annotations

import json

import pytest

from repro.tracking.paths import DAMAGED, FAILED
from repro.tracking.store import StageFailed, Store


def making(text="weights", calls=None, **summary):
    def work(folder):
        if calls is not None:
            calls.append(folder)
        (folder / "parameters.npz").write_text(text)
        return summary

    return work


def test_a_finished_stage_is_never_made_again(store, stage):
    calls = []
    first = store.compute(stage(a=1), making(calls=calls, loss=0.5))
    second = store.compute(stage(a=1), making(calls=calls))
    assert first == second
    assert len(calls) == 1
    assert first.summary == {"loss": 0.5}
    assert first.path("parameters.npz").read_text() == "weights"
    assert store.find(first.id, verify=True) == first
    assert store.records("fits") == [first]
    assert not calls[0].exists()


def test_another_config_is_another_stage(store, stage):
    records = [store.compute(stage(a=a), making(a=a)) for a in range(3)]
    assert [record.summary["a"] for record in records] == [0, 1, 2]
    assert store.find("nothing-0123456789") is None


def test_failure_is_data_and_is_tried_again(store, stage):
    def broken(folder):
        (folder / "checkpoint.pt").write_text("half")
        raise ValueError("loss is not finite")

    with pytest.raises(StageFailed, match="ValueError: loss is not finite") as caught:
        store.compute(stage(a=1), broken)
    failed = caught.value.record
    assert failed.outcome == "failed"
    assert store.find(failed.id, shelf=FAILED) == failed
    assert failed.failure.command == "repro run toy"
    assert 'raise ValueError("loss is not finite")' in failed.failure.trace
    assert store.find(failed.id) is None

    record = store.compute(stage(a=1), lambda folder: {"left": sorted(path.name for path in folder.iterdir())})
    assert record.summary["left"] == ["holder.json"]
    assert store.find(failed.id, shelf=FAILED) is None


def test_ctrl_c_keeps_the_checkpoint_and_nothing_else_counts(store, stage):
    def interrupted(folder):
        (folder / "checkpoint.pt").write_text("epoch 3")
        (folder / "run.json").write_text("{}")
        (folder / "weights.npz.tmp").write_text("half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        store.compute(stage(a=1), interrupted)
    assert store.find(stage(a=1).id) is None

    def resumed(folder):
        assert not (folder / "run.json").exists()
        assert not (folder / "weights.npz.tmp").exists()
        return {"from": (folder / "checkpoint.pt").read_text()}

    record = store.compute(stage(a=1), resumed)
    assert record.summary == {"from": "epoch 3"}
    assert list(record.files) == []


@pytest.mark.parametrize(
    "harm",
    [
        lambda folder: (folder / "run.json").write_text((folder / "run.json").read_text()[:100]),
        lambda folder: (folder / "run.json").write_text((folder / "run.json").read_text().replace("0.5", "0.4")),
        lambda folder: (folder / "run.json").write_bytes(b"\x00" * 500),
        lambda folder: (folder / "run.json").write_text("[]"),
        lambda folder: (folder / "run.json").unlink(),
        lambda folder: (folder / "parameters.npz").unlink(),
        lambda folder: (folder / "parameters.npz").write_text("weig"),
    ],
)
def test_damage_is_seen_kept_aside_and_mended(store, stage, capsys, harm):
    good = store.compute(stage(a=1), making(loss=0.5))
    other = store.compute(stage(a=2), making(loss=0.5))
    harm(good.folder)
    assert store.find(good.id) is None
    assert store.records("fits") == [other]
    again = store.compute(stage(a=1), making(loss=0.5))
    assert store.find(again.id, verify=True) is not None
    assert [folder.name for folder in store.paths.folder("fits", "", DAMAGED).iterdir()] == [f"{good.id}-1"]
    notice = capsys.readouterr().err
    assert notice.count("\n") == 1
    assert f"{good.id} was damaged" in notice


def test_a_flipped_bit_is_found_by_verify(store, stage, capsys):
    record = store.compute(stage(a=1), making("weights"))
    record.path("parameters.npz").write_text("weighty"[:7])
    assert store.find(record.id) is not None
    assert store.find(record.id, verify=True) is None
    assert "differs from its checksum" in str(store.verify("fits", record.id))
    assert store.find(record.id) is None
    assert store.verify("fits", record.id) is None


def test_a_summary_must_be_plain(store, stage):
    with pytest.raises(StageFailed, match="is not plain data"):
        store.compute(stage(a=1), lambda folder: {"model": object()})


def test_run_file_holds_what_others_read(store, stage):
    record = Store(store.paths.root, overrides=["a=1"]).compute(stage(a=1, seeds=[0, 1]), making(loss=0.5))
    content = json.loads(record.path("run.json").read_text())
    assert set(content["identity"]) == {"config", "upstream", "code", "libraries", "modules"}
    assert set(content["files"]["parameters.npz"]) == {"sha256", "bytes"}
    assert content["error"] is None
    origin = content["provenance"]
    assert origin["overrides"] == ["a=1"]
    assert origin["seeds"] == {"seeds": [0, 1]}
    assert origin["wall_s"] >= 0 and origin["cpu_s"] >= 0 and origin["peak_memory_mib"] > 1
    assert {"git", "machine", "threads", "torch", "command", "upstream"} <= set(origin)


def test_folders_inside_a_stage_are_checked_too(store, stage):
    def work(folder):
        (folder / "deep").mkdir()
        (folder / "deep" / "table.csv").write_text("1")
        return {}

    record = store.compute(stage(a=1), work)
    assert list(record.files) == ["deep/table.csv"]
    (record.folder / "deep" / "table.csv").write_text("12")
    assert store.find(record.id) is None
