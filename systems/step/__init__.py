"""Contact solved with the step of a discrete plant: the twin that is asked, and the solver."""
