"""The first module that the job server loads: ends it with its command, however that ends, while it still loads.

Afterwards the server itself notices that its command is gone.
"""

import os
import threading

PARENT = "REPRO_JOB_SERVER_OF"  # environment variable: the process that has started the server
_PAUSE_S = 0.1
_loaded = threading.Event()


def _end_with(parent: int) -> None:
    while not _loaded.wait(_PAUSE_S):
        if os.getppid() != parent:
            os._exit(1)


def stop() -> None:
    """All modules are loaded; a process with a second thread must not be forked."""
    _loaded.set()
    _thread.join()


# The parent may be gone already, so that its number cannot be read any more.
_thread = threading.Thread(target=_end_with, args=(int(os.environ.get(PARENT, os.getppid())),), daemon=True)
_thread.start()
