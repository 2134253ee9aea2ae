"""What a configuration says about the mechanism: its system, and the coordinates of its data."""

from typing import TYPE_CHECKING

from repro.config.schema import Config
from repro.data.data_options import RecordingFile

if TYPE_CHECKING:
    from repro.mechanics.coordinate import Coordinate
    from repro.mechanics.system import System


def coordinates_of(config: Config) -> "tuple[Coordinate, ...]":
    """The coordinates of the data: those of a recording that names them, else those of the system."""
    if isinstance(config.data, RecordingFile) and config.data.coordinates.names:
        return config.data.coordinates.described()
    return true_system(config).coordinates


def true_system(config: Config) -> "System":
    """The system that the configuration describes; UserError for constants that it cannot have."""
    from repro.mechanics.system import load_system

    return load_system(config.system_options)
