"""Learned models for use without this project: CasADi functions, C source, a torch module."""
