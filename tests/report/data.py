"""What a fit would hand to a report, made from the capsule human's walk."""

import numpy as np

from plantigrade.report.report import Measure, ReportData
from plantigrade.report.sections import CycleCurves, Norm
from tests.report.walker import STRIDE


def report_data(model, record) -> ReportData:
    """Return a report's data with every section filled."""
    time, percent = record.motion.time, np.linspace(0, 100, 101)
    strikes = {
        side: [e.time for e in record.motion.events if (e.side, e.kind) == (side, "heel_strike")]
        for side in "rl"
    }

    def cycles(values, side):
        return np.array(
            [
                np.interp(start + percent / 100 * STRIDE, time, values)
                for start in strikes[side]
                if start + STRIDE <= time[-1]
            ]
        )

    def curves(kind, scale, unit, ending=""):
        found = []
        for base in ("hip_flexion", "hip_adduction", "knee_angle", "ankle_angle", "mtp_angle"):
            for side in "rl":
                joint = model.joint(f"{base}_{side}")
                column = joint.qposadr[0] if kind == "qpos" else joint.dofadr[0]
                source = record.motion.qpos if kind == "qpos" else record.qfrc_actuator
                rng = np.random.default_rng(len(found))
                values = cycles(scale * source[:, column], side)
                noise = rng.normal(0, 0.03 * np.ptp(values), (len(values), 1))
                name = f"{base}_{side}" + ending
                found.append(CycleCurves(name, percent, values + noise, unit))
        return found

    mean = (
        8 + 12 * np.exp(-(((percent - 14) / 7) ** 2)) + 55 * np.exp(-(((percent - 72) / 10) ** 2))
    )
    return ReportData(
        title="Capsule human walking",
        sentence="A made-up walk of a capsule human was written as markers and fitted back.",
        facts={"speed": "1.25 m/s", "cadence": "109 steps/min", "marker error": "10.2 mm"},
        angles=curves("qpos", 180 / np.pi, "°"),
        moments=curves("qfrc", 1 / 73, "N m/kg", "_moment"),
        powers=curves("qfrc", 2 / 73, "W/kg", "_power"),
        norms={"knee_angle": Norm(percent, mean, np.full(101, 5.0), "made up for this test")},
        toe_off={"r": 62.0, "l": 62.0},
        measures=[
            Measure("stride length", "m", 1.375, 1.374, norm="1.44 ± 0.12"),
            Measure("stance", "% of cycle", 62.0, 62.1),
            Measure("speed", "m/s", both=1.25),
        ],
        measures_source="made up for this test",
        provenance={
            "source_files": {"walk.c3d": "sha256 " + "0f" * 32},
            "version": "0.1.0",
            "command": "plantigrade fit walk.c3d",
            "settings": {"height": 1.75, "mass": 73.0, "feet": "multi-segment"},
        },
    )
