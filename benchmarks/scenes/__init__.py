"""Scenes of strangers' models, each judged by a truth of its own, beside Drake's own contact.

`python -m benchmarks.scenes` runs them all, writes SCENES.md and the table of the README; ours are
judged in tests/systems/test_scenes.py. Needs the extra `models`.
"""
