"""Filter of messages that set controls of a page to values outside their range.

viser accepts every property and value that a client sends for a control. Our pages send valid
values only; any other message is damaged or comes from another program, and the code behind a
control relies on its range.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any

from plantigrade.errors import PlantigradeError


def is_offered(control: Any, updates: Mapping[str, Any]) -> bool:
    """Return whether a message sets a valid value of a control of viser.

    Args:
        control: The control.
        updates: Values by property, as received.
    """
    if set(updates) != {"value"} or getattr(control, "disabled", False):
        return False
    value, options = updates["value"], getattr(control, "options", None)
    if options is not None:
        return isinstance(value, str) and value in options
    if hasattr(control, "step"):
        number = isinstance(value, int | float) and not isinstance(value, bool)
        return number and math.isfinite(value) and control.min <= value <= control.max
    return isinstance(value, bool)  # checkboxes and buttons are the only other controls


def filter_control_messages(server: Any, refused: Callable[[str], None]) -> None:
    """Let a server of viser accept valid values only, and refuse tunnels to the internet.

    Args:
        server: The server.
        refused: Called with a sentence for every refused message.

    Raises:
        PlantigradeError: If messages of this version of viser cannot be checked.
    """
    try:
        from viser import _messages as messages

        gui = server.gui
        interface, controls = gui._websock_interface, gui._gui_input_handle_from_uuid
        update = gui._handle_gui_updates
        for kind in (
            messages.GuiUpdateMessage,
            messages.ShareUrlRequest,
            messages.ShareUrlDisconnect,
        ):
            interface.unregister_handler(kind)
    except (ImportError, AttributeError, AssertionError) as error:
        raise PlantigradeError(
            "messages of this version of viser cannot be checked: install viser 1.1, "
            "or open viewer.html of the run instead"
        ) from error

    async def checked(client: Any, message: Any) -> None:
        control = controls.get(message.uuid)
        if control is None:  # the control was removed
            return
        if is_offered(control, message.updates):
            await update(client, message)
        else:
            name = getattr(control, "label", "a control")
            refused(f"A message was refused: its value for {name} is invalid.")

    interface.register_handler(messages.GuiUpdateMessage, checked)
