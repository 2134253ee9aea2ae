"""A fully connected network that carries its own first and second directional derivatives."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import casadi
import numpy as np

from repro.codegen.lazy_torch import Tensor, torch
from repro.models.model_options import Activation


@dataclass(frozen=True)
class Network:
    """Multi-layer perceptron; its weights live in one flat vector per member, (member, n_parameters).

    `skip` adds a linear path from input to output. Weights per layer: W (out, in), then b (out).
    """

    n_in: int
    hidden: tuple[int, ...]
    n_out: int
    activation: Activation = "softplus"
    skip: bool = False
    shapes: tuple[tuple[int, ...], ...] = field(init=False)

    def __post_init__(self) -> None:
        sizes = (self.n_in, *self.hidden, self.n_out)
        shapes: list[tuple[int, ...]] = []
        for n_in, n_out in itertools.pairwise(sizes):
            shapes += [(n_out, n_in), (n_out,)]
        if self.skip:
            shapes.append((self.n_out, self.n_in))
        object.__setattr__(self, "shapes", tuple(shapes))

    @property
    def n_parameters(self) -> int:
        """Number of weights of one member."""
        return sum(math.prod(shape) for shape in self.shapes)

    def initial(self, generators: Sequence[np.random.Generator]) -> np.ndarray:
        """Glorot-uniform weights and zero biases (the Keras defaults), one draw per member: (member, n_parameters)."""
        return np.stack([np.concatenate([_glorot(shape, g) for shape in self.shapes]) for g in generators])

    def unpack(self, parameters: Tensor) -> list[Tensor]:
        """Split (member, n_parameters) into the arrays named by `shapes`, each (member, *shape)."""
        sizes = [math.prod(shape) for shape in self.shapes]
        parts = torch.split(parameters, sizes, dim=-1)
        return [part.reshape(part.shape[0], *shape) for part, shape in zip(parts, self.shapes, strict=True)]

    def propagate(self, parameters: Tensor, jets: Tensor, pairs: Sequence[tuple[int, int]] = ()) -> Tensor:
        """Carry a stack of jets through the network.

        jets: (member, sample, 1 + k + len(pairs), n_in): the value, k tangents, and one second-order row per pair
        (i, j) of tangents. Returns the same stack at the output, (member, sample, 1 + k + len(pairs), n_out): N(z),
        DN[t_i], and D^2 N[t_i, t_j] + DN[s_ij].
        """
        layers, skip = self._layers(parameters)
        output = jets
        for weight, bias in layers[:-1]:
            output = self._activate(_affine(output, weight, bias), pairs)[0]
        output = _affine(output, *layers[-1])
        return output if skip is None else output + torch.einsum("mnji,moi->mnjo", jets, skip)

    def values(self, parameters: Tensor, z: Tensor) -> Tensor:
        """N(z) alone, (member, sample, n_out), at z (member, sample, n_in)."""
        layers, skip = self._layers(parameters)
        output = z
        for weight, bias in layers[:-1]:
            output = torch.baddbmm(bias.unsqueeze(1), output, weight.mT)
            output = torch.tanh(output) if self.activation == "tanh" else torch.nn.functional.softplus(output)
        weight, bias = layers[-1]
        output = torch.baddbmm(bias.unsqueeze(1), output, weight.mT)
        return output if skip is None else output + z @ skip.mT

    def gradient(self, parameters: Tensor, z: Tensor) -> tuple[Tensor, Tensor]:
        """N and DN, (member, sample) and (member, sample, n_in), of a network with one output and no skip."""
        layers, _ = self._layers(parameters)
        value, slopes = z, []
        for weight, bias in layers[:-1]:
            value, first, _ = self._curve(torch.baddbmm(bias.unsqueeze(1), value, weight.mT))
            slopes.append(first)
        weight, bias = layers[-1]
        output = torch.baddbmm(bias.unsqueeze(1), value, weight.mT)[..., 0]
        gradient = weight
        for (weight, _), first in zip(layers[-2::-1], slopes[::-1], strict=True):
            gradient = (first * gradient) @ weight
        return output, gradient

    def lie_gradient(self, parameters: Tensor, z: Tensor, zdot: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """N, its rate DN[zdot], and at the inputs DN and its rate D^2 N[zdot]: one tangent forward, one pass back.

        z, zdot: (member, sample, n_in), for a network with one output and no skip. Returns (member, sample) twice and
        (member, sample, n_in) twice. The cost does not depend on how many derivatives are then made of the last two.
        """
        layers, skip = self._layers(parameters)
        if self.n_out != 1 or skip is not None:
            raise ValueError("the Lie derivative is that of a network with one output and no linear path")
        value, rate, slopes = z.mT, zdot.mT, []  # (member, unit, sample): samples are contiguous
        for weight, bias in layers[:-1]:
            before, before_rate = weight @ value + bias.unsqueeze(-1), weight @ rate
            value, first, second = self._curve(before)
            rate = first * before_rate
            slopes.append((first, second * before_rate))
        weight, bias = layers[-1]
        output, output_rate = weight @ value + bias.unsqueeze(-1), weight @ rate
        gradient, gradient_rate = weight.mT, torch.zeros_like(weight.mT)
        for (weight, _), (first, first_rate) in zip(layers[-2::-1], slopes[::-1], strict=True):
            gradient_rate = weight.mT @ (first * gradient_rate + first_rate * gradient)
            gradient = weight.mT @ (first * gradient)
        return output[:, 0], output_rate[:, 0], gradient.mT, gradient_rate.mT

    def jacobian(
        self, parameters: Tensor, jets: Tensor, cotangents: Tensor, pairs: Sequence[tuple[int, int]] = ()
    ) -> Tensor:
        """Per-sample gradients: the reverse of `propagate`, one outer product a layer.

        jets as in `propagate`; cotangents: (member, row, sample, jet, n_out), the derivative of each residual row with
        respect to the output stack. Returns (member, row, sample, n_parameters).
        """
        layers, skip = self._layers(parameters)
        inputs, derivatives = [jets], []
        for weight, bias in layers[:-1]:
            before = _affine(inputs[-1], weight, bias)
            after, slopes = self._activate(before, pairs)
            derivatives.append((before, slopes))
            inputs.append(after)
        gradients: list[Tensor] = []
        backward = cotangents
        for index in range(len(layers) - 1, -1, -1):
            if index < len(layers) - 1:
                backward = _activation_reverse(backward, *derivatives[index], pairs)
            gradients = [_outer(backward, inputs[index]), backward[..., 0, :], *gradients]
            backward = torch.einsum("mrnjo,moi->mrnji", backward, layers[index][0])
        if skip is not None:
            gradients.append(_outer(cotangents, jets))
        return torch.cat([g.flatten(3) for g in gradients], dim=-1)

    def expression(self, parameters: casadi.SX, z: casadi.SX) -> casadi.SX:
        """The network as a CasADi expression; parameters (n_parameters,), z (n_in,)."""
        blocks = casadi.vertsplit(parameters, [*itertools.accumulate(map(math.prod, self.shapes), initial=0)])
        arrays = [
            casadi.reshape(block, *shape[::-1]).T if len(shape) == 2 else block
            for block, shape in zip(blocks, self.shapes, strict=True)
        ]
        output, last = z, len(self.hidden)
        for index in range(last + 1):
            output = arrays[2 * index] @ output + arrays[2 * index + 1]
            if index < last:
                output = casadi.tanh(output) if self.activation == "tanh" else softplus(output)
        return output + arrays[-1] @ z if self.skip else output

    def _layers(self, parameters: Tensor) -> tuple[list[tuple[Tensor, Tensor]], Tensor | None]:
        """Weight and bias of every layer, and the weight of the linear path."""
        arrays = self.unpack(parameters)
        skip = arrays.pop() if self.skip else None
        return list(zip(arrays[0::2], arrays[1::2], strict=True)), skip

    def _curve(self, value: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """The activation and its first two derivatives."""
        if self.activation == "tanh":
            out = torch.tanh(value)
            first = 1 - out * out
            return out, first, -2 * out * first
        first = torch.sigmoid(value)
        return torch.nn.functional.softplus(value, threshold=40.0), first, first * (1 - first)

    def _activate(self, jets: Tensor, pairs: Sequence[tuple[int, int]]) -> tuple[Tensor, tuple[Tensor, Tensor, Tensor]]:
        out, first, second = self._curve(jets[:, :, 0])
        third = first * (6 * out * out - 2) if self.activation == "tanh" else second * (1 - 2 * first)
        n_tangents = jets.shape[2] - 1 - len(pairs)
        rows = [out.unsqueeze(2), first.unsqueeze(2) * jets[:, :, 1 : 1 + n_tangents]]
        if pairs:
            left, right = (jets[:, :, [1 + pair[side] for pair in pairs]] for side in (0, 1))
            seconds = jets[:, :, 1 + n_tangents :]
            rows.append(second.unsqueeze(2) * left * right + first.unsqueeze(2) * seconds)
        return torch.cat(rows, dim=2), (first, second, third)


def _activation_reverse(
    cotangent: Tensor, before: Tensor, slopes: tuple[Tensor, Tensor, Tensor], pairs: Sequence[tuple[int, int]]
) -> Tensor:
    """Cotangents (member, row, sample, jet, unit) after the activation -> before it."""
    first, second, third = (slope.unsqueeze(1) for slope in slopes)
    jets = before.unsqueeze(1)
    n_tangents = before.shape[2] - 1 - len(pairs)
    result = cotangent * first.unsqueeze(3)
    tangent_range = slice(1, 1 + n_tangents)
    value = result[..., 0, :] + second * (cotangent[..., tangent_range, :] * jets[..., tangent_range, :]).sum(-2)
    for index, (i, j) in enumerate(pairs):
        row = 1 + n_tangents + index
        g = cotangent[..., row, :]
        left, right, own = jets[..., 1 + i, :], jets[..., 1 + j, :], jets[..., row, :]
        value = value + g * (third * left * right + second * own)
        result[..., 1 + i, :] += second * right * g
        result[..., 1 + j, :] += second * left * g
    result[..., 0, :] = value
    return result


def _affine(jets: Tensor, weight: Tensor, bias: Tensor) -> Tensor:
    members, samples, rows, _ = jets.shape
    out = torch.bmm(jets.reshape(members, samples * rows, -1), weight.mT).reshape(members, samples, rows, -1)
    value = out[:, :, :1] + bias[:, None, None]
    return torch.cat([value, out[:, :, 1:]], dim=2)


def _outer(cotangent: Tensor, jets: Tensor) -> Tensor:
    return torch.einsum("mrnjo,mnji->mrnoi", cotangent, jets)


def _glorot(shape: tuple[int, ...], generator: np.random.Generator) -> np.ndarray:
    if len(shape) == 1:
        return np.zeros(shape)
    limit = math.sqrt(6.0 / (shape[0] + shape[1]))
    return generator.uniform(-limit, limit, math.prod(shape))


def softplus(x: casadi.SX) -> casadi.SX:
    """log(1 + exp(x)) of every entry of an expression of any shape, without overflow."""
    # comparisons instead of fmax and fabs: CasADi's derivatives of these at 0 would lose the curvature 1/4 there
    positive = x >= 0
    return positive * x + casadi.log1p(casadi.exp((1 - 2 * positive) * x))
