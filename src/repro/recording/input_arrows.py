"""The inputs in the picture: an arrow for a force, an arc for a torque, as long as the input is large."""

from collections.abc import Mapping, Sequence

import numpy as np
import rerun as rr

from repro.recording import palette
from repro.recording.contents import PLANT, DrawnShape
from repro.recording.scene import ROOT, to_view

LONGEST = 1.2  # of the scale of the scene, where an input is greatest
WIDEST = 2.5  # rad, the arc of a torque where it is greatest
CORNERS = 24


def log_inputs(
    recording: rr.RecordingStream,
    time: rr.TimeColumn,
    shapes: Sequence[DrawnShape],
    inputs: Mapping[str, np.ndarray],
    scale: float,
) -> None:
    """Arrows and arcs of the plant's inputs, name -> (steps,), in units of the greatest of each."""
    named = list(inputs.items())
    for shape in shapes:
        if shape.kind not in ("arrow", "turn") or shape.input >= len(named):
            continue
        name, values = named[shape.input]
        share = values / max(float(np.abs(values).max()), np.finfo(float).tiny)
        entity, foot = f"{ROOT}/{PLANT}/{name}", shape.points[:, 0]
        if shape.turn is not None:
            style: rr.AsComponents = rr.Arrows2D.from_fields(radii=0.025 * scale, colors=palette.FORCE, draw_order=30)
            along = np.stack([np.cos(shape.turn), np.sin(shape.turn)], axis=-1)
            vectors = LONGEST * scale * share[:, None] * along
            columns = rr.Arrows2D.columns(vectors=to_view(vectors), origins=to_view(foot))
        else:
            style = rr.LineStrips2D.from_fields(radii=0.025 * scale, colors=palette.FORCE, draw_order=30)
            strips = to_view(foot[:, None] + shape.size[0] * _arc(shape.size[1] * share))
            columns = rr.LineStrips2D.columns(strips=list(strips))
        recording.log(entity, style, static=True)
        recording.send_columns(entity, [time], columns)


def _arc(share: np.ndarray) -> np.ndarray:
    """Points (steps, corners, 2) of an arc of radius 1 from its top, clockwise, with the two barbs of an arrow."""
    end = (WIDEST * share)[:, None]
    angle = np.concatenate([end * np.linspace(0, 1, CORNERS), end, end, end], axis=1)
    radius = np.ones_like(angle)
    barb = np.sign(share) * np.minimum(np.abs(WIDEST * share), 0.4)
    angle[:, -3] -= barb
    angle[:, -1] -= barb
    radius[:, -3], radius[:, -1] = 1.3, 0.7
    arc: np.ndarray = radius[..., None] * np.stack([np.sin(angle), np.cos(angle)], axis=-1)
    return arc
