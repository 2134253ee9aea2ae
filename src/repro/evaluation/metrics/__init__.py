"""Metrics that are taken beside the usual ones where they are chosen: one file each, with its options."""

from repro.plugins.roots import search_path

__path__ = search_path(__name__, __path__)
