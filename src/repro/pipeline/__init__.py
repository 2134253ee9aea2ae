"""One run: what it consists of (plan), how each stage is done (work), and doing it (run)."""
