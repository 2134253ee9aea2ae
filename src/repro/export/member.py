"""One member of a learned model, written to a folder that needs nothing of this project."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from repro.errors import UserError
from repro.export import casadi_functions, torch_module
from repro.mechanics.coordinate import Coordinate
from repro.models.model import Model
from repro.tracking.files import write_json, write_text

LARGEST = 2000  # weights: each is a statement of the exported code
UNITS = {"kinetic, potential, lagrangian, hamiltonian": "J", "inverse": "N, N m", "forward": "of qdd"}
GAUGE = "T and V as the model gives them: L is unique only up to a constant and dF(q)/dt"


@dataclass(frozen=True)
class LearnedMember:
    """A model with the weights (n_parameters,) of one member, and the run that it comes from.

    system   name of the system, for the text
    command  that makes the run
    card     what was run
    """

    run: str
    seed: int
    system: str
    command: str
    card: Mapping[str, object]
    model: Model
    weights: np.ndarray
    coordinates: Sequence[Coordinate]


def write(member: LearnedMember, folder: Path) -> list[str]:
    """Write the files into a new or empty folder and return their names.

    Raises UserError when the folder has content, or for a number of weights outside of 1 to LARGEST.
    """
    if not 0 < len(member.weights) <= LARGEST:
        count = len(member.weights)
        raise UserError(f"{member.run} has {count} weights per member: from 1 to {LARGEST} can be exported")
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UserError(f"{folder} exists and is not empty: choose a new folder")
    folder.mkdir(parents=True, exist_ok=True)
    functions = casadi_functions.functions(member.model, member.weights)
    names = casadi_functions.write(folder, functions)
    names += torch_module.write(folder, member.model, member.weights, title=f"{member.run}, seed {member.seed}")
    about = {
        "run": member.run,
        "seed": member.seed,
        "command": member.command,
        "coordinates": [{"name": c.name, "unit": c.unit, "is_angle": c.is_angle} for c in member.coordinates],
        "units": UNITS,
        "gauge": GAUGE,
        "functions": {f.name(): [f.name_in(i) for i in range(f.n_in())] for f in functions},
        "card": member.card,
    }
    write_json(folder / "about.json", about)
    page = (
        (torch_module.TEMPLATES / "README.md")
        .read_text()
        .format(
            run=member.run,
            system=member.system,
            inputs=", ".join(f"{c.name} in {c.unit}" for c in member.coordinates),
            n_q=len(member.coordinates),
            files=", ".join(names),
        )
    )
    write_text(folder / "README.md", page)
    return ["README.md", "about.json", *names]
