"""Paired timings: this engine against the usual ways of computing, rivals and public packages."""
