"""OpenSim's inverse kinematics on one trial, in whatever Python has OpenSim.

``python opensim_reference.py MODEL.osim MARKERS.trc`` writes ``figures.json`` into the current
folder. It stands alone: that Python need not have plantigrade.
"""

import json
import sys
import time
from pathlib import Path

import opensim


def main(model_file: str, marker_file: str) -> None:
    """Solve every frame and write what it took and how close it came."""
    opensim.Logger.setLevelString("off")
    model = opensim.Model(model_file)
    model.initSystem()  # loading is not counted
    markers = opensim.MarkerData(marker_file)
    tool = opensim.InverseKinematicsTool()
    tool.setModel(model)
    tool.setMarkerDataFileName(marker_file)
    tool.setStartTime(markers.getStartFrameTime())
    tool.setEndTime(markers.getLastFrameTime())
    tool.setOutputMotionFileName("ik.mot")
    tool.set_report_errors(True)
    tool.setResultsDir(".")
    # Every marker that model and file share weighs one, as ours do.
    names = {markers.getMarkerNames().get(i) for i in range(markers.getNumMarkers())}
    shared = [marker.getName() for marker in model.getMarkerSet() if marker.getName() in names]
    for name in shared:
        task = opensim.IKMarkerTask()
        task.setName(name)
        task.setApply(True)
        task.setWeight(1.0)
        tool.getIKTaskSet().cloneAndAppend(task)
    begin = time.process_time()
    tool.run()
    seconds = time.process_time() - begin
    errors = opensim.TimeSeriesTable(str(next(Path().glob("*ik_marker_errors.sto"))))
    rms = errors.getDependentColumn("marker_error_RMS").to_numpy()
    figures = {
        "version": opensim.GetVersion(),
        "markers": len(shared),
        "frames": len(rms),
        "cpu_ms": 1e3 * seconds / len(rms),
        "rms_mm": 1e3 * float(rms.mean()),
    }
    Path("figures.json").write_text(json.dumps(figures))


if __name__ == "__main__":
    main(*sys.argv[1:])
