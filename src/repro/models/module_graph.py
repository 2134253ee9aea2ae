"""A torch module as CasADi expressions: its graph, traced by torch.fx, evaluated on arrays of symbols."""

import operator
from collections.abc import Callable, Mapping
from typing import Any

import casadi
import numpy as np
import torch
from torch import fx, nn


class NotSymbolicError(ValueError):
    """A module uses an operation that has no counterpart in CasADi, or cannot be traced at all."""


def symbolic(module: nn.Module, method: str, inputs: list[casadi.SX], weights: Mapping[str, np.ndarray]) -> Any:
    """What a method of a module returns for CasADi columns: an array of scalar expressions, or a tuple of them.

    weights: by parameter, arrays of expressions in its shape. NotSymbolicError names what cannot be translated.
    """
    columns = [np.array(casadi.vertsplit(column), dtype=object) for column in inputs]
    try:
        graph = fx.GraphModule(module, _Tracer(method).trace(module))
    except Exception as error:  # tracing runs the user's code, which may fail in any way on a symbol
        raise NotSymbolicError(f"{type(module).__name__} cannot be traced ({error})") from error
    try:
        return _Symbolic(graph, weights).run(*columns)
    except NotSymbolicError as error:  # torch.fx adds a trace of its own to the message
        raise NotSymbolicError(str(error).partition("\n")[0]) from None


class _Tracer(fx.Tracer):
    """Traces any one method of a module."""

    def __init__(self, method: str) -> None:
        super().__init__()
        self.traced_func_name = method


class _Symbolic(fx.Interpreter):
    """Runs a traced graph on numpy arrays of CasADi scalars."""

    def __init__(self, graph: fx.GraphModule, weights: Mapping[str, np.ndarray]) -> None:
        super().__init__(graph)
        self.weights = weights

    def run_node(self, n: fx.Node) -> Any:
        try:
            value = super().run_node(n)
        except NotSymbolicError:
            raise
        except (TypeError, ValueError, IndexError, KeyError, AttributeError) as error:
            raise NotSymbolicError(f"{n.target} has no symbolic form here ({' '.join(str(error).split())})") from error
        return as_array(value)  # numpy turns an array without axes into its only entry

    def get_attr(self, target: Any, args: Any, kwargs: Any) -> Any:
        if target in self.weights:
            return self.weights[target]
        return self.fetch_attr(target).detach().double().numpy()

    def call_module(self, target: Any, args: Any, kwargs: Any) -> Any:
        layer = self.fetch_attr(target)
        (x,) = args
        if isinstance(layer, nn.Linear):
            product = x @ self.weights[f"{target}.weight"].T
            return product if layer.bias is None else product + self.weights[f"{target}.bias"]
        if isinstance(layer, nn.Softplus):
            return _softplus(x, layer.beta)
        if getattr(layer, "approximate", "none") != "none":
            raise NotSymbolicError(f"{layer} has no symbolic form, only the exact {type(layer).__name__}")
        return self._translated(type(layer).__name__.lower(), layer)(x)

    def call_function(self, target: Any, args: Any, kwargs: Any) -> Any:
        kwargs = {key: value for key, value in kwargs.items() if key != "inplace"}  # arrays of expressions are new
        return self._translated(target.__name__, target)(*args, **kwargs)

    def call_method(self, target: Any, args: Any, kwargs: Any) -> Any:
        return self._translated(target, target)(*args, **kwargs)

    def _translated(self, name: str, original: object) -> Callable[..., Any]:
        if name not in OPERATIONS:
            raise NotSymbolicError(f"{name} has no symbolic form")
        return OPERATIONS[name]


def as_array(value: Any) -> Any:
    """A scalar expression as an array without axes; anything else unchanged."""
    if not isinstance(value, casadi.SX):
        return value
    array = np.empty((), dtype=object)
    array[()] = value
    return array


def _each(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """A function of scalars for arrays of any shape."""
    each: Callable[[Any], Any] = np.frompyfunc(function, 1, 1)
    return each


def _softplus(x: Any, beta: float = 1.0) -> Any:
    # log(1 + exp(x)) without overflow
    return _each(lambda z: (casadi.fmax(z, 0) + casadi.log1p(casadi.exp(-casadi.fabs(z)))) / beta)(x * beta)


def _along(function: Callable[..., Any]) -> Callable[..., Any]:
    """A numpy function of an axis, called as torch calls it, with `dim`."""

    def translated(x: Any, dim: int = 0, **keywords: Any) -> Any:
        return function([np.asarray(part) for part in x], axis=dim, **keywords)

    return translated


def _constant(function: Callable[..., Any]) -> Callable[..., Any]:
    """A numpy function that makes an array of constants; dtype and device have no counterpart."""

    def translated(*size: Any, **_: Any) -> Any:
        return function(size[0] if len(size) == 1 else size)

    return translated


def _attribute(x: Any, name: str) -> Any:
    """An attribute of a tensor."""
    match name:
        case "T" | "ndim":
            return getattr(x, name)
        case "mT":
            return np.swapaxes(x, -1, -2)
        case "shape":
            return torch.Size(x.shape)
        case "dtype":
            return torch.float64
        case "device":
            return torch.device("cpu")
        case _:
            raise NotSymbolicError(f"the attribute {name} of a tensor has no symbolic form")


def _sum(x: Any, dim: Any = None, keepdim: bool = False) -> Any:
    return np.asarray(np.sum(x, axis=dim, keepdims=keepdim))


OPERATIONS: dict[str, Callable[..., Any]] = {
    **{
        name: _each(getattr(casadi, name))
        for name in ("cos", "sin", "tan", "tanh", "cosh", "sinh", "exp", "log", "log1p", "sqrt", "erf")
    },
    "abs": _each(casadi.fabs),
    "sigmoid": _each(lambda z: 1 / (1 + casadi.exp(-z))),
    "silu": _each(lambda z: z / (1 + casadi.exp(-z))),
    "relu": _each(lambda z: casadi.fmax(z, 0)),
    "gelu": _each(lambda z: z * (1 + casadi.erf(z / 2**0.5)) / 2),
    "softplus": _softplus,
    "identity": lambda x: x,
    "dropout": lambda x, *_, **__: x,
    "square": lambda x: x * x,
    "neg": operator.neg,
    **{name: getattr(operator, name) for name in ("add", "sub", "mul", "truediv", "pow", "matmul", "getitem")},
    "div": operator.truediv,
    "dot": lambda x, y: np.asarray(np.sum(x * y)),
    "getattr": _attribute,
    "size": lambda x, dim=None: torch.Size(x.shape) if dim is None else x.shape[dim],
    "cat": _along(np.concatenate),
    "concat": _along(np.concatenate),
    "stack": _along(np.stack),
    "sum": _sum,
    "eye": lambda *size, **_: np.eye(*size),
    **{name: _constant(getattr(np, name)) for name in ("zeros", "ones", "zeros_like", "ones_like")},
    "unsqueeze": np.expand_dims,
    "squeeze": lambda x, dim=None: np.squeeze(x, dim),
    "reshape": lambda x, *shape: np.reshape(x, shape[0] if isinstance(shape[0], tuple | list) else shape),
    "view": lambda x, *shape: np.reshape(x, shape[0] if isinstance(shape[0], tuple | list) else shape),
    "flatten": lambda x, *_: np.reshape(x, -1),
    "transpose": np.swapaxes,
    "diag": np.diag,
}
