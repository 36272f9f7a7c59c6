"""Locks of files that only one process at a time may write."""

from typing import IO

try:
    import fcntl
except ImportError:  # Windows, where a file that is open cannot be renamed or deleted by others
    fcntl = None


def lock(stream: IO[bytes]) -> bool:
    """Lock an open file for this process; return False if another process holds the lock.

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
