"""One member of a learned model as CasADi, C and torch, from the same expressions, in a folder that needs no more."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import casadi
import numpy as np

from repro.codegen.straight_line import statements
from repro.errors import UserError
from repro.mechanics.coordinate import Coordinate
from repro.mechanics.derive import derive
from repro.models.model import Model
from repro.tracking.files import write_json, write_text

SOURCE = "model.c"
TEMPLATES = Path(__file__).with_name("templates")
LARGEST = 2000  # weights: each is a statement of the exported code
UNITS = {"kinetic, potential, lagrangian, hamiltonian": "J", "inverse": "N, N m", "forward": "of qdd"}
SYMBOLS = {"kinetic": "T", "potential": "V", "lagrangian": "L", "hamiltonian": "H", "momentum": "p", "mass_matrix": "M"}
GAUGE = "T and V as the model gives them: L is unique only up to a constant and dF(q)/dt"


@dataclass(frozen=True)
class LearnedMember:
    """A model with the weights (n_parameters,) of one member, and the run that it comes from."""

    run: str
    seed: int
    system: str  # name of the system, for the text
    command: str  # that makes the run
    card: Mapping[str, object]  # what was run
    model: Model
    weights: np.ndarray
    coordinates: Sequence[Coordinate]


def write(member: LearnedMember, folder: Path) -> list[str]:
    """Write the files into a new or empty folder; their names. UserError for content, or not 1 to LARGEST weights."""
    if not 0 < len(member.weights) <= LARGEST:
        count = len(member.weights)
        raise UserError(f"{member.run} has {count} weights per member: from 1 to {LARGEST} can be exported")
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UserError(f"{folder} exists and is not empty: choose a new folder")
    folder.mkdir(parents=True, exist_ok=True)
    functions = _functions(member.model, member.weights)
    names = _write_casadi(folder, functions)
    names += _write_torch(folder, member.model, member.weights, title=f"{member.run}, seed {member.seed}")
    about = {
        **{name: getattr(member, name) for name in ("run", "seed", "command")},
        "coordinates": [{"name": c.name, "unit": c.unit, "is_angle": c.is_angle} for c in member.coordinates],
        "units": UNITS,
        "gauge": GAUGE,
        "functions": {f.name(): [f.name_in(i) for i in range(f.n_in())] for f in functions},
        "card": member.card,
    }
    write_json(folder / "about.json", about)
    page = (
        (TEMPLATES / "README.md")
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


def _functions(model: Model, weights: np.ndarray) -> list[casadi.Function]:
    """Functions of columns q, qd, qdd or tau (n_q,): those of a Lagrangian, or the forward dynamics alone."""
    q, qd, qdd, tau = (casadi.SX.sym(name, model.n_q) for name in ("q", "qd", "qdd", "tau"))
    fixed = casadi.SX(casadi.DM(weights))
    if not model.energetic:
        return [_function("forward", {"q": q, "qd": qd, "tau": tau}, "qdd", model.acceleration(q, qd, tau, fixed))]
    energies = model.energies(q, qd, fixed)
    dynamics = derive(energies.kinetic, energies.potential, casadi.SX(0), q, qd)
    none, state = casadi.SX(0, 1), {"q": q, "qd": qd}
    return [
        *(_function(name, state, symbol, getattr(dynamics, name)(q, qd, none)) for name, symbol in SYMBOLS.items()),
        _function("inverse", state | {"qdd": qdd}, "tau", model.inverse_dynamics(q, qd, qdd, fixed)),
        _function("forward", state | {"tau": tau}, "qdd", model.acceleration(q, qd, tau, fixed)),
    ]


def _write_casadi(folder: Path, written: Sequence[casadi.Function]) -> list[str]:
    """Write each function to a file of its name, and all of them to C; return the names of the files."""
    generator = casadi.CodeGenerator(SOURCE, {"with_header": True})
    for function in written:
        function.save(str(folder / f"{function.name()}.casadi"))
        generator.add(function)
    generator.generate(f"{folder}/")
    return [*(f"{function.name()}.casadi" for function in written), SOURCE, "model.h"]


def _function(name: str, inputs: dict[str, casadi.SX], output: str, expression: casadi.SX) -> casadi.Function:
    return casadi.Function(name, [*inputs.values()], [casadi.densify(expression)], [*inputs], [output], {"cse": True})


def _write_torch(folder: Path, model: Model, weights: np.ndarray, title: str) -> list[str]:
    """Write model.py and weights.npz; return their names."""
    np.savez(folder / "weights.npz", parameters=weights)
    q, qd, tau, parameters = model.symbols("q", "qd", "tau")
    if model.energetic:
        energies = model.energies(q, qd, parameters)
        outputs = casadi.vertcat(energies.kinetic, energies.potential, model.friction(q, qd, parameters))
        code, rest = _code("_energies_and_friction", {"q": q, "qd": qd, "parameters": parameters}, outputs), "energies"
    else:
        inputs = {"q": q, "qd": qd, "tau": tau, "parameters": parameters}
        code, rest = _code("_forward", inputs, model.acceleration(q, qd, tau, parameters)), "forward"
    head = (TEMPLATES / "head.py.txt").read_text().format(title=title, n_q=model.n_q)
    (folder / "model.py").write_text(head + code + (TEMPLATES / f"{rest}.py.txt").read_text())
    return ["model.py", "weights.npz"]


def _code(name: str, inputs: dict[str, casadi.SX], expression: casadi.SX) -> str:
    function = casadi.Function(name[1:], [*inputs.values()], [casadi.densify(expression)], {"cse": True})
    lines, size = statements(function, tuple(inputs), "value")
    head = [f"def {name}({', '.join(inputs)}, value):", f"    w = [None] * {size}"]
    return "\n".join([*head, *(f"    {line}" for line in lines)]) + "\n"
