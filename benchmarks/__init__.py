"""Benchmarks: how fast, as ratios to a yardstick measured in the same run. See README.md."""
