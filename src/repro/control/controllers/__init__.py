"""The choices of conf/control: one file per kind, with its `Options` and `build`."""

from repro.plugins.roots import search_path

__path__ = search_path(__name__, __path__)
