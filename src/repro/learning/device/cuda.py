"""Whether there is a CUDA device, and a step as a CUDA graph."""

from collections.abc import Callable

import torch

from repro.errors import UserError

new_stream: Callable[[], torch.cuda.Stream] = torch.cuda.Stream  # which torch does not annotate
WARM_UPS = 3  # steps before a capture: libraries choose their algorithms and allocate

Replay = Callable[[], object]


def check_device(name: str) -> None:
    """Raise UserError where torch cannot use the device of this name (`cpu`, `cuda`)."""
    if name == "cuda" and not torch.cuda.is_available():
        build = "this build of torch has no CUDA" if torch.version.cuda is None else "torch finds no CUDA device here"
        raise UserError(f"device = 'cuda': {build}; use device=cpu, or run where there is one")


def captured(step: Replay) -> tuple[Replay, str | None]:
    """The step as a CUDA graph, which starts all its kernels at once; or the step itself, and why it is no graph.

    The step takes no arguments and works in place on tensors that stay where they are. It runs a few times first.
    """
    try:
        graph, stream = torch.cuda.CUDAGraph(), new_stream()
        stream.wait_stream(torch.cuda.current_stream())
        with torch.cuda.stream(stream):
            for _ in range(WARM_UPS):
                step()
        torch.cuda.current_stream().wait_stream(stream)
        with torch.cuda.graph(graph, capture_error_mode="thread_local"):
            step()
    except RuntimeError as error:
        return step, str(error).partition("\n")[0]
    return graph.replay, None
