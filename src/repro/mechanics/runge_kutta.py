"""One step of the classical Runge-Kutta method, for any kind of state."""

from collections.abc import Callable
from typing import Any


def rk4_step(rate: Callable[[Any], Any], x: Any, h: Any) -> Any:
    """The state after h s under xdot = rate(x), with a local error of order h^5 (Kutta 1901).

    x: (n,) as a numpy array or a CasADi column, or a tensor (..., n); `rate` returns the same kind and shape.
    """
    k1 = rate(x)
    k2 = rate(x + h / 2 * k1)
    k3 = rate(x + h / 2 * k2)
    k4 = rate(x + h * k3)
    return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
