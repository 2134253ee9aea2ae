"""Learned Lagrangian and port-Hamiltonian models."""
