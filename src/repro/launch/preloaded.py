"""The last module that the job server loads: records the code of the modules loaded before it, for all jobs."""

from repro.tracking import code

code.remember_loaded()
