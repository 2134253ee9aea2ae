"""The report as pages that open from disk: one front page, one page per claim, one card per run."""
