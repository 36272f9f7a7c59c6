"""The live page: whether it keeps real time at 60 frames a second, and what of two cores it takes.

A person of 66 coordinates on multi-segment feet holds the posture and is pushed now and then, at
the rates of the command line; a program takes all that a browser would be sent. The share of real
time is the clock's, so an idle machine is asked for; processor times hold on a busy one, too.
"""

import subprocess
import sys
import time
from collections.abc import Iterator
from threading import Event, Thread

from experiments.table import Row, at_least, at_most
from plantigrade.live.clock import Clock
from plantigrade.live.session import RATE, run
from plantigrade.pages.live_world import LiveWorld
from plantigrade.pages.page_server import SOCKET_PATH
from plantigrade.workflows.live import prepare, responsive

DURATION = 10.0  # [s]
N_PUSHES = 4
READER = """
import sys
from websockets.sync.client import connect
with connect(sys.argv[1], max_size=None) as line:
    print("ready", flush=True)
    while True:
        line.recv()
"""


def rows() -> Iterator[Row]:
    """Yield the real-time factor, and the times of physics and drawing."""
    session = prepare(joints="66").session
    clock, stop, spent = Clock(), Event(), {}
    page = LiveWorld(session, clock, port=8099)

    def timed(name: str, work, *arguments) -> None:
        began = time.thread_time()
        work(*arguments)
        spent[name] = time.thread_time() - began

    reader = subprocess.Popen(
        [sys.executable, "-c", READER, page.address.replace("http", "ws") + SOCKET_PATH],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    try:
        assert reader.stdout is not None
        reader.stdout.readline()
        parts = {"physics": (run, session, stop, clock), "drawing": (page.show, stop)}
        threads = [Thread(target=timed, args=(name, *part)) for name, part in parts.items()]
        with responsive():
            whole, began, drawn = time.process_time(), time.perf_counter(), page.drawn
            for thread in threads:
                thread.start()
            for _ in range(N_PUSHES):
                time.sleep(DURATION / N_PUSHES)
                session.submit(lambda: session.push(1.0, 0.1))
            stop.set()
            for thread in threads:
                thread.join()
            wall = time.perf_counter() - began
            whole = time.process_time() - whole
    finally:
        stop.set()
        reader.kill()
        reader.wait()
        page.close()
    subject, simulated = "live page, 66 coordinates", session.world.time
    yield at_least(subject, "of real time", 100.0 * simulated / wall, 98.0, "%")
    yield Row(subject, "behind real time", clock.time_lost, f"s in {wall:.0f} s")
    yield at_least(subject, "drawn", (page.drawn - drawn) / wall, 0.9 * RATE, "frames/s")
    yield at_most(subject, "processor, a second of the person", whole / simulated, 1.6, "s")
    for name, seconds in spent.items():
        yield Row(subject, f"of it: {name}", seconds / simulated, "s")
