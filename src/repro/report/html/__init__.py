"""The report as pages that open from disk: one front page, one page a claim, one card a run."""
