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
from plantigrade.io.axes import rotation_to_world, to_world, up_axis_of_points
from plantigrade.io.c3d_file import C3dFile, read_c3d_file
from plantigrade.io.c3d_labels import LabelledPoints, sort_points
from plantigrade.io.force_plates import plate_axes, plate_corners, plates_from_c3d
from plantigrade.io.text import not_written
from plantigrade.motion.recording import ForcePlate, GaitEvent, Markers, Recording, Subject

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

    Raises:
        FileError: If the file cannot be read.
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


def write_c3d(recording: Recording, path: str | Path) -> None:
    """Write markers, force plates (type 2) and events; world axes z up, points in mm.

    Plates are resampled to the smallest multiple of the marker rate that is not below their own. A
    plate with unknown corners is written as 0.5 m by 0.5 m, centred on its mean centre of pressure.

    Raises:
        FileError: If there are no markers, they are not evenly sampled, or the file cannot be
            written.
    """
    import ezc3d

    markers = recording.markers
    if markers is None or markers.n_frames == 0:
        raise FileError(
            path,
            "the recording has no markers, which a C3D file needs",
            remedy="write joint angles to .mot or .npz, another skeleton to .bvh",
        )
    rate = _even_rate(markers.time, path)
    first_frame = int(round(markers.time[0] * rate)) + 1
    first_frame = max(first_frame, 1)
    if first_frame + markers.n_frames - 1 > 65535:
        raise FileError(
            path,
            f"frame {first_frame + markers.n_frames - 1} exceeds 65535, the last of a C3D header",
            remedy="shorten the recording, or write .trc or .csv",
        )
    shift = (first_frame - 1) / rate - markers.time[0]
    out = ezc3d.c3d()
    n = markers.n_frames
    data = np.full((4, len(markers.names), n), np.nan)
    data[:3] = markers.positions.transpose(2, 1, 0) * 1e3
    data[3] = 1.0
    out["data"]["points"] = data
    seen = np.isfinite(data[:3]).all(axis=0)
    out["data"]["meta_points"] = {
        "residuals": np.where(seen, 0.0, -1.0)[None],
        "camera_masks": np.zeros((7, len(markers.names), n), dtype=bool),
    }
    out["header"]["points"]["first_frame"] = first_frame - 1
    point = out["parameters"]["POINT"]
    point["RATE"]["value"] = np.array([rate])
    point["LABELS"]["value"] = list(markers.names)
    point["UNITS"]["value"] = ["mm"]
    out.add_parameter("POINT", "X_SCREEN", ["+X"])
    out.add_parameter("POINT", "Y_SCREEN", ["+Z"])
    per_frame = _samples_per_frame(recording.plates, rate)
    if recording.plates:  # without analog samples, ezc3d wants their rate left at zero
        out["parameters"]["ANALOG"]["RATE"]["value"] = np.array([rate * per_frame])
        _add_plates(out, recording.plates, markers.time[0], rate, per_frame, n)
    if recording.events:
        _add_events(out, recording.events, shift)
    _add_subject(out, recording.subject)
    try:
        with open(path, "wb"):  # ezc3d says too little where it cannot write
            pass
        out.write(str(path))
    except OSError as error:
        raise not_written(path, error) from error
    except RuntimeError as error:
        raise FileError(path, f"cannot be written as C3D ({error})") from error


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
    seen = plates or (body if sure > 1.4 else None)
    if declared is None:
        return seen or "+z"
    # The screen says how the laboratory is drawn, and plates where the floor is. A body says it
    # less surely: someone may lie down.
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
    times = file.values("EVENT", "TIMES")
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
    return Subject(
        height=height[0] if height else None,
        mass=mass[0] if mass else None,
        sex=_SEXES.get(sex),
        leg_length=float(np.mean(leg)) if leg else None,
        age=age[0] if age else None,
    )


def _people(points: LabelledPoints) -> list[str]:
    markers = (points.names[i] for i in points.markers)
    people = sorted({name.split(":")[0] for name in markers if ":" in name})
    if len(people) < 2:
        return []
    names = ", ".join(people)
    return [f"the file holds markers of {len(people)} subjects ({names}), kept by prefix"]


def _even_rate(time: np.ndarray, path: str | Path) -> float:
    if len(time) == 1:
        return 100.0
    steps = np.diff(time)
    step = float(np.median(steps))
    if not step > 0 or np.abs(steps - step).max() > 0.05 * step:
        raise FileError(
            path,
            "the markers are not evenly sampled in time, which C3D cannot store",
            remedy="resample them first, or write .trc or .csv",
        )
    rate = (len(time) - 1) / float(time[-1] - time[0])
    return float(round(rate)) if abs(rate - round(rate)) < 1e-3 * rate else rate


