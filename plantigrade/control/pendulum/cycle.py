"""A walk to be repeated, from any record that has one."""

from dataclasses import replace

from plantigrade.control.gait.reference import period_of
from plantigrade.kinematics.stride import stride_of
from plantigrade.record import Record


def walk_of(record: Record) -> Record:
    """Return the most even stride of a walk, closed, along x on level ground.

    What repeats itself already (a synthesised walk) or was not recorded on level ground is returned
    as it is. So is what has no stride that nearly closes, with a note: it ends where it ends.

    Args:
        record: The walk: fitted, reproduced or synthesised.

    Raises:
        ParameterError: If the motion has less than four frames, or gaps.
    """
    ground = record.ground
    uneven = ground.slope or ground.steps or ground.seats or ground.uneven
    if uneven or period_of(record)[0] is not None:
        return record
    stride = stride_of(record.human, record.motion)
    if not stride.cyclic:
        note = "No stride of the motion nearly closes; it is walked once, unchanged."
        return replace(record, notes=(*record.notes, note))
    return Record(
        record.human,
        stride.motion(record.human),
        ground=replace(ground, height=0.0),
        notes=record.notes,
    )
