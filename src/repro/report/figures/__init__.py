"""One file a figure: drawn from the result tables alone."""
