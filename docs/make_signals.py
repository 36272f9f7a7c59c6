"""Write the table of ``docs/signals.md`` anew from the registry of signals."""

from pathlib import Path

from plantigrade.record.signals import SIGNALS, Signal

PAGE = Path(__file__).with_name("signals.md")
HEADER = "| signal | shape | unit | meaning | drawn in |\n| --- | --- | --- | --- | --- |\n"


def main() -> None:
    """Replace everything from the table on."""
    PAGE.write_text(page(PAGE.read_text("utf-8")), encoding="utf-8")


def page(text: str) -> str:
    """Return the text of the page with the table of today."""
    return text.partition(HEADER)[0] + HEADER + "".join(map(row, SIGNALS.values()))


def row(signal: Signal) -> str:
    """Return the row of a signal."""
    name = f"`{signal.name.replace('*', 'NAME')}`"
    axes = ["…" if axis in ("*", "...") else str(axis) for axis in signal.axes]
    shape = "any" if signal.has_any_shape else f"({', '.join(axes)}{',' * (len(axes) == 1)})"
    unit = f"`{signal.unit}`" if "." in signal.unit else signal.unit
    unit = {"word": "words", "flag": "flags"}.get(signal.kind, unit)
    return f"| {name} | {shape} | {unit} | {signal.meaning} | {signal.section} |\n"


if __name__ == "__main__":
    main()
