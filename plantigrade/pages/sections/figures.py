"""Figures of a run in groups with readable names, except those of other sections."""

from collections.abc import Iterator
from dataclasses import dataclass

from plantigrade.charts.labels import title_of
from plantigrade.constants import SIDES
from plantigrade.pages.section import Group, Section, Subject
from plantigrade.pages.text import rounded_text

LEG = ("hip_flexion", "knee_angle", "ankle_angle")
FOOT = (
    "hindfoot_dorsiflexion", "hindfoot_internal_rotation", "hindfoot_inversion",
    "forefoot_dorsiflexion", "forefoot_adduction", "forefoot_supination",
    "forefoot_to_tibia_dorsiflexion", "forefoot_to_tibia_adduction",
    "forefoot_to_tibia_supination", "hallux_dorsiflexion",
)  # fmt: skip
LENGTHS = (
    "thigh", "shank", "ankle_height", "foot_length", "foot_width", "pelvis_width", "pelvis_depth",
    "pelvis_height", "lumbar_depth", "trunk", "shoulder_width", "upper_arm", "forearm", "hand",
    "head",
)  # fmt: skip


@dataclass(frozen=True)
class Shown:
    """Display of a figure; ``key`` has ``{}`` for the side."""

    label: str
    unit: str
    key: str
    digits: int = 1
    factor: float = 1.0

    @property
    def sided(self) -> bool:
        """Whether the figure exists for both sides."""
        return "{}" in self.key

    def text(self, subject: Subject, side: str = "") -> str:
        """Return the text of the value; a dash if it is unknown."""
        value = subject.number(self.key.format(side))
        return rounded_text(None if value is None else self.factor * value, self.digits)


def _angles(names: tuple[str, ...], unit: str, key: str, digits: int = 1) -> Iterator[Shown]:
    for name in names:
        yield Shown(title_of(name), unit, key.replace("NAME", name), digits)


