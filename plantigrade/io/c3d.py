"""C3D recordings: markers, force plates, events, subject and model outputs.

The container is read in :mod:`~plantigrade.io.c3d_file`, force plates in
:mod:`~plantigrade.io.force_plates`, and which points are markers is decided in
:mod:`~plantigrade.io.c3d_labels`. Time is ``(frame number - 1) / rate``: the clock of the events,
also in a recording cut from a longer one.
"""

import re
from pathlib import Path

import numpy as np

from plantigrade.errors import FileError
from plantigrade.io.axes import MIN_CERTAINTY, rotation_to_world, to_world, up_axis_of_points
from plantigrade.io.c3d_file import C3dFile, read_c3d_file
from plantigrade.io.c3d_labels import LabelledPoints, sort_points
from plantigrade.io.force_plates import plate_axes, plate_corners, plates_from_c3d
from plantigrade.motion.recording import GaitEvent, Markers, Recording, Subject

LENGTH_UNITS = {
    **dict.fromkeys(("mm", "millimeter", "millimeters", "millimetre", "millimetres"), 1e-3),
    **dict.fromkeys(("cm", "centimeter", "centimeters", "centimetre", "centimetres"), 1e-2),
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), 1.0),
    **dict.fromkeys(("in", "inch", "inches"), 0.0254),
    **dict.fromkeys(("ft", "feet", "foot"), 0.3048),
    "dm": 0.1,
}
"""Length units by name [m]."""

NAMES_OF_UNITS = {1e-3: "mm", 1e-2: "cm", 1.0: "m"}

_STRIKE = re.compile(
    r"(foot|heel|initial|toe)?[ _-]*(strike|contact|on|down)|[lr]?(hs|fs|ic|fc)", re.I
)
_OFF = re.compile(r"(foot|toe)[ _-]*off|[lr]?(to|fo)", re.I)


def read_c3d(path: str | Path) -> Recording:
    """Read a C3D file.

    Returns:
        Markers in world axes [m]. ``outputs`` holds the results of a model: positions (joint
        centres, segment axes, centre of mass) in world axes [m], as the markers; angles, forces,
        moments, powers and scalars in the file's own axes and units; and stray trajectories
        under names that start with ``*``, world axes [m].
    """
    file = read_c3d_file(path)
    points = sort_points(file)
    warnings = list(points.warnings)
    seen = file.points[:, list(points.markers)]
    unit = _length_unit(file, seen, warnings)
    up = _up(file, seen, unit, warnings)
    time = (file.first_frame - 1 + np.arange(len(file.points))) / file.rate
    outputs = {points.names[i]: file.points[:, i].copy() for i in points.typed}
    for i in points.computed + points.unlabelled:
        outputs[points.names[i]] = to_world(file.points[:, i] * unit, up)
    markers = None
    if points.markers:
        names = tuple(points.names[i] for i in points.markers)
        markers = Markers(names, time, to_world(seen * unit, up))
        if not np.isfinite(seen).any():
            warnings.append("no marker is visible in any frame")
    plates, plate_warnings = plates_from_c3d(file, unit, rotation_to_world(up))
    if not points.names and not plates:
        raise FileError(
            path,
            "contains neither points nor force plates",
            remedy="include the trajectories when exporting",
        )
    events = _events(file, float(time[0]), float(time[-1]), warnings)
    return Recording(
        source=Path(path),
        markers=markers,
        plates=tuple(plates),
        events=events,
        subject=_subject(file, warnings),
        outputs=outputs,
        warnings=tuple(warnings + plate_warnings + _people(points)),
    )


def _length_unit(file: C3dFile, points: np.ndarray, warnings: list[str]) -> float:
    """Return the unit of the points [m]."""
    words = file.strings("POINT", "UNITS")
    word = words[0].lower().strip(". ") if words else ""
    if word in LENGTH_UNITS:
        return LENGTH_UNITS[word]
    unit = unit_of_points(points)
    if np.isfinite(points).any():
        warnings.append(
            f"the file states the length unit {word!r}; from the size of the body it was taken as "
            f"{NAMES_OF_UNITS[unit]}"
        )
    return unit


