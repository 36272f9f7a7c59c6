"""Recordings of a person's mirror image, turned back into the person.

Two faults make one: left and right are exchanged in the names of the markers, or an axis of the
file points the other way (a left-handed laboratory). The markers alone do not
show which: it is an option.
"""

from dataclasses import replace

from plantigrade.errors import FitError
from plantigrade.models.markers import MarkerSet, names_of_other_sides
from plantigrade.models.parts import MIRROR
from plantigrade.motion import Recording
from plantigrade.side_names import opposite


def swap_sides(recording: Recording, marker_set: MarkerSet | None = None) -> Recording:
    """Return the recording with left and right exchanged in its names, its standing trial too.

    Markers and gait events change their side; plates lose theirs, which the feet then determine.
    Model outputs of the file are left out, as they were computed for the wrong side.

    Args:
        marker_set: The user's own marker set, whose names may be spelled without a side.
    """
    markers = recording.markers
    if markers is None:
        raise FitError(f"--swap-sides exchanges names of markers; {recording.source} has none")
    names = names_of_other_sides(markers.names, marker_set)
    if names == markers.names:
        raise FitError(f"{recording.source}: no marker name indicates a side")
    return replace(
        recording,
        markers=replace(markers, names=names),
        events=tuple(replace(e, side=opposite(e.side)) for e in recording.events),
        plates=tuple(replace(plate, side=None) for plate in recording.plates),
        outputs={},
        static=None if recording.static is None else swap_sides(recording.static, marker_set),
    )


def mirror_axis(recording: Recording) -> Recording:
    """Return the recording with its axis to the left turned round, its standing trial too.

    Which horizontal axis is turned does not matter: the one or the other is a half turn away.
    """
    markers = recording.markers
    if markers is None:
        raise FitError(f"--mirror-axis reverses an axis of markers; {recording.source} has none")
    return replace(
        recording,
        markers=replace(markers, positions=markers.positions * MIRROR),
        plates=tuple(
            replace(
                plate,
                force=plate.force * MIRROR,
                cop=plate.cop * MIRROR,
                free_moment=-plate.free_moment,
                corners=None if plate.corners is None else plate.corners * MIRROR,
            )
            for plate in recording.plates
        ),
        outputs={},
        static=None if recording.static is None else mirror_axis(recording.static),
    )


def mirrored(source: object) -> str:
    """Return what is wrong with a recording whose person is the mirror image of one."""
    return (
        f"{source}: the person is mirrored: the names of left and right markers are exchanged "
        "(--swap-sides exchanges them back), or one axis of the file points the other way "
        "(--mirror-axis turns it)"
    )
