"""One run: its stages (plan), the work of each (work), and their execution (run)."""
