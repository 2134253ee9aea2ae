"""The true systems, everything that follows from their energies, and their simulation."""
