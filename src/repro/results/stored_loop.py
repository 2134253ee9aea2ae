"""One stored closed loop, read from the tables: figures and animations of control are drawn from it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from repro.results.columns import Settings
from repro.results.results import Results
from repro.results.selectors import Where, find_loops
from repro.results.table_schema import Row, records
from repro.tracking.lazy_pandas import pd


@dataclass(frozen=True)
class StoredLoop:
    """A closed loop at its control steps, up to where it was given up."""

    facts: Row  # its row of the control table
    settings: Settings  # of its run, by dotted key
    time: np.ndarray
    series: Mapping[str, np.ndarray]  # name -> (steps,): coordinates, rates, T, V, H, inputs, clearance
    obstacle: tuple[float, float, float] | None  # centre x, y and radius, m

    @property
    def angles(self) -> list[str]:
        """Names of the angles."""
        return [name for name in self.series if name.startswith("theta") and not name.endswith("d")]

    @property
    def settled(self) -> int:
        """The step from which it stays erect; the last one where it does not."""
        held = self.facts["held_from_s"]
        return len(self.time) - 1 if held is None else int(np.searchsorted(self.time, held))


def find_loop(results: Results, experiment: str, choices: Sequence[Where]) -> StoredLoop | None:
    """The first stored loop of the first choice that was run, a choice being columns of the control table."""
    for choice in choices:
        loops = find_loops(results, experiment, choice)
        for run in dict.fromkeys(loops["run"]):
            stored = results.closed_loops[results.closed_loops["run"] == run]
            if len(stored):
                return stored_loop(records(loops[loops["run"] == run])[0], results.configs[run], stored)
    return None


def stored_loop(facts: Row, settings: Settings, stored: "pd.DataFrame") -> StoredLoop:
    """A loop from its row of the control table, the settings of its run, and its rows of the table closed_loops."""
    disc = stored[stored["name"].str.startswith("obstacle.")].set_index("name")["value"]
    moving = stored[~stored["name"].str.startswith("obstacle.")]
    table = moving.pivot_table(index="t", columns="name", values="value", sort=False).sort_index()
    table = table[np.isfinite(table["H"])]
    return StoredLoop(
        facts=facts,
        settings=settings,
        time=table.index.to_numpy(),
        series={str(name): table[name].to_numpy() for name in table if "." not in name},
        obstacle=(disc["obstacle.x"], disc["obstacle.y"], disc["obstacle.radius"]) if len(disc) else None,
    )
