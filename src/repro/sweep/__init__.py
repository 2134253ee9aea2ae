"""Many runs: planned, listed, run where missing."""
