"""A full or read-only disk: one clear line, and nothing already finished is lost."""

from __future__ import annotations

import json
import os
import subprocess

import numpy as np
import pytest

from repro.errors import UserError
from repro.tracking import code, provenance
from repro.tracking.files import write_bytes
from repro.tracking.store import Store


@pytest.fixture
def small_disk(root, monkeypatch):
    """A file system of 300 KB at the outputs root; needs the right to mount."""
    monkeypatch.setattr(provenance, "source_tree", lambda: None)
    provenance._source.cache_clear()
    root.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=300k", "tmpfs", str(root)]
    mounted = subprocess.run(mount, check=False, capture_output=True)
    if mounted.returncode:
        pytest.skip("mounting a small file system needs root; the limit on file sizes is tested everywhere")
    yield root
    subprocess.run(["umount", "--lazy", str(root)], check=True)


def small(folder):
    (folder / "small.txt").write_text("done")
    return {}


def large(folder):
    np.save(folder / "large.npy", np.zeros(1_000_000))
    return {}


def test_full_disk(small_disk, stage):
    store = Store(small_disk)
    finished = store.compute(stage(a=1), small)
    with pytest.raises(UserError, match=rf"cannot write in {small_disk}: the disk is full.*REPRO_OUTPUTS") as caught:
        store.compute(stage(a=2), large)
    assert "\n" not in str(caught.value)
    assert store.find(finished.id, verify=True) == finished
    assert store.find(stage(a=2).id) is None
    assert store.compute(stage(a=2), small).outcome == "ok"


def test_a_library_that_hides_the_full_disk(small_disk, stage):
    def work(folder):
        try:
            large(folder)
        except OSError:
            raise RuntimeError("unexpected position 64 vs 128") from None

    with pytest.raises(UserError, match="the disk is full"):
        Store(small_disk).compute(stage(a=1), work)


def test_disk_full_at_every_step_of_the_store_itself(small_disk, stage):
    """Fill the disk to within n bytes, for many n: the store finishes the stage or says why not."""
    store = Store(small_disk)
    finished = store.compute(stage(a=0), small)
    filler = small_disk / "filler"
    for left in range(0, 12):
        free = os.statvfs(small_disk).f_bavail * os.statvfs(small_disk).f_frsize
        filler.write_bytes(b"\0" * max(0, free - left * 4096))
        try:
            record = store.compute(stage(a=1 + left), small)
            assert store.find(record.id, verify=True) == record
        except UserError as error:
            assert "the disk is full" in str(error)
            assert store.find(stage(a=1 + left).id) is None
        filler.unlink()
        assert store.find(finished.id, verify=True) == finished


def test_read_only(small_disk, stage):
    store = Store(small_disk)
    finished = store.compute(stage(a=1), small)
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    code.closure.cache_clear()
    assert store.compute(stage(a=1), large) == finished
    with pytest.raises(UserError, match="the file system is read-only"):
        store.compute(stage(a=2), small)


def test_largest_file_size(root, start):
    """The same through the limit that every user may set."""
    process = start(
        """
        import json, resource, signal
        from repro.errors import UserError
        from repro.tracking.paths import outputs_root
        from repro.tracking.stage import Stage
        from repro.tracking.store import Store

        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (5_000_000, 5_000_000))
        store = Store(outputs_root())
        def stage(a):
            return Stage("fits", "toy", {"a": a}, {}, ("toyjobs",))
        finished = store.compute(stage(1), lambda folder: {})
        try:
            store.compute(stage(2), lambda folder: (folder / "big").write_bytes(bytes(6_000_000)))
        except UserError as error:
            print(json.dumps([str(error), store.find(finished.id, verify=True) == finished, store.find(stage(2).id)]))
        """
    )
    output, _ = process.communicate(timeout=30)
    message, kept, absent = json.loads(output.splitlines()[-1])
    assert "the largest allowed file size is reached" in message
    assert kept
    assert absent is None


def test_an_error_elsewhere_is_the_works_own(root, stage):
    def work(folder):
        raise PermissionError(13, "Permission denied", "/somewhere/else.csv")

    with pytest.raises(Exception, match="PermissionError") as caught:
        Store(root).compute(stage(a=1), work)
    assert caught.value.record.failure.type == "PermissionError"


def test_a_file_is_old_or_new(tmp_path, monkeypatch):
    file = tmp_path / "a.json"
    write_bytes(file, b"old")

    def fails(descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", fails)
    with pytest.raises(OSError, match=r"No space left on device.*a\.json"):
        write_bytes(file, b"new")
    assert file.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [file]
