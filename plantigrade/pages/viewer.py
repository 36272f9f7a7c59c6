"""``viewer.html``: one self-contained page with the moving body, its forces and its curves.

The page draws with its own few hundred lines of WebGL 2, which the page of a running simulation
(:mod:`plantigrade.pages.live_world`) shares.
"""

import base64
import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from plantigrade.charts import Panel, panels_of, theme
from plantigrade.charts.labels import MIN_SPANS
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.contact.ground import Ground
from plantigrade.motion.views import curves_of
from plantigrade.pages.scene import (
    VIEW_RATE,
    Scene,
    assumed_bodies,
    build_scene,
    heading_of,
    side_forces,
    standing_height,
)
from plantigrade.pages.section import rendered, template_text
from plantigrade.pages.shapes import Shape
from plantigrade.pages.viewer_skin import foot_data, skin_data
from plantigrade.record import Record

PARTS = ("base", "shapes", "gl", "skin", "foot", "controls")  # of both viewers
SHARED_SCRIPTS = tuple(f"viewer_{part}.js" for part in PARTS)
SCRIPTS = (*SHARED_SCRIPTS, "viewer_data.js", "viewer_curves.js", "viewer.js")
COLOURS = {
    "recorded": theme.RECORDED,
    "fitted": theme.FITTED,
    "reference": theme.REFERENCE,
    "left": theme.LEFT,
    "right": theme.RIGHT,
    "com": theme.COM,
    "contact": theme.FORCE,
    "floor": theme.FLOOR,
    "grid": theme.GRID,
    "floor_dark": theme.FLOOR_DARK,
    "grid_dark": theme.GRID_DARK,
    "pushed": theme.PUSHED,
    "thing": theme.SCENE_OBJECT,
}


def viewer_html(
    record: Record,
    *,
    title: str,
    subtitle: str = "",
    coordinates: tuple[str, ...] = (),
    forces: Record | None = None,
) -> str:
    """Return the viewer page of a record.

    Args:
        coordinates: Coordinates whose curves are shown; all hinges if empty.
        forces: Record whose forces are drawn if ``record`` has none.

    Raises:
        ParameterError: If the record cannot be drawn.
    """
    scene = build_scene(record, forces=forces)
    has_cop = scene.cop is not None and bool(np.isfinite(scene.cop).any())
    has = {
        "reference": scene.reference_positions is not None,
        "recorded": scene.recorded is not None,
        "fitted": scene.fitted is not None,
        "force": has_cop and bool(np.any(scene.total_force)),
        "cop": has_cop,
        "estimated": has_cop and scene.estimated is not None,
        "plate": scene.plate,
        "pushes": bool(scene.pushes),
        "skin": (skin := skin_data(record.human, assumed_bodies(record))) is not None,
        "foot": (foot := foot_data(record.human)) is not None,
    }
    return stage_html(
        "viewer.html",
        motion_data(record, scene, coordinates, forces) | {"skin": skin, "foot": foot},
        styles=("viewer.css",),
        scripts=SCRIPTS,
        title=title,
        subtitle=subtitle,
        has=has,
        weight=round(scene.weight),
        thinned=_thinned(record, scene),
        reference_label=scene.reference_name.capitalize(),
    )


def motion_data(
    record: Record, scene: Scene, coordinates: tuple[str, ...] = (), forces: Record | None = None
) -> dict[str, Any]:
    """Return the data of the page that change with the motion; see :func:`viewer_html`."""
    panels = panels_of(curves_of(record.motion, coordinates or record.motion.joint_names[1:]))
    curves = [_curve(panel, record.motion.time, scene.time) for panel in panels]
    shown = record if forces is None else forces
    curves += [_curve(p, shown.motion.time, scene.time) for p in force_panels(shown)]
    return page_data(record, scene) | {"curves": curves}


def stage_html(
    template: str,
    data: Mapping[str, Any],
    *,
    styles: Sequence[str],
    scripts: Sequence[str],
    **variables: Any,
) -> str:
    """Return a page with a body in three dimensions.

    Args:
        template: Template that extends ``stage.html``.
        styles: Style sheets among the packaged templates.
        scripts: Scripts among the packaged templates.
        variables: Other variables of the template.
    """
    from markupsafe import Markup

    text = json.dumps(data, separators=(",", ":"))
    return rendered(
        template,
        css=Markup("".join(template_text(name) for name in styles)),
        js=Markup("".join(template_text(name) for name in scripts)),
        scene=Markup(text.replace("<", "\\u003c")),
        colours=COLOURS,
        **variables,
    )