GROUPS: tuple[tuple[str, tuple[Shown, ...]], ...] = (
    (
        "Recording and fit",
        (
            Shown("frames", "", "frames", 0),
            Shown("duration", "s", "duration_s", 2),
            Shown("markers used", "", "markers_used", 0),
            Shown("marker samples left out", "", "samples_left_out", 0),
            Shown("RMS marker error, mean over frames", "mm", "marker_rms_mean_mm"),
            Shown("RMS marker error, worst frame", "mm", "marker_rms_worst_frame_mm"),
            Shown("RMS marker error, worst marker", "mm", "marker_rms_worst_marker_mm"),
            Shown("maximum error of a single marker", "mm", "marker_error_max_mm"),
            Shown("RMS joint centre error", "mm", "joint_rms_mm"),
            Shown("maximum joint centre error", "mm", "joint_error_max_mm"),
            Shown("walking direction rotated by", "°", "heading_turned_deg", 0),
            Shown("speed of the treadmill's belt", "m/s", "belt_speed_m_s", 2),
            Shown("low-pass cut-off of motion and forces", "Hz", "cutoff_hz", 0),
            Shown("gait events timed by force plates", "", "events_from_plates_count", 0),
            Shown("body mass measured on the force plates", "kg", "mass_on_plates_kg"),
            Shown("stances found", "", "stances", 0),
            Shown("recording lifted by", "mm", "ground_shift_mm"),
            Shown("ground slope removed, over the path", "mm", "ground_slope_mm"),
            Shown("drift of standing feet, mean", "mm", "foot_drift_mean_mm"),
            Shown("drift of standing feet, maximum", "mm", "foot_drift_max_mm"),
            Shown("drift before correction, mean", "mm", "foot_drift_mean_mm_before"),
            Shown("drift before correction, maximum", "mm", "foot_drift_max_mm_before"),
            Shown("soles above ground in stance, mean", "mm", "sole_in_stance_mean_mm"),
            Shown("soles above ground in stance, extreme", "mm", "sole_in_stance_worst_mm"),
            Shown("feet below ground, maximum", "mm", "penetration_max_mm"),
            Shown("feet below ground, uncorrected, maximum", "mm", "penetration_max_mm_before"),
        ),
    ),
    (
        "Posture",
        (
            Shown("forward tilt of the plane of iliac spines", "°", "pelvis_tilt_plane_mean_deg"),
            Shown("inclination of that plane to the horizontal", "°", "pelvis_plane_lean_mean_deg"),
            Shown("hip flexion relative to that plane, mean", "°", "hip_flexion_plane_mean_{}_deg"),
            Shown("lumbar joint behind the hips", "mm", "lumbar_behind_hips_mm", 0),
            Shown("forward lean of the trunk, mean", "°", "trunk_lean_mean_deg"),
            Shown("forward lean of the trunk, standing", "°", "trunk_lean_standing_deg"),
            Shown("forward lean of the trunk, mean, reference", "°",
                  "trunk_lean_mean_followed_deg"),
            Shown("sideways lean of the trunk, RMS", "°", "trunk_sideways_rms_deg"),
            Shown("sideways lean of the trunk, RMS, reference", "°",
                  "trunk_sideways_rms_followed_deg"),
            Shown("forward lean of the head, mean", "°", "neck_lean_mean_deg"),
            Shown("forward lean of the head, mean, reference", "°",
                  "neck_lean_mean_followed_deg"),
            Shown("sideways lean of the head, RMS", "°", "neck_sideways_rms_deg"),
            Shown("sideways lean of the head, RMS, reference", "°",
                  "neck_sideways_rms_followed_deg"),
            Shown("arm joint at its limit, maximum share of frames", "%", "arms_at_stop_pct"),
        ),
    ),
    (
        "Simulation",
        (
            Shown("speed", "m/s", "speed_m_s", 2),
            Shown("speed of the recording", "m/s", "recorded_speed_m_s", 2),
            Shown("target speed at the end", "m/s", "speed_wanted_m_s", 2),
            Shown("speed at the end", "m/s", "speed_at_end_m_s", 2),
            Shown("distance from path, maximum", "m", "astray_max_m", 2),
            Shown("waypoints passed", "", "points_passed", 0),
            Shown("stood for", "s", "stood_s"),
            Shown("steps", "", "landings", 0),
            Shown("steps shortened", "", "landings_shortened", 0),
            Shown("landing error from prediction, median", "m", "landing_error_median_m", 3),
            Shown("clearance from a barrier, minimum", "m", "barrier_clearance_min_m", 3),
            Shown("vertical force, mean", "BW", "vertical_force_mean_bw", 2),
            Shown("vertical force, maximum", "BW", "vertical_force_max_bw", 2),
            Shown("motor torque, maximum share of joint strength", "%", "motor_torque_max_pct", 0),
            Shown("tracking error, RMS", "°", "tracking_error_rms_deg"),
        ),
    ),
    (
        "Segment lengths",
        tuple(
            Shown(name.replace("_", " "), "cm", f"length_{name}_m", 1, 100.0) for name in LENGTHS
        ),
    ),
    (
        "Residual force between motion and plates",
        (
            Shown("frames with all forces known", "", "residual_frames", 0),
            Shown("force, RMS", "N", "residual_force_rms_n"),
            Shown("force, maximum", "N", "residual_force_max_n"),
            Shown("force, RMS, of the peak reaction", "%", "residual_force_rms_share", 1, 100.0),
            Shown("moment, RMS", "N m", "residual_moment_rms_nm"),
            Shown("moment, maximum", "N m", "residual_moment_max_nm"),
            Shown("moment, RMS, of peak reaction times height of the centre of mass", "%",
                  "residual_moment_rms_share", 1, 100.0),
            Shown("centre of mass ahead of that implied by forces", "mm", "com_ahead_mm"),
            Shown("centre of mass to the left of it", "mm", "com_left_mm"),
        ),
    ),
    (
        "Peak joint moments",
        (
            *_angles(LEG, "N m/kg", "NAME_moment_peak_{}_nm_kg", 2),
            *_angles(LEG, "N m/kg", "NAME_moment_max_{}_nm_kg", 2),
        ),
    ),
    ("Range of motion", tuple(_angles(LEG, "°", "NAME_range_{}_deg"))),
    ("Range of motion of the foot", tuple(_angles(FOOT, "°", "NAME_rom_{}_deg"))),
    (
        "Vertical ground reaction in stance",
        (
            Shown("first peak", "BW", "ground_force_peak_1_{}_bw", 2),
            Shown("trough between", "BW", "ground_force_trough_{}_bw", 2),
            Shown("second peak", "BW", "ground_force_peak_2_{}_bw", 2),
        ),
    ),
    (
        "Movement, work and power",
        (
            Shown("distance", "m", "displacement_m", 2),
            Shown("centre of mass, lowest", "m", "com_lowest_m", 3),
            Shown("centre of mass, highest", "m", "com_highest_m", 3),
            Shown("time in flight", "s", "flight_time_s", 2),
            Shown("vertical force, maximum", "BW", "ground_force_max_bw", 2),
            Shown("positive joint work", "J", "joint_work_positive_j", 0),
            Shown("absolute joint work", "J", "joint_work_absolute_j", 0),
            Shown("joint power, maximum", "W", "joint_power_max_w", 0),
            Shown("cost of transport, absolute work", "", "cost_of_transport", 2),
            Shown("cost of transport, positive work", "", "cost_of_transport_positive", 2),
        ),
    ),
    (
        "Difference from the norm's mean curves, right leg",
        (
            *(Shown(f"{title_of(n)}, RMSE", "°", f"norm_rmse_{n}_deg") for n in LEG),
            Shown("mean of the three", "°", "norm_rmse_mean_deg"),
            Shown("mean, offsets removed", "°", "norm_rmse_offset_removed_mean_deg"),
        ),
    ),
    (
        "Compared with the recording",
        (
            Shown("tracked from", "s", "tracked_start_s", 2),
            Shown("tracked to", "s", "tracked_stop_s", 2),
            Shown("joint angles, RMS", "°", "tracking_angle_rms_deg"),
            Shown("pelvis position, RMS", "mm", "tracking_pelvis_rms_mm"),
            Shown("recording lifted by", "mm", "lift_mm"),
            Shown("rotation of a leg, largest RMS error", "°", "rmse_max_deg"),
            Shown("range of motion of a leg, largest error", "°", "rom_error_max_deg"),
            Shown("ankle angle, RMS error", "°", "ankle_angle_rmse_{}_deg"),
            Shown("ankle range of motion, error", "°", "ankle_angle_rom_error_{}_deg"),
            Shown("heel strike to foot flat", "ms", "foot_flat_{}_ms", 0),
            Shown("heel strike to foot flat, recorded", "ms", "foot_flat_reference_{}_ms", 0),
            Shown("reproduced from", "s", "reproduced_from_s", 2),
            Shown("reproduced to", "s", "reproduced_to_s", 2),
            Shown("strides", "", "cycles_count", 0),
            Shown("centre of mass, maximum error", "mm", "com_error_max_mm"),
            Shown("centre of mass, RMS error", "mm", "com_error_rms_mm"),
            Shown("drift of contacts, maximum", "mm", "contact_drift_max_mm"),
            Shown("lowest point of the soles", "mm", "sole_lowest_mm"),
        ),
    ),
    (
        "Swing, reproduced and recorded",
        (
            Shown("minimum toe clearance", "mm", "toe_clearance_{}_mm"),
            Shown("minimum toe clearance, recorded", "mm", "toe_clearance_reference_{}_mm"),
            Shown("maximum knee flexion", "°", "knee_swing_peak_{}_deg"),
            Shown("maximum knee flexion, recorded", "°", "knee_swing_peak_reference_{}_deg"),
        ),
    ),
    (
        "Gait computed with forces",
        (
            Shown("range of motion error, mean", "°", "dynamics_rom_error_mean_deg"),
            Shown("range of motion error, maximum", "°", "dynamics_rom_error_max_deg"),
            Shown("centre of mass, maximum error", "mm", "dynamics_com_error_max_mm"),
            Shown("drift of contacts, maximum", "mm", "dynamics_contact_drift_max_mm"),
            Shown("lowest point of the soles", "mm", "dynamics_sole_lowest_mm"),
        ),
    ),
    (
        "Forces compared with measured ones, in stance",
        (
            *(
                figure
                for axis in ("vertical", "forward", "sideways")
                for figure in (
                    Shown(f"{axis} force, RMSE", "BW", f"{axis}_force_rmse_bw", 3),
                    Shown(f"{axis} force, correlation", "", f"{axis}_force_correlation", 3),
                )
            ),
            Shown("centre of pressure, forward, median error", "mm", "pressure_x_error_median_mm"),
            Shown("centre of pressure, sideways, median error", "mm", "pressure_y_error_median_mm"),
            Shown("centre of pressure, backward in a stance", "mm", "pressure_backward_mm"),
            *(
                figure
                for n in LEG
                for figure in (
                    Shown(f"{title_of(n)} moment, RMSE", "N m/kg", f"{n}_moment_rmse_nm_kg", 2),
                    Shown(f"{title_of(n)} moment, correlation", "", f"{n}_moment_correlation", 3),
                )
            ),
        ),
    ),
    (
        "Size of the optimisation",
        (
            Shown("nodes", "", "nodes", 0),
            Shown("unknowns", "", "unknowns", 0),
            Shown("equations", "", "equations", 0),
            Shown("inequalities", "", "inequalities", 0),
            Shown("iterations", "", "iterations", 0),
            Shown("starts", "", "restarts", 0),
        ),
    ),
)  # fmt: skip


def figure_section(subject: Subject) -> list[Section]:
    """Return the known figures of the run in groups."""
    groups = [group for title, shown in GROUPS for group in _group(subject, title, shown)]
    return [Section("Other figures", groups=groups, folded=True)] if groups else []


def _group(subject: Subject, title: str, shown: tuple[Shown, ...]) -> list[Group]:
    sides = SIDES if shown[0].sided else ("",)
    known = [one for one in shown if any(one.text(subject, side) != "–" for side in sides)]
    if not shown[0].sided:
        rows = [[f.label, f"{f.text(subject)} {f.unit}".strip()] for f in known]
        return [Group(title, (), rows)] if rows else []
    rows = [[f.label, *(f.text(subject, side) for side in sides), f.unit] for f in known]
    headers = ("", "right", "left", "unit")
    return [Group(title, headers, rows)] if rows else []
