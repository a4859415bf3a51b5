"""Benchmarks, run by hand: `python -m benchmarks` in the root of the repository. See README.md."""
