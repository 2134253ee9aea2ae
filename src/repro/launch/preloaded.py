"""The last module that the server of jobs loads: what has been loaded by now is the code of all its jobs."""

from repro.tracking import code

code.remember_loaded()
