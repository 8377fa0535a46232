"""Whether a run did what it must: measures and acceptance checks."""
