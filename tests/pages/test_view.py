"""``plantigrade view``: the viewer page of a run, served to the browser."""

import json
import os
import signal
import subprocess
import sys

from tests.pages.runs import fitted


def test_the_command_serves_the_viewer_page_and_ends_with_ctrl_c(browser, tmp_path, record):
    fitted(record).save(tmp_path / "run")
    view = subprocess.Popen(
        [sys.executable, "-m", "plantigrade", "view", str(tmp_path / "run"), "--no-open", "--json",
         "--port", "8442"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ},
        # in the background of a shell the signal would be ignored, and for ever
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    assert view.stderr is not None
    try:
        line = view.stderr.readline()
        assert line.startswith("Viewer at http://localhost:"), line
        browser.open_address(line.split()[2], ready="document.body.dataset.ready === '1'")
        assert browser.evaluate("[!!D.skin, plantigrade.times[1] > 1]") == [True, True]
        assert browser.errors == []
        view.send_signal(signal.SIGINT)
        out, err = view.communicate()
    finally:
        view.kill()
    assert view.returncode == 0, err
    assert "Traceback" not in err
    assert json.loads(out)["kind"] == "fit"
