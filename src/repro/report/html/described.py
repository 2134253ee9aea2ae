"""What is seen in each figure, for those who do not see it; its numbers stand in the tables of the same section."""

from repro.report.figures.figure import Figure

SEEN = {
    "framework": "Flow chart: data, two energies, the Lagrangian, momentum and Hamiltonian, the port-Hamiltonian "
    "model, and its interconnection with others.",
    "plnn": "Drawing of a small network with its inputs and outputs, a momentum network beside it, and three losses.",
    "validation": "Two velocities over 300 steps for three members: the plant's line, one-step predictions on it, and "
    "rollouts that leave it.",
    "regimes": "Dot plot: a row a data regime, a panel a metric, logarithmic; the printed values as vertical lines.",
    "forward_inverse": "Dot plot: a row a network and optimiser, errors of force and of acceleration on logarithmic "
    "axes; filled dots are inverse fits, open squares forward ones.",
    "learning_curves_objectives": "A panel a network and optimiser: loss over steps, both logarithmic; solid lines are "
    "inverse fits, dashed ones forward.",
    "learning_curves_inertia": "A panel a network and optimiser: least eigenvalue of the mass matrix over steps, with "
    "zero marked; solid lines are inverse fits, dashed ones forward.",
    "learning_curves_optimisers": "Loss over steps, both logarithmic, a line style an optimiser.",
    "identifiability": "A panel a basis: singular values from largest to smallest on a logarithmic axis; the last of "
    "them drop to the level of rounding.",
    "dip_energies": "Dot plot: a row a sequence of data, a panel an energy error, logarithmic.",
    "dip_pretraining": "Dot plot: a row a regime and optimiser, a panel a metric, logarithmic, and what is printed.",
    "learning_curves_pretraining": "A panel a regime and optimiser: loss over steps with and without pretraining; the "
    "pretrained one jumps where D begins.",
    "port_matrices": "Three small networks of the state, and the skew J and symmetric R that they make, as grids.",
    "passivity_margin": "Worst passivity margin over the steps of the optimiser, a line a model, with zero marked.",
    "energy_over_time": "A panel a model: energy over time of the plant and of the model along the same motion.",
    "composition": "Errors over the number of samples, both logarithmic, a line a way of building the model.",
    "chains": "State error, and processor time, over the number of links, all logarithmic, a line a model.",
    "sip_closed_loop": "Cart and one link drawn at many moments from hanging to erect past a disc; beside them "
    "clearance, energies, position, angle and force over time.",
    "dip_closed_loop": "Cart and two links drawn at many moments from hanging to erect past a small disc; beside them "
    "clearance, energies, position, angles and force over time.",
    "success_map": "A panel a controller: initial states as dots, filled where the loop succeeds, open where it fails.",
    "timing": "A row a comparison: ratio of times and its quartiles on a logarithmic axis; a dashed line at one.",
    "sensitivity": "A row an assumption: how much another choice changes a claim's number, on a logarithmic axis.",
}


def described(figure: Figure) -> str:
    """Return what is seen in a figure; its title where nothing more is said."""
    return SEEN.get(figure.name, figure.title)
