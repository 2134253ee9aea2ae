"""Objectives, optimisers and the compiled kernels behind them."""
