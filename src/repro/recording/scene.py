"""The moving cart and its links in a 2D view: fixed shapes, moved by columns of transforms."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from repro.recording import palette
from repro.recording.contents import PLANT

if TYPE_CHECKING:
    import rerun as rr
    import rerun.blueprint as rrb

ROOT = "scene"
# Sizes of the drawing, in parts of the first link's length.
CART = (0.28, 0.1)
WHEEL = 0.08
RAIL = -CART[1] - 2 * WHEEL
# The camera goes with the plant's cart once that travels further than this many times the reach of its links.
MOST_REACHES_IN_VIEW = 6.0
MOST_MARKS = 400


def to_view(points: np.ndarray) -> np.ndarray:
    """World points (..., 2), y up, as the viewer draws them, y down: the one place where the sign changes.

    NaN where single precision cannot hold a coordinate.
    """
    with np.errstate(over="ignore"):
        drawn = np.asarray(points).astype(np.float32) * np.array([1, -1], dtype=np.float32)
    return np.where(np.isfinite(drawn), drawn, np.float32(np.nan))


@dataclass(frozen=True)
class Frame:
    """What the camera shows; m, y up.

    x, y      lowest and highest coordinate in view
    follows   whether the camera goes with the plant's cart, x and y then being relative to it
    track     lowest and highest x of the drawn track
    scale     length of the first link, by which the drawing is sized
    """

    x: tuple[float, float]
    y: tuple[float, float]
    follows: bool
    track: tuple[float, float]
    scale: float


def frame_of(points: np.ndarray, obstacle: tuple[float, float, float] | None) -> Frame:
    """The frame that suits the plant's points (steps, n_points, 2) and the obstacle (centre x, y and radius)."""
    lengths = np.linalg.norm(np.diff(points[0], axis=0), axis=-1)
    scale = float(lengths[0]) if lengths.size else 1.0
    reach = float(lengths.sum()) or scale
    cart = points[:, 0, 0]
    low, high = float(cart.min()), float(cart.max())
    margin = reach + 0.4 * scale
    x = low - margin, high + margin
    y = min(float(points[..., 1].min()), 2 * RAIL * scale) - 0.4 * scale, float(points[..., 1].max()) + 0.4 * scale
    if obstacle is not None:
        centre_x, centre_y, radius = obstacle
        x = min(x[0], centre_x - radius), max(x[1], centre_x + radius)
        y = min(y[0], centre_y - 1.2 * radius), max(y[1], centre_y + 1.2 * radius)
    follows = high - low > MOST_REACHES_IN_VIEW * reach
    track = (x[0] - 4 * margin, x[1] + 4 * margin)
    return Frame((-1.5 * margin, 1.5 * margin) if follows else x, y, follows, track, scale)


def view(frame: Frame) -> rrb.Spatial2DView:
    """The 2D view of everything in the scene."""
    import rerun.blueprint as rrb

    corners = to_view(np.stack([frame.x, frame.y], axis=-1))
    return rrb.Spatial2DView(
        origin=f"/{ROOT}/{PLANT}/cart" if frame.follows else f"/{ROOT}",
        contents=f"/{ROOT}/**",
        name="Motion [m]",
        visual_bounds=rrb.VisualBounds2D(x_range=corners[:, 0], y_range=np.sort(corners[:, 1])),
    )


def log_surroundings(recording: rr.RecordingStream, frame: Frame, obstacle: tuple[float, float, float] | None) -> None:
    """The track with its marks in metres, and the obstacle (centre x, y and radius, m)."""
    import rerun as rr

    (low, high), scale = frame.track, frame.scale
    rail = RAIL * scale
    spacing = max(1.0, float(np.ceil((high - low) / MOST_MARKS)))
    marks = np.arange(np.ceil(low / spacing), np.floor(high / spacing) + 1) * spacing
    strips = [[[low, rail], [high, rail]], *([[mark, rail], [mark, rail - 0.08 * scale]] for mark in marks)]
    lines = rr.LineStrips2D(to_view(np.array(strips)), radii=0.01 * scale, colors=palette.TRACK, draw_order=0)
    labels = rr.Points2D(
        to_view(np.stack([marks, np.full_like(marks, rail - 0.14 * scale)], axis=-1)),
        radii=0.0,
        colors=palette.TRACK,
        labels=[f"{mark:g} m" for mark in marks],
        show_labels=True,
    )
    recording.log(f"{ROOT}/track", lines, static=True)
    recording.log(f"{ROOT}/track/marks", labels, static=True)
    if obstacle is not None:
        angle = np.linspace(0, 2 * np.pi, 65)
        circle = np.array(obstacle[:2]) + obstacle[2] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        shape = rr.LineStrips2D([to_view(circle)], radii=0.02 * scale, colors=palette.OBSTACLE)
        recording.log(f"{ROOT}/obstacle", shape, static=True)