def _thinned(record: Record, scene: Scene) -> str:
    """Return the frame rate of a motion, reduced if it is too long; empty if it is not."""
    if len(scene.time) < 2 or scene.stride <= max(1.0, round(record.motion.rate / VIEW_RATE)):
        return ""
    return f"{record.motion.rate / scene.stride:.3g}"


def force_panels(record: Record) -> tuple[Panel, ...]:
    """Return ground reaction over time in body weights, vertical and forward."""
    total, _ = side_forces(record, pushes=False)
    if total is None or not np.any(total):
        return ()
    loaded = [(row, side) for row, side in enumerate((*SIDES, "")) if np.any(total[:, row])]
    return tuple(
        Panel(name, "BW", {side: total[:, row, axis] / record.weight for row, side in loaded})
        for axis, name in ((2, "ground_force_up"), (0, "ground_force_forward"))
    )


def _curve(panel: Panel, clock: np.ndarray, time: np.ndarray) -> dict[str, Any]:
    """Return a panel on the drawn frames, in the format of the page."""
    lines = [
        {
            "label": SIDE_NAMES.get(side, ""),
            "unit": panel.unit if panel.unit == "°" else f" {panel.unit}",
            "colour": theme.SIDE_COLOURS.get(side, theme.MIDDLE),
            "values": encode(np.interp(time, clock, values)),
        }
        for side, values in panel.curves.items()
    ]
    return {"title": panel.title, "span": MIN_SPANS.get(panel.unit, 0.0), "lines": lines}


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


def shape_data(shape: Shape) -> dict[str, Any]:
    """Return a shape for the scripts of the page."""
    item: dict[str, Any] = {
        "kind": shape.kind,
        "size": _rounded(shape.size),
        "position": _rounded(shape.position),
        "quat": _rounded(shape.quat, 6),
        "colour": _rounded(shape.paint, 3),
        "body": shape.body,
    }
    if shape.is_ground:
        item["ground"] = shape.shade
    if shape.is_plate or shape.is_scene_object:
        item["thing"] = True
    if shape.vertices is not None and shape.faces is not None:
        item |= {"vertices": _rounded(shape.vertices), "faces": shape.faces.tolist()}
    return item


def ground_data(ground: Ground, *, plane: bool) -> dict[str, Any]:
    """Return the ground for the scripts of the page: a plane without end, or its shapes alone."""
    return {
        "axes": _rounded(ground.to_world.T.ravel(), 9),
        "plane": plane,
        "height": ground.height,
        "origin": [0.0, 0.0, 0.0],
    }


def page_data(record: Record, scene: Scene) -> dict[str, Any]:
    """Return the data of the page: shapes, positions, colours."""
    reference = None
    if scene.reference_positions is not None:
        positions = encode(scene.reference_positions)
        reference = {"positions": positions, "quats": _encoded(scene.reference_quats)}
    counts = [scene.site_sides.count(side) for side in set(scene.site_sides)]
    ground, events = scene.ground, record.motion.events
    kinds = {"heel_strike": "heel strike", "toe_off": "toe off"}
    return {
        "time": _rounded(scene.time),
        "stride": scene.stride,
        "bodies": scene.positions.shape[1],
        "shapes": [shape_data(shape) for shape in scene.shapes],
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
        "contact_colours": [theme.SIDE_COLOURS.get(s, theme.MIDDLE) for s in scene.site_sides],
        "pushes": list(scene.pushes),
        "many_contacts": max(counts, default=0) > 1,
        "total": _encoded(scene.total_force),
        "cop": _encoded(scene.cop),
        "estimated": None if scene.estimated is None else encode(scene.estimated),
        "side_colours": theme.BY_SIDE,
        "weight": max(scene.weight, 1e-6),
        "height": standing_height(scene),
        "heading": heading_of(scene),
        "ground": ground_data(ground, plane=not (ground.steps or scene.plate)),
        "floor": encode(scene.floor) if np.any(scene.floor) else None,
        "level": encode(scene.level) if np.any(scene.floor) else None,
        "cycles": {
            SIDE_NAMES[side]: _rounded(
                sorted(e.time for e in events if (e.side, e.kind) == (side, "heel_strike"))
            )
            for side in SIDES
        },
        "colours": COLOURS,
        "events": [
            {
                "time": float(event.time),
                "kind": event.kind,
                "colour": theme.SIDE_COLOURS.get(event.side, theme.MIDDLE),
                "title": f"{SIDE_NAMES.get(event.side, '')} "
                f"{kinds.get(event.kind, event.kind)} {event.time:.2f} s",
            }
            for event in events
            if scene.time[0] <= event.time <= scene.time[-1]
        ],
    }


def _encoded(array):
    return None if array is None else encode(array)


def _rounded(values, digits: int = 5) -> list:
    return np.round(np.asarray(values, dtype=float), digits).tolist()
