"""The kinds of objective: one file each, with its options and the rows that it minimises."""

from repro.plugins.roots import search_path

__path__ = search_path(__name__, __path__)
