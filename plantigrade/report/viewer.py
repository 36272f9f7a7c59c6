"""``viewer.html``: one self-contained page with the moving body, its forces and its curves.

The page draws with its own few hundred lines of WebGL 2. viser's static page was measured first
(0.8 MB): it has no follow camera, plays no slower than half speed, and hands neither its clock nor
its camera to the page around it, so curves could not move with the body. viser serves the live
view, :mod:`plantigrade.report.live`.
"""

import base64
import json
from importlib import resources

import mujoco
import numpy as np

from plantigrade.motion import Table
from plantigrade.record import Record
from plantigrade.report import theme
from plantigrade.report.curves import Line, Panel, hinge_table, panels_of
from plantigrade.report.scene import VIEW_RATE, Scene, build_scene, side_forces

BODY, LEFT_BODY, RIGHT_BODY, STATIC = "#c9c3ba", "#dd9c74", "#7fa9c9", "#b8bec7"
COM = "#e0b020"


def viewer_html(
    model: mujoco.MjModel,
    record: Record,
    *,
    title: str,
    subtitle: str = "",
    curves: Table | dict[str, np.ndarray] | None = None,
    reference_label: str = "Reference",
    rate: float = VIEW_RATE,
) -> str:
    """Return the page as one string without any outside address.

    Args:
        model: The body.
        record: What to show on it.
        title: Heading.
        subtitle: One line beside it.
        curves: Curves beside the body: coordinates in radians, or arrays by ``"name [unit]"``;
            every hinge of the model where None.
        reference_label: What the translucent body is.
        rate: Frames per second kept [Hz]; the page interpolates between them.

    Raises:
        ParameterError: If the record does not fit the model.
    """
    from jinja2 import Environment
    from markupsafe import Markup

    scene = build_scene(model, record, rate=rate)
    panels = panels_of(
        hinge_table(model, record.motion) if curves is None else curves, record.motion.n_frames
    )
    panels = (*panels, *force_panels(record, scene.weight))
    has_force = scene.total_force is not None and bool(np.any(scene.total_force))
    has = {
        "reference": scene.reference_positions is not None,
        "recorded": scene.recorded is not None,
        "fitted": scene.fitted is not None,
        "force": has_force and scene.cop is not None and bool(np.isfinite(scene.cop).any()),
        "cop": scene.cop is not None and bool(np.isfinite(scene.cop).any()),
    }
    template = Environment(autoescape=True).from_string(template_text("viewer.html"))
    text = json.dumps(_payload(model, record, scene, panels), separators=(",", ":"))
    return template.render(
        title=title,
        subtitle=subtitle,
        css=Markup(template_text("viewer.css")),
        js=Markup(template_text("viewer.js")),
        scene=Markup(text.replace("<", "\\u003c")),
        colours=_colours(),
        has=has,
        weight=round(scene.weight),
        reference_label=reference_label,
    )


def template_text(name: str) -> str:
    """Return the text of the packaged template ``name``."""
    return (resources.files("plantigrade.report") / "templates" / name).read_text("utf-8")


def force_panels(record: Record, weight: float) -> tuple[Panel, ...]:
    """Return ground reaction over time in fractions of body weight, vertical and forward."""
    total, _ = side_forces(record, weight)
    if total is None or not np.any(total):
        return ()
    panels = []
    for axis, title in ((2, "Ground reaction, vertical"), (0, "Ground reaction, forward")):
        lines = tuple(
            Line(label, colour, total[:, row, axis] / weight)
            for row, (label, colour) in enumerate(
                (("right", theme.RIGHT), ("left", theme.LEFT), ("", theme.MIDDLE))
            )
            if np.any(total[:, row])
        )
        panels.append(Panel(title, " BW", lines))
    return tuple(panels)


def encode(array: np.ndarray) -> dict:
    """Return ``array`` as 16-bit steps in base64; NaN becomes 65535.

    The step is the range over 65534: 0.15 mm over a walkway of ten metres.
    """
    values = np.asarray(array, dtype=float)
    finite = values[np.isfinite(values)]
    low = float(finite.min()) if finite.size else 0.0
    step = float((finite.max() - low) / 65534) if finite.size and finite.max() > low else 1.0
    words = np.where(np.isfinite(values), np.round((np.nan_to_num(values) - low) / step), 65535)
    data = base64.b64encode(words.astype("<u2").tobytes()).decode("ascii")
    return {"data": data, "low": low, "step": step}


