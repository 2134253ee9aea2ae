"""An executable reading of one paper: learned Lagrangians, port-Hamiltonian structure and energy-based control."""
