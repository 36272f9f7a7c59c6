"""What happened: a Motion plus forces, torques, markers and what should be known about it."""

from dataclasses import dataclass, field

from plantigrade.arrays import Array, Bool, Float
from plantigrade.motion.motion import Motion
from plantigrade.motion.recording import Markers


@dataclass(frozen=True)
class Record:
    """What one command produced; every engine returns it, every report reads it.

    Attributes:
        motion: The motion.
        qfrc_actuator: Generalised force of the joints [N m]; its first six entries hold what the
            dynamics leave unexplained at the root (residual), world force [N], body moment [N m].
        contact_force: Ground reaction on the body at each contact, world [N].
        contact_point: Where it acts, world [m]; NaN where the force is zero.
        contact_torque: Free moment at that point, world [N m], where known.
        contact_side: ``"l"`` or ``"r"`` of each contact.
        contact_segment: Foot segment or plate name of each contact.
        contact_known: Where the force of a contact is known at all; None: everywhere. A foot that
            stands beside its force plate has a force, but nobody knows it.
        reference_qpos: Another motion of the same Human to show beside this one.
        recorded_markers: The recorded markers, on the frames of ``motion``.
        fitted_markers: The same markers on the body, world [m].
        metrics: Every figure of the run: flat snake_case keys, unit as suffix; plus ``status``.
        warnings: What the user should know, one sentence each.
    """

    motion: Motion
    qfrc_actuator: Float[Array, "n_frames nv"] | None = None
    contact_force: Float[Array, "n_frames n_contacts 3"] | None = None
    contact_point: Float[Array, "n_frames n_contacts 3"] | None = None
    contact_torque: Float[Array, "n_frames n_contacts 3"] | None = None
    contact_side: tuple[str, ...] = ()
    contact_segment: tuple[str, ...] = ()
    contact_known: Bool[Array, "n_frames n_contacts"] | None = None
    reference_qpos: Float[Array, "n_frames nq"] | None = None
    recorded_markers: Markers | None = None
    fitted_markers: Float[Array, "n_frames n_markers 3"] | None = None
    metrics: dict = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
