"""The loss of a run over its steps, drawn small: every member thin, their median thick."""

import math
from typing import TYPE_CHECKING

from repro.report import writing

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd
    from markupsafe import Markup

WIDTH, HEIGHT = 360, 120
POINTS = 60


def learning_curve(curves: "pd.DataFrame | None") -> "Markup | None":
    """Return an SVG of the loss, both axes logarithmic; None where no loss was stored."""
    import numpy as np
    from markupsafe import Markup

    if curves is None:
        return None
    losses = curves[(curves["name"] == "loss") & (curves["value"] > 0) & np.isfinite(curves["value"])]
    steps = np.sort(losses["step"].to_numpy(dtype=float))
    if not steps.size or steps[0] == steps[-1]:
        return None
    shown = losses[losses["step"].isin(_spread(np.unique(steps)))]
    # Where one phase of the training ends the next begins, at the same step.
    table = shown.drop_duplicates(["step", "member"], keep="last").set_index(["step", "member"])["value"].unstack()
    height = np.log10(table.to_numpy())
    low, high = float(np.nanmin(height)), float(np.nanmax(height))
    across = np.log10(1 + table.index.to_numpy(dtype=float))
    x = WIDTH * (across - across[0]) / (across[-1] - across[0])
    y = HEIGHT - HEIGHT * (height - low) / max(high - low, 1e-9)
    lines = [_line("member", x, y[:, member]) for member in range(y.shape[1])]
    if y.shape[1] > 1:
        lines.append(_line("middle", x, np.nanmedian(y, axis=1)))
    first, last = (float(np.nanmedian(table.iloc[place].to_numpy())) for place in (0, -1))
    label = f"the median loss goes from {writing.number(first)} to {writing.number(last)} in {table.index[-1]} steps"
    box = f"-2 -2 {WIDTH + 4} {HEIGHT + 4}"
    drawing = "".join(lines)
    return Markup(f'<svg class="curve" role="img" aria-label="{label}" viewBox="{box}">{drawing}</svg>')


def _spread(steps: "np.ndarray") -> "np.ndarray":
    """About POINTS of the steps, even on the logarithmic axis; first and last are among them."""
    import numpy as np

    wanted = np.expm1(np.linspace(np.log1p(steps[0]), np.log1p(steps[-1]), POINTS))
    return steps[np.unique(np.searchsorted(steps, wanted - 1e-9).clip(max=len(steps) - 1))]


def _line(kind: str, x: "np.ndarray", y: "np.ndarray") -> str:
    points = " ".join(f"{a:.0f},{b:.0f}" for a, b in zip(x, y, strict=True) if math.isfinite(b))
    return f'<polyline class="{kind}" points="{points}"/>'
