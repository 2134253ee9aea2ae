"""Bases: one file each, with the features of T and of V written once for any maths namespace.

LINEAR: T is linear in its features, else a network of them. COORDINATES, where present: the units of the coordinates
that the basis is made for; a final `...` repeats the one before it.
"""

from repro.plugins.roots import search_path

__path__ = search_path(__name__, __path__)
