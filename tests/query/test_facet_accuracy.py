"""How exact two facets are, class by class of nasty pairs; prints the table of the README."""

import numpy as np
import pytest
from facet_accuracy import QUERIES, errors, worst_errors
from facet_cases import CASES, WELL_POSED

pytestmark = pytest.mark.engine


@pytest.mark.parametrize("query", QUERIES)
@pytest.mark.parametrize("cases", CASES, ids=lambda cases: cases.__name__)
def test_worst_error(query, cases, record_property):
    """A distance off, a witness point off its facet, or two points apart that should coincide."""
    rng = np.random.default_rng(0)
    worst, limit = worst_errors(QUERIES[query], cases(rng), rng), CASES[cases]
    record_property("accuracy", (cases.__name__.replace("_", " "), limit, query, max(worst)))
    assert worst.distance < limit
    assert worst.off_facet < limit
    assert worst.gap < limit


def test_crossing_found_only_beyond_double_precision():
    """A folded facet that crosses in extended precision only: the point was left anywhere."""
    folded = np.array([[-1.0, -4, 0], [4, 4, 0], [4, 4, 0]])
    facet = np.array(
        [
            [7.066745503216509, 3.695965923238627, -3.304270062615948],
            [0.34251924769931213, 1.9213944375538918, 0.25039972609971345],
            [1.9392349833961797, -2.3973140229116527, -2.542315098740328],
        ]
    )
    X_AB = np.array(
        [
            [-0.6409388149775412, -0.761659993268785, 0.09524437048445256, 3.6591339908195275],
            [0.57571867313039, -0.5590776947855949, -0.5966407131617892, -2.9735872827299232],
            [0.5076863646624443, -0.3275762290628239, 0.7968364758774613, 0.25598315739883315],
            [0, 0, 0, 1],
        ]
    )
    for query in QUERIES.values():
        assert all(max(error) < WELL_POSED for error in errors(query, folded, facet, X_AB))
