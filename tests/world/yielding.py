"""How deep soles are pressed in."""

from plantigrade.constants import GRAVITY, SIDES
from plantigrade.contact.site import contact_sites
from plantigrade.contact.sole import SoleSettings
from plantigrade.record import Record


def yielding(record: Record) -> float:
    """Return the depth to which the greatest force of a site presses in its sole [mm]."""
    per_site = SoleSettings().stiffness * len(SIDES) / len(contact_sites(record.human))
    weight = record.human.mass * GRAVITY
    return 1e3 * float(record.contact_force[:, :, 2].max()) / (per_site * weight) + 0.5