def unit_of_points(points: np.ndarray) -> float:
    """Return the unit [m] that makes markers (n_frames, n_markers, 3) human-sized."""
    with np.errstate(all="ignore"):
        part = points[:: max(1, len(points) // 200)]
        part = part[np.isfinite(part).all(axis=2).sum(axis=1) >= 2]
        if len(part) == 0:
            return 1e-3
        extent = np.nanmax(part, axis=1) - np.nanmin(part, axis=1)
        size = float(np.median(np.linalg.norm(extent, axis=1)))
    return 1e-3 if size > 300 else 1e-2 if size > 10 else 1.0  # a body is 0.3 to 3 m long


def _up(file: C3dFile, points: np.ndarray, unit: float, warnings: list[str]) -> str:
    """Return the file's vertical: as declared, unless plates or an upright body contradict it."""
    words = file.strings("POINT", "Y_SCREEN")
    match = re.fullmatch(r"\s*([+-]?)\s*([xyz])\s*", words[0], re.I) if words else None
    declared = (match[1] or "+") + match[2].lower() if match else None
    plates = _up_of_plates(file, points)
    body, sure = up_axis_of_points(points * unit)
    seen = plates or (body if sure > MIN_CERTAINTY else None)
    if declared is None:
        return seen or "+z"
    # The screen axes describe the display and plates the floor; the body is less reliable, because
    # a person may lie down.
    if plates and plates != declared:
        warnings.append(
            f"POINT:Y_SCREEN says that {declared} is up, the force plates that {plates} is; the "
            "plates were believed"
        )
        return plates
    if not plates and sure > 1.8 and body != declared:
        warnings.append(
            f"POINT:Y_SCREEN says that {declared} is up, but the body is longest along {body}, "
            "which was taken as up"
        )
        return body
    return declared


def _up_of_plates(file: C3dFile, points: np.ndarray) -> str | None:
    """Return the axis along the plates' normal that points to the side of the markers."""
    used = file.value("FORCE_PLATFORM", "USED")
    if not used >= 1 or not np.isfinite(points).any():
        return None
    axes = set()
    for four in plate_corners(file)[: int(min(used, 64))]:
        normal = plate_axes(four)[:, 2]
        if not np.isfinite(normal).all() or np.abs(normal).max() < 0.9:
            continue  # no plate, or a ramp
        axis = int(np.argmax(np.abs(normal)))
        height = np.nanmedian(points[..., axis])
        axes.add(("+" if height >= four[:, axis].mean() else "-") + "xyz"[axis])
    return axes.pop() if len(axes) == 1 else None


def _events(file: C3dFile, start: float, end: float, warnings: list) -> tuple[GaitEvent, ...]:
    times = file.continued("EVENT", "TIMES")
    labels, contexts = file.strings("EVENT", "LABELS"), file.strings("EVENT", "CONTEXTS")
    rows: list[tuple[float, str, str]] = []
    if times.ndim == 2 and times.shape[0] == 2 and times.shape[1]:
        seconds = 60.0 * times[0] + times[1]
        used = file.value("EVENT", "USED")
        n = min(len(seconds), len(labels), int(used) if 0 <= used < 1e6 else len(seconds))
        contexts = contexts + [""] * n
        rows = [(float(seconds[i]), labels[i], contexts[i]) for i in range(n)]
    elif file.header_events:
        rows = [(time, label, "") for label, time in file.header_events]
    events = []
    for time, label, context in rows:
        kind = event_kind(label)
        side = event_side(label, context)
        if kind and side and np.isfinite(time):
            events.append(GaitEvent(time, side, kind))
    half = 0.5 / file.rate
    inside = [start - half <= event.time <= end + half for event in events]
    if events and not any(inside):
        moved = [GaitEvent(e.time + start, e.side, e.kind) for e in events]
        if all(start - half <= event.time <= end + half for event in moved):
            warnings.append("event times count from the first frame of the file; they were shifted")
            return tuple(sorted(moved, key=lambda event: event.time))
    outside = len(events) - sum(inside)
    if outside:
        warnings.append(f"{outside} events lie outside the recorded frames and were left out")
    kept = [event for event, good in zip(events, inside, strict=True) if good]
    return tuple(sorted(kept, key=lambda event: event.time))


def event_kind(label: str) -> str | None:
    """Return ``"heel_strike"`` or ``"toe_off"`` for the names in use, else None."""
    bare = re.sub(
        r"^(left|right|[lr])[ _-]+|[ _-]+(left|right|[lr])$", "", label.strip(), flags=re.I
    )
    if _STRIKE.fullmatch(bare):
        return "heel_strike"
    return "toe_off" if _OFF.fullmatch(bare) else None


def event_side(label: str, context: str) -> str | None:
    """Return ``"l"`` or ``"r"`` from the context of an event, else from its label."""
    for word in (context, label):
        match = re.match(
            r"\s*(left|right|l(?=[ _-]|$|hs|fs|ic|fc|to|fo)|r(?=[ _-]|$|hs|fs|ic|fc|to|fo))",
            word,
            re.I,
        )
        match = match or re.search(r"[ _-](left|right|l|r)\s*$", word, re.I)
        if match:
            return match[1][0].lower()
    return None


_MASS_NAMES = ("bodymass", "mass", "weight", "bodyweight", "subjectmass", "subjectweight")
_HEIGHT_NAMES = ("height", "bodyheight", "stature", "subjectheight")
_LEG_NAMES = ("leglength", "lleglength", "rleglength", "leftleglength", "rightleglength")
_PERSON_NAMES = ("names", "name", "subjectname", "patientname", "label", "labels")
_DATE_NAMES = ("date", "recordingdate", "trialdate", "measurementdate", "sessiondate")
_SEXES = {
    **dict.fromkeys(("m", "male", "man"), "male"),
    **dict.fromkeys(("f", "female", "w", "woman"), "female"),
}


def _subject(file: C3dFile, warnings: list[str]) -> Subject:
    found: dict[str, float] = {}
    sex = ""
    for group in ("PROCESSING", "SUBJECTS", "SUBJECT", "ANTHROPOMETRY", "PATIENT"):
        for name, value in file.groups.get(group, {}).items():
            key = re.sub(r"[^a-z]", "", name.lower())
            if isinstance(value, list):
                if key in ("sex", "gender") and value:
                    sex = sex or value[0].strip().lower()
                try:
                    number = float(value[0].split()[0]) if value else float("nan")
                except (ValueError, IndexError):
                    continue
            else:
                number = float(value.flat[0]) if value.size else float("nan")
            if np.isfinite(number) and number != 0:
                found.setdefault(key, number)

    def plausible(names, low, high, units, what):
        """Return the values of these names in the first unit that makes them plausible."""
        values = []
        for given in (found[name] for name in names if name in found):
            fitting = [given * unit for unit in units if low <= given * unit <= high]
            values += fitting[:1]
            if not fitting:
                warnings.append(f"{what}; given as {given:g}; ignored")
        return values

    lengths = (1.0, 1e-3, 1e-2)
    mass = plausible(_MASS_NAMES, 2, 400, (1.0,), "body mass must be 2 to 400 kg")
    height = plausible(
        _HEIGHT_NAMES, 0.3, 2.6, lengths, "body height must be 0.3 to 2.6 m, in m, cm or mm"
    )
    age = plausible(("age", "ageyears"), 1, 120, (1.0,), "age must be 1 to 120 years")
    leg = plausible(_LEG_NAMES, 0.1, 1.5, lengths, "leg length must be 0.1 to 1.5 m")
    people = _words(file, ("SUBJECTS", "SUBJECT", "PATIENT"), _PERSON_NAMES)
    dates = _words(file, ("TRIAL", "SUBJECTS", "SUBJECT", "PATIENT", "PROCESSING"), _DATE_NAMES)
    return Subject(
        height=height[0] if height else None,
        mass=mass[0] if mass else None,
        sex=_SEXES.get(sex),
        leg_length=float(np.mean(leg)) if leg else None,
        age=age[0] if age else None,
        name=people[0] if len(people) == 1 else None,
        date=dates[0] if dates else None,
    )


def _words(file: C3dFile, groups: tuple[str, ...], names: tuple[str, ...]) -> list[str]:
    """Return the different values of parameters with these names, in any spelling."""
    found: dict[str, None] = {}
    for group in groups:
        for name, value in file.groups.get(group, {}).items():
            if re.sub(r"[^a-z]", "", name.lower()) in names and isinstance(value, list):
                found |= dict.fromkeys(w for word in value if (w := word.strip()[:80]))
    return list(found)


def _people(points: LabelledPoints) -> list[str]:
    markers = (points.names[i] for i in points.markers)
    people = sorted({name.split(":")[0] for name in markers if ":" in name})
    if len(people) < 2:
        return []
    names = ", ".join(people)
    return [f"the file holds markers of {len(people)} subjects ({names}), kept by prefix"]
