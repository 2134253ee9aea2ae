"""Bases: one file each, with the features of T and of V written once for any maths namespace."""
