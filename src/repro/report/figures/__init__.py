"""One file per figure: drawn from the result tables alone."""
