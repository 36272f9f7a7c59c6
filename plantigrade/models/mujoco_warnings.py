"""Warnings of MuJoCo, which writes them to ``MUJOCO_LOG.TXT`` where nobody collects them."""

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco


@contextmanager
def collected_warnings() -> Iterator[list[str]]:
    """Collect the warnings of MuJoCo in a list, and leave no log file.

    Example:
        >>> with collected_warnings() as said:
        ...     model = mujoco.MjModel.from_xml_string("<mujoco><option timestep='nan'/></mujoco>")
        >>> said[0]
        "XML contains a 'NaN'. Please check it carefully."
    """
    said: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(said.append)
    try:
        yield said
    finally:
        mujoco.set_mju_user_warning(before)
