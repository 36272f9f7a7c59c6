"""Write a human as MJCF or OpenSim model, or print its segments, joints and strengths."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import ParameterError, RunExists
from plantigrade.models.person import Person
from plantigrade.options import Flag, OutPath, optional

if TYPE_CHECKING:
    from plantigrade.models import Human
    from plantigrade.models.landmarks import Attachment

Lengths = Annotated[tuple[str, ...], optional("NAME=METRES"), tyro.conf.UseAppendAction]
Stiffness = Annotated[float | None, optional("N/M")]
STIFFNESS_RANGE = (1e3, 1e7, "N/m")  # From soft rubber to concrete under a sphere of a sole
SetOrFile = Annotated[str | None, optional("NAME|FILE.toml")]


@dataclass(frozen=True, kw_only=True)
class Command(Person, PrintOptions):
    """Write a human as MJCF or OpenSim model, or print its segments, joints and strengths."""

    ranges = {
        **Person.ranges,
        "foot_stiffness": STIFFNESS_RANGE,
        "ground_stiffness": STIFFNESS_RANGE,
    }

    lengths: Lengths = ()
    """Segment length, such as thigh=0.43; repeatable."""
    marker_set: SetOrFile = None
    """Marker set to add as sites: plug-in-gait, oxford-foot-model, gait2392, rajagopal, or your own
    TOML file."""
    actuators: Annotated[Literal["torque", "position"] | None, optional("{torque,position}")] = None
    """Write a model that can be stepped at once: on the ground, with motors, or servos that hold
    angles. Its key frame standing holds the controls too."""
    sensors: tuple[Literal["feet"], ...] = ()
    """Sensors of a model with actuators: feet (ground reaction on each foot)."""
    foot_stiffness: Stiffness = None
    """Stiffness of the soles of a model with actuators, at each contact point [N/m]."""
    ground_stiffness: Stiffness = None
    """Stiffness of the ground of a model with actuators, under each contact point [N/m]."""
    out: OutPath = None
    """File to write: MJCF, or an OpenSim model if it ends in .osim; - prints the MJCF instead of
    the summary."""
    overwrite: Flag = False
    """Replace the file if it exists."""

    def run(self) -> Outcome:
        """Build the person, write the file if one is named, and say what it is made of.

        Raises:
            ParameterError: If a value is not allowed.
            FileError: If the marker set cannot be read.
            RunExists: If the file exists and is not to be replaced.
        """
        from plantigrade.io.writing import write_text
        from plantigrade.models import Human
        from plantigrade.models.mjcf import with_sites
        from plantigrade.models.osim import to_osim

        if self.overwrite and self.out is None:
            raise ParameterError("--overwrite has no effect without --out")
        human = Human.create(**self.known, lengths=own_lengths(self.lengths))
        markers = _markers(human, self.marker_set)
        if self.out is not None and self.out.suffix.lower() == ".osim":
            if self.actuators is not None:
                raise ParameterError(
                    "an OpenSim model has no --actuators; write MJCF (.xml) instead"
                )
            xml = to_osim(human, markers)
        else:
            sites = {n: (p.body, p.position) for n, p in markers.items()}
            xml = with_sites(self._xml(human), sites)
        metrics = {"status": "ok", "command": "model", **summary(human, markers)}
        if self.out is None:
            return Outcome(text=_text(human, metrics), metrics=metrics)
        if str(self.out) == "-":
            return Outcome(text=xml, metrics=metrics)
        if self.out.exists() and not self.overwrite:
            raise RunExists(f"{self.out} exists; choose another file or add --overwrite")
        self.out.parent.mkdir(parents=True, exist_ok=True)
        write_text(self.out, xml + "\n")
        metrics["target_file"] = self.out
        return Outcome(text=f"{_text(human, metrics)}\nwrote {self.out}", metrics=metrics)

    def _xml(self, human: "Human") -> str:
        """Return the model, with actuators where they are asked for."""
        from plantigrade.contact.simulation_model import simulation_xml

        options = {
            "sensors": self.sensors,
            "foot_stiffness": self.foot_stiffness,
            "ground_stiffness": self.ground_stiffness,
        }
        if self.actuators is not None:
            return simulation_xml(human, actuators=self.actuators, **options)
        for name, value in options.items():
            if value not in (None, ()):
                raise ParameterError(f"--{name.replace('_', '-')} needs --actuators")
        return human.xml


def own_lengths(words: tuple[str, ...]) -> dict[str, float]:
    """Return segment lengths [m] by name from words like ``thigh=0.43``."""
    found: dict[str, float] = {}
    for word in words:
        name, sign, value = word.partition("=")
        name = name.strip().replace("-", "_")
        try:
            length = float(value)
        except ValueError:
            sign = ""
        if not sign or not name:
            raise ParameterError(f"--lengths {word}: write NAME=METRES, as thigh=0.43")
        if name in found:
            raise ParameterError(f"--lengths {name} is given twice; give it once")
        found[name] = length
    return found


def _markers(human: "Human", name: str | None) -> "dict[str, Attachment]":
    """Return where the markers of a set sit, by marker name."""
    from plantigrade.models.markers import marker_set_of, places_of

    return {} if name is None else places_of(marker_set_of(name), human)


def summary(human: "Human", markers: "dict[str, Attachment]") -> dict[str, Any]:
    """Return what a person is made of: counts, masses, lengths, coordinates and markers."""
    import mujoco
    import numpy as np

    from plantigrade.models.coordinates import coordinate_of

    model = human.model
    data = mujoco.MjData(model)
    data.qpos = human.standing()
    mujoco.mj_forward(model, data)
    return {
        "joint_set": human.joints,
        "foot_model": human.feet,
        "sex": human.sex,
        "height_m": human.height,
        "mass_kg": float(model.body_mass.sum()),
        "coordinate_count": model.nv,
        "segment_count": model.nbody - 1,
        "contact_point_count": len(human.contact_points),
        "centre_of_mass_height_m": float(data.subtree_com[1, 2]),
        "lengths_m": {n: getattr(human.dimensions, n) for n in human.dimensions.names()},
        "segments": {
            body.name: {
                "parent": body.parent,
                "mass_kg": body.inertia.mass,
                "coordinates": [h.name for h in body.hinges],
            }
            for body in human.skeleton.bodies
        },
        "coordinates": {
            hinge.name: {
                "low_deg": float(np.rad2deg(hinge.low)),
                "high_deg": float(np.rad2deg(hinge.high)),
                "range_source": coordinate_of(hinge.name).range_source,
                "weakest_nm": hinge.torque[0],
                "strongest_nm": hinge.torque[1],
                "strength_source": coordinate_of(hinge.name).strength_source,
            }
            for body in human.skeleton.bodies
            for hinge in body.hinges
        },
        "markers": {
            name: {"body": place.body, "position_m": [float(v) for v in place.position]}
            for name, place in markers.items()
        },
    }


def _text(human: "Human", metrics: dict[str, Any]) -> str:
    """Return the summary for a reader; left sides are left out, they mirror the right ones."""
    lines = [
        f"{human.sex}, {human.height:.3f} m, {human.mass:.1f} kg: joint set {human.joints}, "
        f"{human.feet} feet",
        f"{metrics['coordinate_count']} coordinates (6 of them the pelvis), "
        f"{metrics['segment_count']} segments, {metrics['contact_point_count']} contact points; "
        f"centre of mass {metrics['centre_of_mass_height_m']:.3f} m above the ground",
        "",
        "lengths [m]",
        *(f"  {name:24}{value:8.3f}" for name, value in metrics["lengths_m"].items()),
        "",
        "segments [kg] (left ones mirror the right)",
        *(
            f"  {name:24}{row['mass_kg']:8.3f}"
            for name, row in metrics["segments"].items()
            if not name.endswith("_l")
        ),
        "",
        f"{'coordinates':26}{'range [deg]':>13}{'strength [N m]':>19}",
        *(
            f"  {name:24}{row['low_deg']:6.0f} {row['high_deg']:6.0f}"
            f"{row['weakest_nm']:11.0f} {row['strongest_nm']:7.0f}"
            for name, row in metrics["coordinates"].items()
            if not name.endswith("_l")
        ),
    ]
    if metrics["markers"]:
        lines += ["", "markers"]
        lines += [f"  {name:24}{row['body']}" for name, row in metrics["markers"].items()]
    return "\n".join(lines)