def _colours() -> dict[str, str]:
    return {
        "recorded": theme.RECORDED,
        "fitted": theme.FITTED,
        "reference": theme.REFERENCE,
        "left": theme.LEFT,
        "right": theme.RIGHT,
        "com": COM,
    }


def shape_colour(shape) -> tuple[float, float, float]:
    """Return the colour of a shape: the model's own, else by side."""
    if shape.colour is not None:
        return shape.colour
    sides = {"r": RIGHT_BODY, "l": LEFT_BODY}
    text = STATIC if shape.body == 0 else sides.get(shape.side or "", BODY)
    red, green, blue = (int(text[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return red, green, blue


def heading_of(scene: Scene) -> float:
    """Return the direction of travel about the vertical [rad]; 0 (forward) for less than 0.3 m."""
    way = scene.com[-1, :2] - scene.com[0, :2]
    return float(np.arctan2(way[1], way[0])) if np.linalg.norm(way) > 0.3 else 0.0


def standing_height(scene: Scene) -> float:
    """Return how tall the moving body is in the tallest frame, from its shapes' centres [m]."""
    top = 0.0
    for shape in scene.shapes:
        if shape.body:
            reach = float(np.max(shape.size)) if shape.kind != "mesh" else 0.0
            top = max(top, float(scene.positions[:, shape.body, 2].max()) + reach)
    return float(np.clip(top + 0.1, 0.4, 3.0))


def _payload(model, record, scene, panels):
    shapes = []
    for shape in scene.shapes:
        item = {
            "kind": shape.kind,
            "size": _rounded(shape.size),
            "position": _rounded(shape.position),
            "quat": _rounded(shape.quat, 6),
            "colour": _rounded(shape_colour(shape), 3),
            "body": shape.body,
        }
        if shape.vertices is not None and shape.faces is not None:
            item |= {"vertices": _rounded(shape.vertices), "faces": shape.faces.tolist()}
        shapes.append(item)
    reference = None
    if scene.reference_positions is not None:
        reference = {
            "positions": encode(scene.reference_positions),
            "quats": encode(scene.reference_quats),
        }
    side_colours = {"r": theme.RIGHT, "l": theme.LEFT}
    counts = [scene.contact_side.count(side) for side in set(scene.contact_side)]
    terrain = any(s.body == 0 and s.kind == "mesh" for s in scene.shapes)
    kinds = {"heel_strike": "heel strike", "toe_off": "toe off"}
    return {
        "time": _rounded(scene.time),
        "bodies": model.nbody,
        "shapes": shapes,
        "positions": encode(scene.positions),
        "quats": encode(scene.quats),
        "reference": reference,
        "com": encode(scene.com),
        "marker_names": list(scene.marker_names)
        or [str(i + 1) for i in range(0 if scene.fitted is None else scene.fitted.shape[1])],
        "recorded": _encoded(scene.recorded),
        "fitted": _encoded(scene.fitted),
        "force": _encoded(scene.force),
        "point": _encoded(scene.point),
        "contact_colours": [side_colours.get(s, theme.MIDDLE) for s in scene.contact_side],
        "many_contacts": max(counts, default=0) > 1,
        "total": _encoded(scene.total_force),
        "cop": _encoded(scene.cop),
        "side_colours": [theme.RIGHT, theme.LEFT, theme.MIDDLE],
        "weight": max(scene.weight, 1e-6),
        "height": standing_height(scene),
        "heading": heading_of(scene),
        "ground": not terrain,
        "colours": _colours(),
        "events": [
            {
                "time": float(event.time),
                "kind": event.kind,
                "colour": side_colours.get(event.side, theme.MIDDLE),
                "title": f"{theme.SIDE_NAMES.get(event.side, '')} "
                f"{kinds.get(event.kind, event.kind)} {event.time:.2f} s",
            }
            for event in record.motion.events
            if scene.time[0] <= event.time <= scene.time[-1]
        ],
        "curves": [
            {
                "title": panel.title,
                "lines": [
                    {
                        "label": line.label,
                        "unit": panel.unit,
                        "colour": line.colour,
                        "values": encode(line.values[scene.frames]),
                    }
                    for line in panel.lines
                ],
            }
            for panel in panels
        ],
    }


def _encoded(array):
    return None if array is None else encode(array)


def _rounded(values, digits: int = 5) -> list:
    return np.round(np.asarray(values, dtype=float), digits).tolist()
