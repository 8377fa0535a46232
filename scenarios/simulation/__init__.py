"""From a scenario to a diagram, and the record of its run."""
