"""The orders in which data are learned: one file each, with its options and its phases."""

from repro.plugins.roots import search_path

__path__ = search_path(__name__, __path__)
