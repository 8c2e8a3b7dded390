"""Notes on searches that end before they have learnt anything."""

from __future__ import annotations


def spread_only(evaluations: int, starts: int) -> str:
    """All evaluations belong to the first candidates, which are spread over the space or drawn from it.

    `evaluations`: candidates evaluated in all. `starts`: candidates that are chosen before any result counts.
    """
    return (
        f"Nothing is searched for: the first {starts} candidates are chosen before any result counts, and "
        f"the optimizer evaluates {evaluations}. What is found is the best of a sample. For a search, set "
        f"evaluations well above {starts}."
    )
