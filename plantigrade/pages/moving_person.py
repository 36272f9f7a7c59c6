"""The moving person at the head of a report: an animated picture as an address of its data.

An image of its own keeps the names and styles of the drawing apart from those of the page.
"""

from urllib.parse import quote

from plantigrade.analyze.pushes import push_intervals
from plantigrade.pages.animation import moving_picture
from plantigrade.pages.playback import playback
from plantigrade.pages.section import Subject

HEIGHT_PX = 330  # [px] of the picture: verdict and tiles fit on the same screen
MAX_RATE = 15.0  # [Hz] key frames per second; a browser interpolates between them
MAX_KEY_FRAMES = 40  # about 150 kB and two seconds of computing for a dressed person
MAX_SHOWN = 3.0  # [s] of a motion that does not repeat
BEFORE_PUSH, BEFORE_FALL, AFTER_FALL = 0.5, 2.0, 0.8  # [s] shown around an event; chosen
MIN_MOTION = 0.1  # [s] below which nothing moves
SAFE = " !$'()*+,-./:;=?@[]^_`{|}~"  # characters that the data of an address may hold


def moving_person(subject: Subject) -> str:
    """Return the address (``data:``) of an animated SVG; empty for less than a moment of motion.

    A steady gait loops over one stride; a pushed or falling person is shown around that event, any
    other motion from its start.

    Raises:
        ParameterError: If the motion cannot be drawn.
    """
    record = subject.record
    if record.motion.n_frames < 2 or record.motion.duration < MIN_MOTION:
        return ""
    start, stop = shown_part(subject)
    shown = MAX_SHOWN if start is None or stop is None else stop - start
    picture = moving_picture(
        record,
        forces=subject.forces,
        foot="none",
        start=start,
        stop=stop,
        rate=min(MAX_RATE, MAX_KEY_FRAMES / shown),
        height_px=HEIGHT_PX,
    )
    svg = picture.svg.replace('"', "'")  # which an attribute in double quotes may hold
    return f"data:image/svg+xml,{quote(svg, safe=SAFE)}"


def shown_part(subject: Subject) -> tuple[float | None, float | None]:
    """Return the first and last instant that are shown [s]; None twice for one stride."""
    time, fell = subject.record.motion.time, subject.number("fell_at_s")
    pushes = push_intervals(subject.record)
    first, last = float(time[0]), float(time[-1])
    if fell is not None:
        return max(first, fell - BEFORE_FALL), min(last, fell + AFTER_FALL)
    if pushes:
        strongest = max(pushes, key=lambda push: push.force)
        start = max(first, strongest.start - BEFORE_PUSH)
        return start, min(last, start + MAX_SHOWN)
    if last - first <= MAX_SHOWN or playback(subject.record).loop is not None:
        return None, None
    return first, first + MAX_SHOWN
