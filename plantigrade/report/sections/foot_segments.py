"""Angles between the segments of the foot over the gait cycle."""

from plantigrade.report.section import Section, needs
from plantigrade.report.sections.cycles import CycleCurves, cycle_section
from plantigrade.report.subject import Subject


@needs("foot.percent", "foot.names")
def foot_segment_section(subject: Subject) -> list[Section]:
    """Return the angles of hindfoot, forefoot and hallux."""
    signals = subject.record.signals
    curves = [
        CycleCurves(name, signals["foot.percent"], signals[f"foot.{name}"])
        for name in subject.words("foot.names")
        if f"foot.{name}" in signals
    ]
    if not curves:
        return []
    caption = (
        "Angles between the segments of the foot, from a fit with multi-segment feet: hindfoot to "
        "tibia, forefoot to hindfoot and to tibia, hallux to forefoot, with the signs and the "
        "order of rotations of the Oxford Foot Model (zero: standing pose of the body). The "
        "forefoot includes the tarsal bones, so the arch bends less than in that model."
    )
    rms = subject.number("foot_segments_marker_rms_mm")
    if rms is not None:
        caption += f" Marker error of the feet {rms:.1f} mm RMS."
    return [cycle_section("Foot segments", curves, subject, caption=caption, published=False)]
