"""The moving mechanism in a 2D view: rigid shapes are moved by columns of transforms, springs are drawn anew."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from repro.recording import palette
from repro.recording.contents import PLANT, DrawnShape, RunRecording, part

ROOT = "scene"
# Sizes of the drawing, in parts of its scale, which is the length of the first link.
WHEEL = 0.08
RAIL = -0.1 - 2 * WHEEL  # below the middle of a cart
# The camera goes with the plant's block once that travels further than this many times the reach of all else from it.
MOST_REACHES_IN_VIEW = 6.0
LEAST_REACH = 0.5  # m
MOST_MARKS = 400


def to_view(points: np.ndarray) -> np.ndarray:
    """World points (..., 2), y up, as drawn, y down: the one place of that sign. NaN beyond single precision."""
    with np.errstate(over="ignore"):
        drawn = np.asarray(points).astype(np.float32) * np.array([1, -1], dtype=np.float32)
    return np.where(np.isfinite(drawn), drawn, np.float32(np.nan))


@dataclass(frozen=True)
class Frame:
    """What the camera shows; m, y up."""

    x: tuple[float, float]  # lowest and highest coordinate in view
    y: tuple[float, float]
    follows: str | None  # name of the shape that the camera goes with, x and y then being relative to it
    track: tuple[float, float, float] | None  # of a cart: lowest and highest place on it, and its slope in rad
    scale: float  # length of the first link, by which the drawing is sized


def frame_of(shapes: Sequence[DrawnShape], obstacle: tuple[float, float, float] | None) -> Frame:
    """The frame that suits the plant's shapes and the obstacle (centre x, y and radius)."""
    points = np.concatenate([shape.points for shape in shapes], axis=1)
    links = [shape.points[0] for shape in shapes if shape.kind == "link"]
    lengths = [float(np.linalg.norm(link[1] - link[0])) for link in links]
    sizes = [max(shape.size) for shape in shapes if shape.kind in ("block", "disc", "cart")]
    scale = next(iter(lengths), 2 * max(sizes, default=0.5)) or 1.0
    name, moving = next(
        ((name, shape) for name, shape in named(shapes) if shape.kind in ("cart", "block")), (None, shapes[0])
    )
    middle = moving.points[:, :1]
    reach = max(float(np.abs(points - middle).max()) if name == "cart" else LEAST_REACH, scale)
    margin = 0.4 * scale + (0.5 * reach if name == "cart" else 0.3 * scale)
    x = float(points[..., 0].min()) - margin, float(points[..., 0].max()) + margin
    y = float(points[..., 1].min()) - 0.6 * scale, float(points[..., 1].max()) + 0.6 * scale
    if obstacle is not None:
        centre_x, centre_y, radius = obstacle
        x = min(x[0], centre_x - radius), max(x[1], centre_x + radius)
        y = min(y[0], centre_y - 1.2 * radius), max(y[1], centre_y + 1.2 * radius)
    travelled = float(np.ptp(middle, axis=0).max())
    follows = name if travelled > MOST_REACHES_IN_VIEW * reach else None
    track = None
    if name == "cart" and moving.turn is not None:
        track = (x[0] - 4 * margin, x[1] + 4 * margin, float(moving.turn[0]))
    if follows is not None:
        x = y = (-1.5 * (reach + margin), 1.5 * (reach + margin))
    return Frame(x, y, follows, track, scale)


def named(shapes: Sequence[DrawnShape]) -> Iterator[tuple[str, DrawnShape]]:
    """The shapes that belong to a body, by the name of their entity: cart, link1, link2, ..."""
    counts = Counter[str]()
    for shape in shapes:
        if shape.kind not in ("arrow", "turn"):
            counts[shape.kind] += 1
            yield shape.kind + ("" if shape.kind == "cart" else str(counts[shape.kind])), shape


def view(frame: Frame) -> rrb.Spatial2DView:
    """The 2D view of everything in the scene."""
    corners = to_view(np.stack([frame.x, frame.y], axis=-1))
    return rrb.Spatial2DView(
        origin=f"/{ROOT}/{PLANT}/{frame.follows}" if frame.follows else f"/{ROOT}",
        contents=f"/{ROOT}/**",
        name="Motion [m]",
        visual_bounds=rrb.VisualBounds2D(x_range=corners[:, 0], y_range=np.sort(corners[:, 1])),
    )


def log_scene(stream: rr.RecordingStream, time: rr.TimeColumn, recording: RunRecording, frame: Frame) -> None:
    """Plant, models, and what is around them."""
    colours = palette.colours(recording.models)
    log_surroundings(stream, frame, recording.obstacle)
    if recording.predicted is not None:
        predicted = f"{ROOT}/{PLANT}/predicted"
        _strips(stream, predicted, time, to_view(recording.predicted), 0.015 * frame.scale, palette.PREDICTED, 5)
    for label, model in recording.models.items():
        log_body(stream, part(label), time, model.shapes, scale=frame.scale, colour=colours[label], solid=False)
    log_body(stream, PLANT, time, recording.plant.shapes, scale=frame.scale, colour=palette.PLANT, solid=True)
    log_inputs(stream, time, recording.plant.shapes, recording.inputs, frame.scale)


