"""Joint angles, moments, gait measures, norms, statistics. Names are loaded on first use."""

from typing import TYPE_CHECKING

from plantigrade.lazy import lazy

if TYPE_CHECKING:
    from plantigrade.analyze.curves import GaitCurves, gait_curves
    from plantigrade.analyze.gait import GaitMeasures, Statistic, gait_measures
    from plantigrade.analyze.gait_forces import ForceComparison, compare_forces
    from plantigrade.analyze.gait_study import Study, study
    from plantigrade.analyze.norms import (
        NormCurve,
        Population,
        agreement_with_norm,
        norm,
        population,
        speed_class,
    )
    from plantigrade.analyze.reproduction import Comparison, compare
    from plantigrade.analyze.run_comparison import RunComparison, compare_runs
    from plantigrade.analyze.statistics import Agreement, compare_curves
    from plantigrade.analyze.tolerances import RECORDING_TOLERANCES, Tolerances
    from plantigrade.analyze.trial import Trial, analyse
    from plantigrade.analyze.verdict import Finding, Measure, Verdict

__all__ = [
    "RECORDING_TOLERANCES",
    "Agreement",
    "Comparison",
    "Finding",
    "ForceComparison",
    "GaitCurves",
    "GaitMeasures",
    "Measure",
    "NormCurve",
    "Population",
    "RunComparison",
    "Statistic",
    "Study",
    "Tolerances",
    "Trial",
    "Verdict",
    "agreement_with_norm",
    "analyse",
    "compare",
    "compare_curves",
    "compare_forces",
    "compare_runs",
    "gait_curves",
    "gait_measures",
    "norm",
    "population",
    "speed_class",
    "study",
]

__getattr__ = lazy(__name__)
