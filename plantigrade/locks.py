"""Files that one process at a time writes to."""

from typing import IO

try:
    import fcntl
except ImportError:  # Windows, where a file that is open cannot be renamed or deleted by others
    fcntl = None


def lock(stream: IO[bytes]) -> bool:
    """Keep other processes from a file that is open; return False if one of them has it.

    The lock ends when the file is closed. On file systems without locks there is none.
    """
    if fcntl is None:
        return True
    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True
