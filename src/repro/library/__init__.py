"""What notebooks and the pipeline call alike: simulate, fit, and a fitted model with all that can be done with it."""
