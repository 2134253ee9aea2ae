"""One file a system; the file's name is the system's name."""