def log_surroundings(recording: rr.RecordingStream, frame: Frame, obstacle: tuple[float, float, float] | None) -> None:
    """The track of a cart with its marks in metres, and the obstacle (centre x, y and radius, m)."""
    scale = frame.scale
    if frame.track is not None:
        low, high, slope = frame.track
        spacing = max(1.0, float(np.ceil((high - low) / MOST_MARKS)))
        marks = np.arange(np.ceil(low / spacing), np.floor(high / spacing) + 1) * spacing
        rail = RAIL * scale
        strips = [[[low, rail], [high, rail]], *([[mark, rail], [mark, rail - 0.08 * scale]] for mark in marks)]
        lines = rr.LineStrips2D(
            to_view(_turned(np.array(strips), slope)), radii=0.01 * scale, colors=palette.TRACK, draw_order=0
        )
        places = np.stack([marks, np.full_like(marks, rail - 0.14 * scale)], axis=-1)
        labels = rr.Points2D(
            to_view(_turned(places, slope)),
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
    shapes: Sequence[DrawnShape],
    *,
    scale: float,
    colour: palette.Colour,
    solid: bool,
) -> None:
    """The shapes of a body; solid, or an outline; hidden where its points are not finite."""
    order = 20 if solid else 10
    for entity, shape in named(shapes):
        path, points = f"{ROOT}/{name}/{entity}", to_view(shape.points)
        thickness = (0.035 if solid else 0.02) * scale
        if shape.kind == "link" and not _rigid(shape.points):
            _strips(recording, path, time, points, thickness, colour, order + 1)
        elif shape.kind == "link":
            along = points[:, 1] - points[:, 0]
            ends = np.array([[0.0, 0.0], [float(np.linalg.norm(along[0])), 0.0]])
            rod = rr.LineStrips2D(ends[None], radii=thickness, colors=colour, draw_order=order + 1)
            tip = rr.Points2D(ends[1:], radii=2.6 * thickness, colors=colour, draw_order=order + 2)
            recording.log(path, rod, static=True)
            recording.log(f"{path}/tip", tip, static=True)
            _move(recording, path, time, points[:, 0], np.arctan2(along[:, 1], along[:, 0]))
        elif shape.kind == "spring":
            _strips(recording, path, time, to_view(shape.coils(0.15 * scale)), 0.4 * thickness, colour, order)
        elif shape.kind == "disc" and shape.points.shape[1] > 1:
            style = rr.Points2D.from_fields(radii=shape.size[0], colors=colour, draw_order=order + 2)
            recording.log(path, style, static=True)
            places = rr.Points2D.columns(positions=points.reshape(-1, 2))
            recording.send_columns(path, [time], places.partition([points.shape[1]] * len(points)))
        elif shape.kind == "disc":
            disc = rr.Points2D([[0, 0]], radii=shape.size[0], colors=colour, draw_order=order + 2)
            recording.log(path, disc, static=True)
            _move(recording, path, time, points[:, 0])
        else:
            width, height = shape.size
            bar = np.array([[[height - width, 0.0], [width - height, 0.0]]])
            block: rr.AsComponents = rr.LineStrips2D(bar, radii=height, colors=colour, draw_order=order)
            if not solid:
                block = rr.Boxes2D(half_sizes=[[width, height]], radii=0.015 * scale, colors=colour, draw_order=order)
            recording.log(path, block, static=True)
            if shape.kind == "cart" and solid:
                axles = [[side * 0.55 * width, -height - scale * WHEEL] for side in (-1, 1)]
                wheels = rr.Points2D(to_view(np.array(axles)), radii=scale * WHEEL, colors=colour, draw_order=order)
                recording.log(f"{path}/wheels", wheels, static=True)
            _move(recording, path, time, points[:, 0], None if shape.turn is None else -shape.turn)


def _rigid(points: np.ndarray) -> bool:
    """Whether the ends (steps, 2, 2) of a link keep their distance in the picture, up to where a motion diverges."""
    lengths = np.linalg.norm(points[:, 1] - points[:, 0], axis=-1)
    return float(np.mean(np.abs(lengths - lengths[0]) <= 1e-6 * lengths[0])) > 0.2


def _turned(points: np.ndarray, angle: float) -> np.ndarray:
    cosine, sine = np.cos(angle), np.sin(angle)
    turned: np.ndarray = points @ np.array([[cosine, sine], [-sine, cosine]])
    return turned


def _strips(
    recording: rr.RecordingStream,
    entity: str,
    time: rr.TimeColumn,
    strips: np.ndarray,
    radius: float,
    colour: palette.Colour,
    order: int,
) -> None:
    """Lines (steps, corners, 2) that change their shape; nothing where they are not finite."""
    recording.log(entity, rr.LineStrips2D.from_fields(radii=radius, colors=colour, draw_order=order), static=True)
    drawn = [strip[np.all(np.isfinite(strip), axis=-1)] for strip in strips]
    recording.send_columns(entity, [time], rr.LineStrips2D.columns(strips=drawn))


def _move(
    recording: rr.RecordingStream, entity: str, time: rr.TimeColumn, place: np.ndarray, angle: np.ndarray | None = None
) -> None:
    """Send place (steps, 2) and angle (steps,): a place that is not a number hides the shape, an angle must be one."""
    half = np.zeros(len(place)) if angle is None else np.nan_to_num(angle) / 2
    turn = np.stack([np.zeros_like(half), np.zeros_like(half), np.sin(half), np.cos(half)], axis=-1)
    translation = np.pad(place, ((0, 0), (0, 1)))
    columns = rr.Transform3D.columns(translation=translation, quaternion=None if angle is None else turn)
    recording.send_columns(entity, [time], columns)


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
