"""One file per command of `repro`."""
