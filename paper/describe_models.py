"""What the models of Figs. 1 to 3 consist of, read off the models themselves, for draw/architecture.py.

    python paper/describe_models.py

writes draw/architecture.json again after a change of the models.
"""

import json
from pathlib import Path
from typing import Any

import casadi
import numpy as np

from repro.models.bases import t2
from repro.models.kinds.port_hamiltonian import Options, PortHamiltonian
from repro.models.lagrangian import Lagrangian
from repro.models.network import Network
from repro.models.port_matrices import Factored, Skew

FILE = Path(__file__).parent / "draw" / "architecture.json"
COORDINATES = ("x", "θ")  # of the cart with one pendulum, in the order of q
HIDDEN, TRANSFORM_HIDDEN, MATRIX_HIDDEN = (10,), (8,), (8,)
STATE = (0.0, 0.3, 0.5, -1.0)  # q and qd at which J and R are shown


def architecture() -> dict[str, Any]:
    """Return inputs, layers and weights of every part of the PLNN on T2/V1, and of J and R of its port form."""
    n_q = len(COORDINATES)
    plnn = Lagrangian(t2, n_q, hidden=HIDDEN, momentum_hidden=TRANSFORM_HIDDEN)
    energy = Lagrangian(t2, n_q, hidden=HIDDEN)
    port = PortHamiltonian(energy, np.ones(n_q), Options(structure="full", damping_hidden=MATRIX_HIDDEN, floor=0.0))
    if plnn.network is None or plnn.transform is None or port.skew is None or port.damping is None:
        raise TypeError("the models of the figures are networks")
    matrix_inputs = [*port.features.names, *(f"qd{i}" for i in range(n_q))]
    return {
        "coordinates": list(COORDINATES),
        "plnn": {
            "T": _network(plnn.network, plnn.kinetic_features.names),
            "V": {"inputs": list(plnn.potential_features.names), "weights": len(plnn.potential_features)},
            "M": _network(plnn.transform.network, plnn.transform.features.names),
            "weights": plnn.n_parameters,
        },
        "port": {
            **_matrices(port.skew, port.damping, matrix_inputs),
            "weights": port.n_parameters,
            "J": _rounded(port.interconnection, port),
            "R": _rounded(port.resistance, port),
        },
    }


def _matrices(skew: Skew, damping: Factored, inputs: list[str]) -> dict[str, Any]:
    networks = {"A": skew.network, "L below": damping.below, "L diagonal": damping.diagonal}
    return {name: _network(network, inputs) for name, network in networks.items()}


def _network(network: Network, inputs: tuple[str, ...] | list[str]) -> dict[str, Any]:
    return {
        "inputs": list(inputs),
        "layers": [network.n_in, *network.hidden, network.n_out],
        "activation": network.activation,
        "weights": network.n_parameters,
    }


def _rounded(matrix: Any, port: PortHamiltonian) -> list[list[float]]:
    """Return J or R at `STATE` and the starting weights of one seed."""
    weights = port.initial([np.random.default_rng(0)])[0]
    q, qd = casadi.SX(STATE[: port.n_q]), casadi.SX(STATE[port.n_q :])
    value = casadi.DM(casadi.evalf(matrix(q, qd, casadi.SX(weights)))).full()
    rows: list[list[float]] = (np.round(value, 3) + 0.0).tolist()
    return rows


def main() -> None:
    """Write the file that the report draws from."""
    FILE.write_text(json.dumps(architecture(), ensure_ascii=False, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
