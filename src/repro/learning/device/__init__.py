"""Adam on a CUDA device."""
