"""A vault: joint activations, and sensitivity to the approach."""

import numpy as np

from plantigrade.charts import Figure, Series, line_plot
from plantigrade.charts.theme import PALETTE
from plantigrade.pages.section import ReportedRun, Section, needs
from plantigrade.pages.text import rounded_text
from plantigrade.record.signals import SIGNALS


@needs("vault.joints", "vault.activation")
def activation_section(subject: ReportedRun) -> Section:
    """Return activation over time, one curve per joint."""
    record = subject.record
    names, values = subject.text_signal("vault.joints"), record.signals["vault.activation"]
    series = [
        Series(record.motion.time, values[:, i], name, PALETTE[i % len(PALETTE)])
        for i, name in enumerate(names)
        if np.any(values[:, i])
    ]
    drawing = line_plot(series, y_label="flexion ← → extension", zero=True, least=2.0, width=680)
    caption = (
        "Activation from −1 (full strength in flexion) to 1 (full strength in extension); the "
        "shoulder extends as the angle between arm and trunk opens."
    )
    title = SIGNALS["vault.activation"].section
    return Section(title, [Figure(drawing, caption, wide=True)])


@needs("vault.changed", "vault.change")
def sensitivity_section(subject: ReportedRun) -> Section:
    """Return the sensitivity of the take-off to the approach, largest first."""
    names, change = subject.text_signal("vault.changed"), subject.record.signals["vault.change"]
    best = subject.number("take_off_speed_m_s") or 0.0
    farthest = {n: -1.0 for n in names}
    for name, (_, _, anew) in zip(names, change, strict=True):
        off = abs(anew - best)
        farthest[name] = max(farthest[name], off if np.isfinite(off) else -1.0)
    order = sorted(range(len(names)), key=lambda i: (-farthest[names[i]], names[i], change[i][0]))
    rows = [
        [
            names[i],
            f"{100 * change[i][0]:+.0f} %",
            *(rounded_text(v if np.isfinite(v) else None, 2) for v in change[i][1:]),
            rounded_text(change[i][2] - best if np.isfinite(change[i][2]) else None, 2),
        ]
        for i in order
    ]
    return Section(
        SIGNALS["vault.change"].section,
        text=(
            "Each parameter of the approach was changed by 5 %. Upward velocity at take-off [m/s] "
            "with the same activations, and with activations optimised again from there, sorted by "
            "the change."
        ),
        headers=("changed", "by", "same activations", "optimised again", "change"),
        rows=rows,
    )
