"""What every job looks up, looked up when this is loaded: by the server of processes, once for all of its jobs."""

from contextlib import suppress

from repro.codegen import c_library
from repro.config.defaults import flat
from repro.config.registry import groups
from repro.control.controller import CONTROLLERS
from repro.errors import UserError
from repro.evaluation.metric_options import METRICS
from repro.learning.objective_options import OBJECTIVES
from repro.learning.optimiser_options import OPTIMISERS
from repro.learning.sequence_options import SEQUENCES
from repro.models.model_options import MODELS
from repro.plugins.plugin import plugin_names
from repro.tracking import provenance

FOLDERS = (MODELS, OBJECTIVES, OPTIMISERS, SEQUENCES, METRICS, CONTROLLERS, "pipeline.stages", "mechanics.systems")

with suppress(UserError):  # a job that meets it shows it
    for folder in FOLDERS:
        plugin_names(folder)
    for group, options in groups().items():
        for option in options:
            flat(group, option)
c_library.look_up()
provenance.look_up()
