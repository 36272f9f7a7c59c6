"""Tables of options and of controller settings, made from the classes that define them.

``options`` lists the options of a command as the command line takes them; ``controller-settings``
lists what ``--set`` changes of a controller. Both read the package, not a copy of its help.
"""

import importlib
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from html import escape
from typing import Any, NamedTuple

import tyro
from docutils import nodes
from docutils.parsers.rst import Directive, directives

from plantigrade.commands import parsing
from plantigrade.commands.batch_options import BatchOptions
from plantigrade.commands.options import JobOptions, PrintOptions, RunOptions
from plantigrade.models.person import Person
from plantigrade.trajopt.tasks.impairments import Impairments
from plantigrade.vaulting.approach import Approach
from plantigrade.vaulting.table import VaultingTable
from plantigrade.workflows.controller_options import (
    AnyOptions,
    SpringOptions,
    StepOptions,
    WalkOptions,
)
from plantigrade.workflows.settings import RecordingSettings, Settings, SolveSettings

SHARED = {
    Impairments: "Impairments",
    SolveSettings: "Solver",
    RecordingSettings: "Recording",
    AnyOptions: "Controller",
    SpringOptions: "Controller",
    StepOptions: "Controller",
    WalkOptions: "Controller",
    Approach: "Approach",
    VaultingTable: "Vaulting table",
    Person: "Person",
    Settings: "Person",
    JobOptions: "Several at once",
    BatchOptions: "Several at once",
    RunOptions: "Output",
    PrintOptions: "Output",
}
"""Class that defines options → heading of its table, in the order of the tables."""
OWN = "This command"
"""Heading of the options that a command defines itself."""
MAX_OPEN_ROWS = 20  # of a table that is not folded away: about one screen
HEADS = {"name": "Option", "meaning": "Meaning", "default": "Default", "allowed": "Allowed"}
"""Column of a table of options → its heading."""
WIDTHS = {"name": 26, "meaning": 44, "default": 12, "allowed": 18}
"""Column → its share of the width of a table [%]."""
DEFAULT = re.compile(r"\s*\((?:default: (?P<value>.*)|required)\)\s*$", re.S)


class Row(NamedTuple):
    """An option as its table shows it."""

    name: str
    meaning: str
    default: str
    allowed: str


@dataclass(frozen=True)
class Group:
    """The options under one heading."""

    title: str
    rows: Sequence[Row]


def command_class(name: str, subcommand: str = "") -> type:
    """Return the dataclass of a command, or of one of its subcommands."""
    module = importlib.import_module(f"plantigrade.commands.{name}")
    if subcommand:
        kinds = {"get": getattr(module, "Get", None), **getattr(module, "SUBCOMMANDS", {})}
        return kinds[subcommand]
    return module.Command


