"""One file for each command of `repro`."""
