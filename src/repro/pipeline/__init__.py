"""One run: its stages (plan), the work of each (stages), and their execution (run)."""
