"""The choices of conf/control: one file per kind, with its `Options` and `build`."""
