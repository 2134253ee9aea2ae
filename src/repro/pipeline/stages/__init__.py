"""The work of each stage of a run: plain arguments in, files and a summary out."""
