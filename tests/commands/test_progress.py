"""What goes to standard error."""

import pytest

from plantigrade.commands.progress import Progress
from plantigrade.notes import Info


@pytest.mark.parametrize("quiet", [False, True])
def test_information_is_no_warning_and_quiet_keeps_warnings_only(quiet, capsys):
    progress = Progress(quiet=quiet)
    progress.note(Info("Walked at 1.3 m/s."))
    progress.note("no plate was hit", of="walk.c3d: ")
    shown = "warning: walk.c3d: no plate was hit\n"
    assert capsys.readouterr().err == (shown if quiet else "Walked at 1.3 m/s.\n" + shown)
