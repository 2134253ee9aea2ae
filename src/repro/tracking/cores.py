"""How many processor cores this process may use."""


def allowed_cores() -> int:
    """Cores after affinity and the limits of a container or a batch system, at least 1."""
    import joblib  # takes longer to load than most commands need

    return int(joblib.cpu_count())
