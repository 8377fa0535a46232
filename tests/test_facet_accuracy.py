"""How exact two facets are, class by class of nasty pairs; prints the table of the README."""

from dataclasses import astuple

import numpy as np
import pytest
from facet_accuracy import QUERIES, worst_errors
from facet_cases import CASES

pytestmark = pytest.mark.engine


@pytest.mark.parametrize("query", QUERIES)
@pytest.mark.parametrize("cases", CASES, ids=lambda cases: cases.__name__)
def test_worst_error(query, cases, record_property):
    """A distance off, a witness point off its facet, or two points apart that should coincide."""
    rng = np.random.default_rng(0)
    worst = worst_errors(QUERIES[query], cases(rng), rng)
    record_property("accuracy", (query, cases.__name__.replace("_", " "), *astuple(worst)))
    limit = CASES[cases]
    assert worst.distance < limit
    assert worst.off_facet < limit
    assert worst.gap < limit
