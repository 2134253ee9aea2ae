"""What the recordings of a run and of a closed loop draw of a system in the same way."""

import numpy as np

from repro.mechanics.inputs import input_matrix
from repro.mechanics.system import System


def world_points(system: System, states: np.ndarray) -> np.ndarray:
    """World points (..., n_points, 2) in m, y up, of states (..., 2 n_q)."""
    components = [states[..., index] for index in range(system.n_q)]
    points = [np.stack(np.broadcast_arrays(*point), axis=-1) for point in system.body_points(components, np)]
    return np.stack(np.broadcast_arrays(*points), axis=-2)


def driven_forces(system: System, tau: np.ndarray) -> dict[str, np.ndarray]:
    """The components of tau (steps, n_q) that the inputs of a system reach, by the name of their coordinate."""
    driven = np.any(tau != 0, axis=0) | np.any(input_matrix(system, np.ones(system.n_q)) != 0, axis=1)
    return {c.name: tau[:, index] for index, c in enumerate(system.coordinates) if driven[index]}
