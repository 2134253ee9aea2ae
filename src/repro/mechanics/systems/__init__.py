"""One file per system; the file's name is the system's name."""

from repro.plugins.roots import search_path

__path__ = search_path(__name__, __path__)
