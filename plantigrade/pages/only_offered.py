"""What a page may set of its controls: the values that they offer, and nothing else.

viser takes every property and every value that a client sends for a control. A page of ours sends
values alone; a message with anything else is damaged or comes from another program, and would be
met by code that relies on a slider's range or a list's words.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any

from plantigrade.errors import PlantigradeError


def is_offered(control: Any, updates: Mapping[str, Any]) -> bool:
    """Return whether a control of viser offers what a message sets of it.

    Args:
        control: The control.
        updates: Property to value, as they came.
    """
    if set(updates) != {"value"} or getattr(control, "disabled", False):
        return False
    value, options = updates["value"], getattr(control, "options", None)
    if options is not None:
        return isinstance(value, str) and value in options
    if hasattr(control, "step"):
        number = isinstance(value, int | float) and not isinstance(value, bool)
        return number and math.isfinite(value) and control.min <= value <= control.max
    return isinstance(value, bool)  # checkboxes and buttons: a page of ours has no other control


def only_offered(server: Any, refused: Callable[[str], None]) -> None:
    """Let a server of viser take what its controls offer, and open no tunnel to the internet.

    Args:
        server: The server.
        refused: Called with a sentence for every message that is not taken.

    Raises:
        PlantigradeError: If this version of viser does not let its messages be checked.
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
            "this version of viser does not let its messages be checked: install viser 1.1, "
            "or open viewer.html of the run instead"
        ) from error

    async def checked(client: Any, message: Any) -> None:
        control = controls.get(message.uuid)
        if control is None:  # removed meanwhile
            return
        if is_offered(control, message.updates):
            await update(client, message)
        else:
            name = getattr(control, "label", "a control")
            refused(f"A message was refused: {name} does not offer what it sets.")

    interface.register_handler(messages.GuiUpdateMessage, checked)
