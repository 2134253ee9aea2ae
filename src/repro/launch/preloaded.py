"""The last module that the job server loads: records the code of the modules loaded before it, for all jobs."""

import gc

from repro.launch import watch_parent
from repro.tracking import code, record

record.prepare()
code.remember_loaded()
watch_parent.stop()
# The search for unused objects in a job would go through everything loaded here, and copy its memory.
gc.collect()
gc.freeze()
