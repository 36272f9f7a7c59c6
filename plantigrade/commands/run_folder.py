"""Open a run folder: the body, what happened, the figures."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from plantigrade.errors import FileError

if TYPE_CHECKING:
    from plantigrade.record import Record


def open_run(folder: Path) -> tuple[Any, "Record", dict[str, Any]]:
    """Return the compiled MuJoCo model, the record and the metrics of a run.

    Raises:
        FileError: If the folder is no run folder, or its model and its motion do not belong
            together.
    """
    import mujoco

    from plantigrade.record.folder import MODEL, MOTION, read_run

    xml, record, metrics = read_run(folder)
    try:
        model = mujoco.MjModel.from_xml_string(xml)
    except ValueError as error:  # what MuJoCo raises for any fault of the text
        problem = " ".join(str(error).split())
        raise FileError(
            folder / MODEL, f"MuJoCo cannot compile it ({problem})", remedy="make the run anew"
        ) from error
    names = tuple(model.joint(i).name for i in range(model.njnt))
    if names != record.motion.joint_names:
        raise FileError(
            folder / MOTION,
            f"its {len(record.motion.joint_names)} joints are not the {len(names)} of {MODEL}",
            where="joint_names",
            remedy="make the run anew",
        )
    return model, record, metrics
