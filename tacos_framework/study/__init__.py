"""The design loop: ask, simulate, train, score, tell; then judge on unseen scenes.

===========  ================================================================================================
``study``    one run of a recipe: searches, test, checkpoint, result
``search``   one run of an optimizer over a design space
``scoring``  candidates of a generation in a race, with ``racing``, its statistics
``relay``    weights that candidates share: the next one trains while the last is scored
``parts``    a few cameras on many episodes, cut up so that no worker idles
``progress`` what listens while it runs
===========  ================================================================================================
"""

from __future__ import annotations

from tacos_framework.study.progress import Progress, Silent
from tacos_framework.study.study import BROKEN_OFF, DESIGNED, Study, run_study

__all__ = ["BROKEN_OFF", "DESIGNED", "Progress", "Silent", "Study", "run_study"]
