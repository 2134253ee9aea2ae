"""Energy-based model predictive control with learned models, and what it is compared with."""
