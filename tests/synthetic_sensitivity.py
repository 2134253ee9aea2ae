"""A claim on a number and one on a pair, and runs by which each is judged with another in the place of its own."""

import json
from dataclasses import asdict

from sample_claims import number, statement
from synthetic_store import PAPER, SyntheticStore

from repro.claims.assumption_effects import gather_sensitivity
from repro.results.results import SENSITIVITY, Results
from repro.results.stored import read_stored
from repro.tracking.experiment_list import Case

NUMBER = number(part="a", selector={"basis": "t2", "regime": "episodes", "objective": "inverse"})
PAIR = statement(
    {
        "name": "paired_ratio_below",
        "metrics": ["mae_tau"],
        "where": {"objective": "inverse"},
        "against": {"objective": "forward"},
    },
    id="C14",
    part="a",
)
CLAIMS = [NUMBER, PAIR]


def sensitivity_runs(store: SyntheticStore) -> Results | None:
    """Our choice answers C4a and C14a well; on one long run the force error is ten times as large."""
    store.scale = SENSITIVITY
    ours = store.run("sip_basis", {"mae_tau": [0.25, 0.3, 0.35], "mae_qdd": [3.0, 3.0, 3.0]})
    forward = store.run("sip_basis", {"mae_tau": [0.5, 0.7, 0.8]}, objective="forward")
    long = store.run("sip_basis", {"mae_tau": [2.5, 3.0, 3.5]}, regime="long")
    long_forward = store.run("sip_basis", {"mae_tau": [0.5, 0.6, 0.7]}, regime="long", objective="forward")
    choice = ("data_regime", "data=episodes", "data=long")
    metric = Case("metric_average", "", "metric=mae_qdd", "C4a", "sip_basis", ours, ours)
    cases = [
        Case(*choice, "C4a", "sip_basis", ours, long),
        Case(*choice, "C14a", "sip_basis", ours, long),
        Case(*choice, "C14a", "sip_basis", forward, long_forward),
        metric,
    ]
    path = store.outputs / "experiments" / SENSITIVITY / "sip_basis.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"cases": [asdict(case) for case in cases]}))
    return gather_sensitivity(read_stored(store.outputs, SENSITIVITY), PAPER)
