"""Decision of the study in sentences: better, equal within a margin, worse, or undecided."""

from __future__ import annotations

from collections.abc import Mapping

from tacos_report.analysis import Comparison, Decision
from tacos_report.plain_values import Interval
from tacos_report.quantities import joined, number, signed, words

WORDS = {
    "better": "better",
    "worse": "worse",
    "equivalent": "equal within the margin",
    "undecided": "undecided",
    "not admissible": "cannot be compared",
}


def headline(decision: Decision, title: str, products: int) -> str:
    """The verdict on the designed camera against the best product, in a sentence.

    `title`: what people call that product. `products`: how many were compared.
    """
    best = f"the {title}, the best of {products} off-the-shelf cameras" if products > 1 else f"the {title}"
    sure = f"at {_confidence(decision)} confidence"
    match decision.comparison.verdict:
        case "better":
            return f"On unseen scenes it is better than {best}, {sure}."
        case "worse":
            return f"On unseen scenes it is worse than {best}, {sure}: buy that one."
        case "equivalent":
            equal = f"as good as {best}, within a margin of {number(decision.margin, 2)}"
            return f"On unseen scenes it is {equal}, {sure}: either will do."
    return f"Whether it is better than {best} is undecided after {_scenes(decision.comparison)}."


def lead(decision: Decision) -> str:
    found = decision.comparison
    assert found.difference is not None
    text = f"Difference in fitness, scene by scene: {signed(found.difference)}"
    if found.interval is not None:
        text += f", and with {_confidence(decision)} confidence {between(found.interval)}"
        text += f", after {_scenes(found)}. The interval is corrected for interim analyses."
    else:
        text += f", after {_scenes(found)}, which are too few for an interval."
    if decision.margin > 0:
        of_scores = f", from {margin_words(decision.margins)}" if decision.margins else ""
        text += f" Differences below {number(decision.margin, 2)}{of_scores}, are negligible."
    if found.verdict == "undecided":
        text += " Raise test.most_episodes to settle it, or choose by price and supply."
    return text


def row(comparison: Comparison) -> tuple[str, str]:
    if comparison.difference is None:
        return "", comparison.why or WORDS[comparison.verdict]
    ends = f" ({between(comparison.interval)})" if comparison.interval else ""
    return f"{signed(comparison.difference)}{ends}", WORDS[comparison.verdict]


def between(ends: Interval) -> str:
    """An interval of differences, in words.

    >>> between((-0.012, 0.034))
    'between −0.012 and +0.034'
    """
    return f"between {signed(ends[0])} and {signed(ends[1])}"


def share_words(share: float) -> str:
    """A share without a sign.

    >>> share_words(0.01)
    '1\u202f%'
    """
    return joined(number(100 * share), "percent")


def _confidence(decision: Decision) -> str:
    return share_words(decision.confidence)


def margin_words(margins: Mapping[str, float]) -> str:
    """Margins of scores in a row.

    >>> margin_words({"features.inliers": 10.0, "detect.ap50": 0.05})
    '10 in features: inliers and 0.05 in detect: ap50'
    """
    said = [f"{number(margin)} in {words(score)}" for score, margin in margins.items()]
    return " and ".join(filter(None, (", ".join(said[:-1]), said[-1])))


def _scenes(comparison: Comparison) -> str:
    return f"{comparison.episodes} test scene{'' if comparison.episodes == 1 else 's'}"
