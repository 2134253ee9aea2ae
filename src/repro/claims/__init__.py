"""The claims of a paper and the assumptions behind our reading: predicates on stored results, and their verdicts."""
