"""The kinds of model: one file each, with its options and how it is built from them."""

from repro.plugins.roots import search_path

__path__ = search_path(__name__, __path__)
