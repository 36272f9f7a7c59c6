"""Plots are well-formed drawings, true to their numbers."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from plantigrade.charts import (
    Bar,
    Figure,
    Outline,
    Series,
    bar_plot,
    grid,
    line_plot,
    panel_plot,
    panels_of,
    path_plot,
    timeline_plot,
)
from plantigrade.charts.svg import path_data, ticks_of
from plantigrade.errors import FileError

LABELS = {"title": "t", "x_label": "x", "y_label": "y"}


@pytest.mark.parametrize("low, high", [(-1e-4, 3e-4), (0, 1), (-170, 30), (1e5, 9e5), (2, 2)])
def test_ticks_lie_inside(low, high):
    ticks = ticks_of(low, high)
    assert ticks and all(low - 1e-9 <= t <= high + 1e-9 for t in ticks) and len(ticks) <= 10


def test_a_plot_without_data_is_still_a_drawing():
    svg = line_plot([Series(np.arange(5.0), np.full(5, np.nan))], **LABELS)
    ElementTree.fromstring(svg)
    assert "nan" not in svg.lower().replace("sans", "")


@pytest.mark.parametrize("count", [800, 801, 5000])
def test_long_curves_have_at_most_800_points(count):
    x = np.linspace(0.0, 300.0, count)
    drawn = path_data(x, np.sin(x))
    points = np.array(re.findall(r"[ML](\S+) ([^ML]+)", drawn), dtype=float)
    assert 400 <= len(points) <= 800
    np.testing.assert_allclose(points[:, 1], np.sin(points[:, 0]), atol=0.11)  # rounded to 0.1
    assert points[-1, 0] > 299.0


def test_words_from_outside_are_escaped():
    x = np.arange(3.0)
    hostile = '"</svg><script>'
    svg = line_plot([Series(x, x, hostile)], title=hostile, x_label=hostile, y_label=hostile)
    ElementTree.fromstring(svg)
    assert "<script" not in svg


def test_every_kind_is_well_formed():
    x = np.linspace(0, 1, 9)
    outline = Outline(np.array([[0, 0], [1, 0], [1, 1.0]]), "red")
    for svg in (
        bar_plot(["a"], [1.0], title="t", x_label="x", tips=[2.0], notes=["n"]),
        timeline_plot([("r", [Bar(0, 1, label="b")])], title="t", marks=[0.5]),
        path_plot([Series(x, x)], outlines=[outline], ground=True, **LABELS),
    ):
        ElementTree.fromstring(svg)


def test_a_path_is_drawn_to_one_scale():
    square = np.array([0.0, 1, 1, 0]), np.array([0.0, 0, 1, 1])
    svg = path_plot([Series(*square)], **LABELS)
    (path,) = re.findall(r'<path d="([^"]*)" fill="none"', svg)
    corners = np.array([[float(v) for v in p.split()] for p in re.split("[ML]", path) if p])
    assert np.ptp(corners[:, 0]) == pytest.approx(np.ptp(corners[:, 1]), abs=0.21)


def test_stillness_looks_still():
    """A tenth of a degree does not fill a plot that spans ten."""
    x = np.linspace(0, 1, 50)
    drawing = line_plot([Series(x, 0.05 * np.sin(6 * x))], least=10.0, **LABELS)
    path = re.findall(r'<path d="([^"]*)"', drawing)[0]
    heights = [float(pair.split()[1]) for pair in re.split("[ML]", path) if pair]
    assert np.ptp(heights) < 3


def test_a_logarithmic_axis_is_one():
    x = np.linspace(0, 1, 3)
    svg = line_plot([Series(x, np.array([1e-4, 1e-2, 1.0]))], log=1e-8, **LABELS)
    (path,) = re.findall(r'<path d="([^"]*)" fill="none"', svg)
    heights = [float(y) for y in re.findall(r"[ML][\d.]+ ([\d.]+)", path)]
    assert heights[0] - heights[1] == pytest.approx(heights[1] - heights[2], abs=0.11)


def test_a_timeline_writes_words_only_where_there_is_room():
    rows = [("row", [Bar(0, 9, label="a long name"), Bar(9, 9.3, label="a long name")])]
    svg = timeline_plot(rows, title="t")
    assert svg.count("a long name") == 1


def test_panels_pair_left_and_right():
    time = np.linspace(0, 1, 11)
    curves = {"knee_angle_l [°]": np.sin(time), "knee_angle_r [°]": np.cos(time)}
    curves |= {"pelvis_tx [m]": time, "mtp_angle_r [°]": 0 * time}
    knee, pelvis = panels_of(curves)  # the toe does not move and is left out
    assert list(knee.curves) == ["r", "l"] and knee.title == "Knee flexion"
    assert (knee.unit, pelvis.unit) == ("°", "m")
    svg = panel_plot(knee, time)
    assert "right" in svg and "left" in svg and "ext. ← [°] → flex." in svg


def test_a_grid_holds_its_drawings_and_is_saved(tmp_path):
    x = np.arange(3.0)
    figure = grid([line_plot([Series(x, x)], **LABELS)] * 3, columns=2)
    assert len(ElementTree.fromstring(figure.svg)) == 3
    assert figure._repr_svg_() == figure._repr_html_() == figure.svg
    assert figure.save(tmp_path / "a.svg").read_text(encoding="utf-8") == figure.svg
    with pytest.raises(FileError, match=r"end its name in .svg"):
        figure.save(tmp_path / "a.png")
    with pytest.raises(FileError, match="cannot be written"):
        Figure("<svg/>").save(tmp_path / "none" / "a.svg")


def test_a_plot_is_hatched_where_its_curve_says():
    """Within these stretches and nowhere else, and the two sides in two directions."""
    x = np.arange(101.0)
    one, other = (x > 20) & (x < 40), x > 90
    series = [Series(x, x, "right", hatched=one), Series(x, -x, "left", hatched=other)]
    svg = line_plot(series, **LABELS)
    ElementTree.fromstring(svg)
    found = [[float(v) for v in re.findall(r"[\d.]+", d)]
             for d in re.findall(r'class="hatched" d="([^"]+)"', svg)]  # fmt: skip
    assert len(found) == 2 and all(len(f) > 8 for f in found)
    scale = (330 - 10 - 52) / 100
    for numbers, (a, b) in zip(found, ((21, 39), (91, 100)), strict=True):
        across = np.array(numbers[::2])
        assert across.min() > 52 + a * scale - 2 and across.max() < 52 + b * scale + 2
    rises = [f[1] > f[3] for f in found]
    assert rises == [True, False]
    assert "hatched" not in line_plot([Series(x, x, hatched=x > 200)], **LABELS)
