"""Notes to the user: warnings, except those marked as information."""


class Info(str):
    """A note of information; any other note is a warning.

    It is a string, so one list holds notes of both kinds.

    Example:
        >>> [note for note in ("no plate was hit", Info("1.30 m/s")) if not isinstance(note, Info)]
        ['no plate was hit']
    """

    __slots__ = ()
    informs = True
