"""Recordings as people bring them: each is read as what it is, or refused in one line that says what to do."""

from pathlib import Path

import numpy as np
import pytest

import repro
from repro.data.data_options import Columns, RecordingFile, Units
from repro.data.recording_file import from_file
from repro.errors import UserError
from repro.mechanics.system import load

SHARED = Path(repro.__file__).resolve().parents[2].parent / "shared" / "cases"
pytestmark = pytest.mark.skipif(not SHARED.is_dir(), reason="the collection of recordings is not beside the checkout")

ROLES = {"time": ("time",), "q": ("x", "theta"), "qd": ("xd", "thetad"), "tau": ("force", "torque")}
ACCELERATIONS = {"qdd": ("xdd", "thetadd")}
WITH_UNITS = {"time": ("t [s]",), "q": ("x [m]", "theta [rad]"), "qd": ("dx/dt", "θ_dot"), "tau": ("F,cart", "M (Nm)")}
DEGREES = Units(q=("m", "deg"), qd=("m/s", "deg/s"), qdd=("m/s^2", "deg/s^2"))

# file -> changed columns, other options
AS_GOOD = {  # the clean recording, in another dialect
    **dict.fromkeys(("I01_german.csv", "I01_tab.csv", "I02_bom_crlf.csv", "I03_blanks.csv", "I17_GOOD.CSV"), ({}, {})),
    **dict.fromkeys(("I17_good.tsv", "I17_good.txt"), ({}, {})),
    **dict.fromkeys(("I18_trailing_comma.csv", "I18_trailing_comma_body.csv"), ({}, {})),
    "I04_units_in_names.csv": (WITH_UNITS, {}),
    "I13_no_velocity.csv": ({"qd": (), "qdd": ()}, {}),
    "I13_one_input.csv": ({"tau": ("force",)}, {}),
    "I14_degrees.csv": ({}, {"units": DEGREES}),
    "I14_degrees_position.csv": ({}, {"units": Units(q=("m", "deg"))}),
}
AS_LONG = {  # the same longer recording
    **dict.fromkeys(("I02_utf16.csv", "I05_comments.csv", "I05_comment_header.csv", "I10_quoted.csv"), ({}, {})),
    **dict.fromkeys(("I06_datetime.parquet", "I06_epoch_s.csv", "I06_iso.csv", "I12_index.parquet"), ({}, {})),
    **dict.fromkeys(("I11_decimal.parquet", "I17_good.csv.gz", "I17_good.pq"), ({}, {})),
    "I06_ms.csv": ({}, {"units": Units(time=("ms",))}),
    "I16_no_force.csv": ({}, {}),
    "I18_truncated.csv": ({"qdd": ()}, {}),
    "I16_huge.csv": ({"qdd": ()}, {}),
}
REFUSED = {
    "I06_ms.csv": r"is the time in ms\? use data.units.time=\[ms\]",
    "I07_duplicate_stamp.csv": "time must increase",
    "I07_unsorted.csv": "time must increase",
    "I10_missing.csv": r"no finite number in data row .*data\.missing=drop",
    "I10_thousands.csv": "'1,973.68' in data row 1, which is no number",
    "I11_nullable.parquet": "no finite number",
    "I14_degrees_position.csv": "is the position in degrees",
    "I15_cos_sin.csv": "there is no column 'theta'",
    "I16_bool.csv": "true and false, not numbers",
    "I16_huge.csv": r"xdd is 1e\+200 in data row",
    "I18_truncated.csv": "'thetadd' has no finite number",
    "I18_twice_named.csv": "'x' stands twice",
}
EPISODES = {"I09_many": {}, "I09_text_labels.csv": {"episode": ("trial",)}, "episodes.csv": {"episode": ("trial",)}}


def read(name: str, columns: dict[str, tuple[str, ...]], **options):
    roles = ROLES | ACCELERATIONS | columns
    return from_file(RecordingFile("file", str(SHARED / name), Columns(**roles), **options), load("sip"))


@pytest.mark.parametrize("name", AS_GOOD)
def test_a_dialect_of_the_clean_recording(name: str) -> None:
    columns, options = AS_GOOD[name]
    data, good = read(name, columns, **options), read("good.csv", {})
    np.testing.assert_allclose(data.q, good.q, atol=1e-12)
    np.testing.assert_allclose(data.tau, good.tau, atol=1e-12)
    if "qd" not in columns or columns["qd"]:
        np.testing.assert_allclose(data.qd, good.qd, atol=1e-12)
        np.testing.assert_allclose(data.qdd, good.qdd, atol=1e-9)
    else:
        assert np.abs(data.qd - good.qd).mean() < 0.02 * np.abs(good.qd).mean()


@pytest.mark.parametrize("name", AS_LONG)
def test_a_dialect_of_the_longer_recording(name: str) -> None:
    columns, options = AS_LONG[name]
    data, good = read(name, columns, **options), read("I17_good.pq", columns)
    np.testing.assert_allclose(data.q, good.q, atol=1e-6 if "decimal" in name else 1e-12)
    np.testing.assert_allclose(data.time - data.time[0], good.time - good.time[0], atol=1e-6)
    assert data.time_step == pytest.approx(0.02, rel=1e-4)
    if name == "I16_no_force.csv":
        assert "no force acts" in " ".join(data.provenance["warnings"])
    else:
        np.testing.assert_allclose(data.tau, good.tau, atol=1e-12)


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_right_is_one_line(name: str) -> None:
    with pytest.raises(UserError, match=REFUSED[name]) as error:
        read(name, {})
    assert len(str(error.value).splitlines()) == 1


@pytest.mark.parametrize("name", EPISODES)
def test_six_episodes(name: str) -> None:
    data, labelled = read(name, EPISODES[name]), read("episodes.csv", {"episode": ("trial",)})
    np.testing.assert_array_equal(data.q, labelled.q)
    np.testing.assert_array_equal(data.episode, labelled.episode)
    assert data.episode[-1] == 5


@pytest.mark.parametrize("name", ["I08_jitter.csv", "I14_quantised.csv", "I16_tiny.csv", "I11_nullable_full.parquet"])
def test_what_is_only_poor_is_read(name: str) -> None:
    data = read(name, {"qdd": ()})
    said = " ".join(data.provenance["warnings"])
    assert "differenced" in said
    assert ("sampling intervals differ" in said) == ("jitter" in name)


def test_every_file_has_its_test() -> None:
    tested = {*AS_GOOD, *AS_LONG, *REFUSED, *EPISODES, "good.csv", "README.md", "I11_nullable_full.parquet"}
    tested |= {"I08_jitter.csv", "I14_quantised.csv", "I16_tiny.csv"}
    assert {path.name for path in SHARED.iterdir()} == tested
