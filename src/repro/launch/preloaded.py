"""The last module that the job server loads: records the code of the modules loaded before it, for all jobs."""

from repro.launch import watch_parent
from repro.tracking import code

code.remember_loaded()
watch_parent.stop()
