"""Maximum likelihood of weights and motion together: a Kalman filter with one column per weight."""
