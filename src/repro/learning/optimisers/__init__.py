"""The kinds of optimiser: one file each, with its options and how it is built from them."""
