"""Processes and clusters that run jobs."""
