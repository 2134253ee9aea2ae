"""Normal equations of rows that are weighted sums over nodes, as those of the momentum balance are."""

import numpy as np

from repro.learning.training_problem import TrainingProblem, TrainingTask
from repro.models.inverse_jacobians import inverse_model

TOGETHER = 4096  # nodes: their Jacobians stay small


class IntegratedRows:
    """One member's loss, J'J and J'r, from the Jacobians of the inverse model at the nodes."""

    def __init__(self, task: TrainingTask) -> None:
        assert task.share is not None
        self.inverse, measured = inverse_model(task.model), task.measured
        self.points = np.concatenate([measured[name][0].numpy() for name in ("q", "qd", "qdd")], axis=-1)
        self.tau, self.share = measured["tau"][0].numpy(), np.asarray(task.share[0])
        weight = np.ones(len(self.share)) if task.sample_weight is None else np.asarray(task.sample_weight[0])
        self.factor = np.sqrt(weight / len(self.share))

    def loss(self, parameters: np.ndarray) -> float:
        """The sum of squared rows."""
        windows, nodes, _ = self.points.shape
        forces = self.inverse.forces(self.points.reshape(windows * nodes, -1), parameters)
        rows = np.einsum("wn,wni->wi", self.share, forces.reshape(self.tau.shape) - self.tau)
        return float(((rows * self.factor[:, None]) ** 2).sum())

    def normal_equations(self, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """J'J (n_parameters, n_parameters) and J'r (n_parameters,)."""
        both = np.zeros((1 + len(parameters), 1 + len(parameters)))
        windows, nodes, width = self.points.shape
        together = max(1, TOGETHER // nodes)
        for start in range(0, windows, together):
            part = slice(start, start + together)
            points = self.points[part].reshape(-1, width)
            linear = self.inverse.linear(points, parameters).reshape(-1, nodes, self.inverse.n_q * both.shape[0])
            rows = np.matmul(self.share[part, None], linear).reshape(-1, self.inverse.n_q, both.shape[0])
            rows[..., 0] -= np.einsum("wn,wni->wi", self.share[part], self.tau[part])
            flat = (rows * self.factor[part, None, None]).reshape(-1, both.shape[0])
            both += flat.T @ flat
        return both[1:, 1:], both[0, 1:]


def integrated_rows(problem: TrainingProblem) -> IntegratedRows | None:
    """Those of a member's problem with one task of that kind whose model is written as expressions, or None."""
    (task, *others) = problem.tasks
    if task.share is None or others or problem.model.not_symbolic is not None:
        return None
    return IntegratedRows(task)
