"""Model files of installable packages, each falling on a table with nothing set by hand.

`python -m benchmarks.model_zoo` runs them all and writes the table of the README; the same runs are
tests/systems/test_model_zoo.py. Needs the extra `models`.
"""
