"""Paired timings: our engine against the usual ways, forward against inverse, and other formulations."""