def groups(kind: type) -> list[Group]:
    """Return the options of a command, its own first."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        parser = tyro.extras.get_parser(kind, config=parsing.CONFIG, registry=parsing.REGISTRY)
    rows: dict[str, list[Row]] = {title: [] for title in (OWN, *SHARED.values())}
    for action in parser._actions:
        if action.dest != "help":
            field = action.dest.replace("-", "_")
            rows[SHARED.get(_owner(kind, field), OWN)].append(_row(kind, field, action))
    for found in rows.values():
        found.sort(key=lambda row: row.name.startswith("-"))  # arguments without a name first
    return [Group(title, found) for title, found in rows.items() if found]


def settings(controller: str) -> list[Group]:
    """Return the settings of a controller by component, its own first; none if it has none."""
    from plantigrade.commands.simulate import word_of
    from plantigrade.control.choices import CONTROLLERS
    from plantigrade.control.numbers import numbers_of

    kind = CONTROLLERS[controller].settings
    rows: dict[str, list[Row]] = {}
    for each in numbers_of(kind()) if kind else ():
        component = each.name.rpartition(".")[0]
        row = Row(each.name, _plain(each.meaning), word_of(each.value), "")
        rows.setdefault(component, []).append(row)
    return [Group(component, found) for component, found in rows.items()]


def _owner(kind: type, field: str) -> type:
    """Return the class that defines a field first."""
    return [each for each in kind.__mro__ if field in vars(each).get("__annotations__", {})][-1]


def _row(kind: type, field: str, action: Any) -> Row:
    text = " ".join((action.help or "").replace("%%", "%").split())
    ending = DEFAULT.search(text)
    default = (ending["value"] or "") if ending else ""
    metavar = "" if action.metavar is None else str(action.metavar)
    choices = ", ".join(action.choices or ())
    name = action.option_strings[0] if action.option_strings else metavar
    if action.option_strings and metavar and not choices:
        name = f"{name} {metavar}"
    required = not action.option_strings and not _has_default(kind, field)
    return Row(
        name=name,
        meaning=DEFAULT.sub("", text).strip(),
        default="required" if required else default,
        allowed=choices or _range(kind, field),
    )


def _has_default(kind: type, name: str) -> bool:
    (field,) = (each for each in fields(kind) if each.name == name)
    return field.default is not MISSING or field.default_factory is not MISSING


def _range(kind: type, field: str) -> str:
    for each in kind.__mro__:
        if field in vars(each).get("ranges", {}):
            low, high, unit = each.ranges[field]
            return f"{low:.15g} to {high:.15g} {unit}".replace("-", "−").strip()
    return ""


def _plain(meaning: str) -> str:
    return re.sub(r":\w+:|`+|\]_", lambda mark: "]" * (mark[0] == "]_"), meaning)


def setup(app: Any) -> dict:
    """Add the two directives."""
    app.add_directive("options", OptionTables)
    app.add_directive("controller-settings", SettingTable)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


class OptionTables(Directive):
    """Tables of the options of a command: ``options:: COMMAND [SUBCOMMAND]``.

    With ``:own:`` only those of the command itself, with ``:shared:`` only the others.
    """

    required_arguments, optional_arguments = 1, 1
    option_spec = {"own": directives.flag, "shared": directives.flag}

    def run(self) -> list:
        """Return a heading and a table for each group."""
        made: list = []
        for each in groups(command_class(*self.arguments)):
            if ("own" if each.title != OWN else "shared") in self.options:
                continue
            heads = {
                key: head
                for key, head in HEADS.items()
                if key in ("name", "meaning") or any(getattr(row, key) for row in each.rows)
            }
            title = "Options" if "own" in self.options else each.title
            is_open = title == OWN and len(each.rows) <= MAX_OPEN_ROWS
            made += folded(title, table(each.rows, heads), is_open=is_open)
        return made


class SettingTable(Directive):
    """Table of the settings of a controller: ``controller-settings:: NAME``."""

    required_arguments = 1

    def run(self) -> list:
        """Return a table for each component."""
        heads = {"name": "Setting", "meaning": "Meaning", "default": "Default"}
        made: list = []
        for each in settings(self.arguments[0]):
            made += folded(each.title, table(each.rows, heads), is_open=not each.title)
        return made


def folded(title: str, content: nodes.Node, *, is_open: bool) -> list[nodes.Node]:
    """Return content under a title that folds it away, closed unless ``is_open``.

    Without it the options that many commands share would be most of the length of their pages.
    """
    if is_open:
        return [nodes.rubric("", title), content] if title else [content]
    head = f'<details class="options"><summary>{escape(title)}</summary>'
    return [nodes.raw("", head, format="html"), content, nodes.raw("", "</details>", format="html")]


def table(rows: Sequence[Row], heads: Mapping[str, str]) -> nodes.table:
    """Return a table of some columns of rows, by the heading of each."""
    group = nodes.tgroup(cols=len(heads))
    group += [nodes.colspec(colwidth=WIDTHS[key]) for key in heads]
    group += nodes.thead("", _line([[nodes.Text(head)] for head in heads.values()]))
    body = nodes.tbody()
    for row in rows:
        cells = [list(_text(getattr(row, key))) for key in heads if key != "name"]
        body += _line([[nodes.literal("", row.name)], *cells])
    group += body
    return nodes.table("", group, classes=["options"])


def _line(cells: Sequence[Sequence[nodes.Node]]) -> nodes.row:
    return nodes.row("", *(nodes.entry("", nodes.paragraph("", "", *cell)) for cell in cells))


def _text(text: str) -> Iterator[nodes.Node]:
    for number, part in enumerate(text.split("`")):
        if part:
            yield nodes.literal("", part) if number % 2 else nodes.Text(part)
