"""The sections of a report, in order; each draws itself if the run has what it needs."""

from plantigrade.pages.sections import (
    clinical,
    contacts,
    cycles,
    estimated,
    figures,
    ground,
    markers,
    measures,
    paths,
    plate,
    recorded,
    tasks,
    vault,
    verdict,
)

SECTIONS = (
    # what the run was made for
    verdict.findings_section,
    verdict.broken_section,
    verdict.check_section,
    recorded.curve_section,
    recorded.rom_section,
    vault.activation_section,
    vault.sensitivity_section,
    tasks.task_section,
    tasks.residual_section,
    recorded.com_section,
    recorded.force_section,
    recorded.moment_section,
    # what every motion has, and what its forces add
    clinical.clinical_section,
    cycles.angle_section,
    measures.measure_section,
    clinical.profile_section,
    cycles.other_angle_section,
    cycles.force_section,
    cycles.moment_section,
    cycles.power_section,
    estimated.estimated_section,
    ground.ground_section,
    markers.marker_section,
    paths.path_section,
    verdict.condition_section,
    # what planned contact, a solver or many markers add
    plate.plate_section,
    contacts.segment_section,
    contacts.pressure_section,
    contacts.contact_section,
    verdict.strength_section,
    verdict.convergence_section,
    cycles.foot_segment_section,
    figures.figure_section,
)

__all__ = ["SECTIONS"]
