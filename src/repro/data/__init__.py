"""Data to learn from: under a random force (D), in free motion (D_H), or from a file."""