def log_body(
    recording: rr.RecordingStream,
    name: str,
    time: rr.TimeColumn,
    points: np.ndarray,
    *,
    scale: float,
    colour: palette.Colour,
    solid: bool,
) -> None:
    """A cart with its rigid links, from the world positions of cart and joints (steps, n_points, 2), m, y up.

    Solid, or an outline; hidden where its points are not finite.
    """
    import rerun as rr

    root, order = f"{ROOT}/{name}", 20 if solid else 10
    width, height = scale * CART[0], scale * CART[1]
    if solid:
        bar = np.array([[[height - width, 0.0], [width - height, 0.0]]])
        cart: rr.AsComponents = rr.LineStrips2D(bar, radii=height, colors=colour, draw_order=order)
        axles = to_view(np.array([[-0.55 * width, -height - scale * WHEEL], [0.55 * width, -height - scale * WHEEL]]))
        wheels = rr.Points2D(axles, radii=scale * WHEEL, colors=colour, draw_order=order)
        recording.log(f"{root}/cart/wheels", wheels, static=True)
    else:
        cart = rr.Boxes2D(half_sizes=[[width, height]], radii=0.015 * scale, colors=colour, draw_order=order)
    recording.log(f"{root}/cart", cart, static=True)
    joints = to_view(points).swapaxes(0, 1)
    _move(recording, f"{root}/cart", time, joints[0])
    for number, (start, end) in enumerate(pairwise(joints), start=1):
        along = end - start
        length = float(np.linalg.norm(along[0]))
        thickness = 0.035 if solid else 0.02
        ends = np.array([[0.0, 0.0], [length, 0.0]])
        rod = rr.LineStrips2D(ends[None], radii=thickness * scale, colors=colour, draw_order=order + 1)
        tip = rr.Points2D(ends[1:], radii=2.6 * thickness * scale, colors=colour, draw_order=order + 2)
        recording.log(f"{root}/link{number}", rod, static=True)
        recording.log(f"{root}/link{number}/tip", tip, static=True)
        _move(recording, f"{root}/link{number}", time, start, np.arctan2(along[:, 1], along[:, 0]))


def log_prediction(recording: rr.RecordingStream, time: rr.TimeColumn, points: np.ndarray, scale: float) -> None:
    """The path (steps, nodes, 2) of the tip that a controller predicts, m, y up; nothing where it is not finite."""
    import rerun as rr

    entity = f"{ROOT}/{PLANT}/predicted"
    style = rr.LineStrips2D.from_fields(radii=0.015 * scale, colors=palette.PREDICTED, draw_order=5)
    recording.log(entity, style, static=True)
    strips = [path[np.all(np.isfinite(path), axis=-1)] for path in to_view(points)]
    recording.send_columns(entity, [time], rr.LineStrips2D.columns(strips=strips))


def log_force(recording: rr.RecordingStream, time: rr.TimeColumn, force: np.ndarray, scale: float) -> None:
    """An arrow that starts at the side of the plant's cart, two links long where the force is greatest."""
    import rerun as rr

    entity = f"{ROOT}/{PLANT}/cart/force"
    lengths = 2 * scale * force / max(float(np.abs(force).max()), np.finfo(float).tiny)
    style = rr.Arrows2D.from_fields(radii=0.025 * scale, colors=palette.FORCE, draw_order=30)
    recording.log(entity, style, static=True)
    along_track = np.array([1.0, 0.0])
    vectors = to_view(lengths[:, None] * along_track)
    origins = to_view(np.sign(force)[:, None] * scale * CART[0] * along_track)
    recording.send_columns(entity, [time], rr.Arrows2D.columns(vectors=vectors, origins=origins))


def _move(
    recording: rr.RecordingStream, entity: str, time: rr.TimeColumn, place: np.ndarray, angle: np.ndarray | None = None
) -> None:
    """Send place (steps, 2) and angle (steps,): a place that is not a number hides the shape, an angle must be one."""
    import rerun as rr

    half = np.zeros(len(place)) if angle is None else np.nan_to_num(angle) / 2
    turn = np.stack([np.zeros_like(half), np.zeros_like(half), np.sin(half), np.cos(half)], axis=-1)
    translation = np.pad(place, ((0, 0), (0, 1)))
    columns = rr.Transform3D.columns(translation=translation, quaternion=None if angle is None else turn)
    recording.send_columns(entity, [time], columns)