def _samples_per_frame(plates: tuple[ForcePlate, ...], rate: float) -> int:
    rates = [(len(p.time) - 1) / (p.time[-1] - p.time[0]) for p in plates if len(p.time) > 1]
    return max(1, int(np.ceil(max(rates, default=rate) / rate - 1e-3)))


def _add_plates(out, plates, start: float, rate: float, per_frame: int, n_frames: int) -> None:
    clock = start + np.arange(n_frames * per_frame) / (rate * per_frame)
    channels, corners, origins = [], [], []
    for plate in plates:
        force, cop, free = _on_clock(plate, clock)
        four = plate.corners if plate.corners is not None else _invented_corners(plate)
        axes = plate_axes(four)
        if axes[2, 2] > 0:  # listed the other way round: keep z into the ground
            four = four[[1, 0, 3, 2]]
            axes = plate_axes(four)
        centre = four.mean(axis=0)
        arm = np.where(np.isfinite(cop), cop - centre, 0.0)
        moment = np.cross(arm, force)
        moment[:, 2] += free
        channels += [-force @ axes, -1e3 * moment @ axes]  # on the plate; N and N mm
        corners.append(four.T * 1e3)
        origins.append(np.zeros(3))
    samples = np.concatenate(channels, axis=1)
    n = len(plates)
    out["data"]["analogs"] = samples.T[None]
    analog = out["parameters"]["ANALOG"]
    analog["LABELS"]["value"] = [
        f"{axis}{i + 1}" for i in range(n) for axis in ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
    ]
    analog["UNITS"]["value"] = ["N", "N", "N", "Nmm", "Nmm", "Nmm"] * n
    analog["SCALE"]["value"] = np.ones(6 * n)
    analog["OFFSET"]["value"] = np.zeros(6 * n, dtype=int)
    group = out["parameters"]["FORCE_PLATFORM"]
    group["USED"]["value"] = np.array([n])
    group["TYPE"]["value"] = np.full(n, 2)
    group["ZERO"]["value"] = np.array([1, 0])
    group["CORNERS"]["value"] = np.stack(corners, axis=2)
    group["ORIGIN"]["value"] = np.stack(origins, axis=1)
    group["CHANNEL"]["value"] = np.arange(1, 6 * n + 1).reshape(n, 6).T


def _on_clock(plate: ForcePlate, clock: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return force, centre of pressure and free moment at the times ``clock``; 0 outside."""
    if len(plate.time) == len(clock) and np.abs(plate.time - clock).max() < 1e-6:
        return plate.force, plate.cop, np.nan_to_num(plate.free_moment)

    def at(values, outside):
        return np.interp(clock, plate.time, values, left=outside, right=outside)

    force = np.stack([at(np.nan_to_num(plate.force[:, k]), 0.0) for k in range(3)], axis=1)
    seen = at(np.isfinite(plate.cop).all(axis=1).astype(float), 0.0) > 0.999
    cop = np.stack([at(np.nan_to_num(plate.cop[:, k]), np.nan) for k in range(3)], axis=1)
    cop[~seen] = np.nan
    return force, cop, at(np.nan_to_num(plate.free_moment), 0.0)


def _invented_corners(plate: ForcePlate) -> np.ndarray:
    seen = plate.cop[np.isfinite(plate.cop).all(axis=1)]
    centre = seen.mean(axis=0) if len(seen) else np.zeros(3)
    # By quadrant of axes x, -y, into the ground: clockwise seen from above.
    return centre + 0.25 * np.array([[1, -1, 0], [-1, -1, 0], [-1, 1, 0], [1, 1, 0]], dtype=float)


def _add_events(out, events: tuple[GaitEvent, ...], shift: float) -> None:
    times = np.array([[(e.time + shift) // 60, (e.time + shift) % 60] for e in events]).T
    names = {"heel_strike": "Foot Strike", "toe_off": "Foot Off"}
    out.add_parameter("EVENT", "USED", [len(events)])
    out.add_parameter("EVENT", "CONTEXTS", [{"l": "Left", "r": "Right"}[e.side] for e in events])
    out.add_parameter("EVENT", "LABELS", [names[e.kind] for e in events])
    out.add_parameter("EVENT", "TIMES", times)


def _add_subject(out, subject: Subject) -> None:
    if subject.mass is not None:
        out.add_parameter("PROCESSING", "Bodymass", [float(subject.mass)])
    if subject.height is not None:
        out.add_parameter("PROCESSING", "Height", [1e3 * subject.height])
    if subject.leg_length is not None:
        for side in "LR":
            out.add_parameter("PROCESSING", f"{side}LegLength", [1e3 * subject.leg_length])
    if subject.sex is not None:
        out.add_parameter("SUBJECTS", "SEX", [subject.sex])
    if subject.age is not None:
        out.add_parameter("SUBJECTS", "AGE", [float(subject.age)])
