"""The metrics by name: how they are written for people, on which scale they average, and which way is better.

They stand in metrics.yaml. `mae_H_sum` is the error on the test part of D, `mae_H_sum@free` that on the test part of
D_H, `mae_tau[1]` that of one component, `chain_error_30` that of a chain of 30 links.
"""

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Literal

from repro.tracking.files import read_yaml

TEXT_COLUMNS = ("model", "basis", "hidden", "optimiser", "sequence", "objective", "energies", "curriculum")


@dataclass(frozen=True)
class Metric:
    """One metric: `log` errors average on the log scale, `linear` ones plainly, `share` ones are 0 or 1 for a seed."""

    label: str
    meaning: str
    scale: Literal["log", "linear", "share"] = "log"
    better: Literal["lower", "higher"] = "lower"
    split: Literal["test", "train", "free"] = "test"

    @property
    def lower_is_better(self) -> bool:
        """Whether a smaller value is the better one."""
        return self.better == "lower"


@cache
def _vocabulary() -> Any:
    """Card values as people write them (`names`), and the metrics; those of chains by links."""
    return read_yaml(Path(__file__).with_name("metrics.yaml"))


@cache
def metric_named(name: str) -> Metric:
    """Look a metric up; a component such as mae_tau[1] shares its parent's scale; an unknown one averages plainly."""
    bare, on_free, _ = name.partition("@free")
    if on_free:
        on_d = metric_named(bare)
        return replace(on_d, label=f"{on_d.label} on D_H", split="free")
    parent, bracket, component = name.partition("[")
    family, _, links = parent.rpartition("_")
    if links.isdigit() and (row := _vocabulary()["of_chains"].get(family)):
        return Metric(**{**row, "label": f"{row['label']}, {links} links"})
    if row := _vocabulary()["metrics"].get(parent):
        return Metric(**{**row, "label": f"{row['label']}{bracket}{component}"})
    return Metric(name, name, "linear")


def written(column: str, value: str) -> str:
    """Write a card value, as text, for people."""
    if column == "hidden" and value.isdigit():
        return f"1x{value}"
    return str(_vocabulary()["names"].get(value, value.replace("_", " "))) if column in TEXT_COLUMNS else value
