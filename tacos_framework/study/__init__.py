"""The design loop: ask, simulate, train, score, tell; then judge on unseen scenes.

===========  ================================================================================================
``study``    one run of a recipe: searches, test, checkpoint, result
``search``   one run of an optimizer over a design space
``scoring``  candidates of a generation in a race, with ``racing``, its statistics
``pipelined``    weights that candidates share: the next one trains while the last is scored
``asking``   the optimizer, guarded: what it asks for is checked
``problem``  what it is told of the problem beside the design space
``episodes`` which episodes candidates are scored and trained on
``records``  what the run's folder keeps of a candidate
``failing``  when candidates keep failing by one defect
``shards``    a few cameras on many episodes, cut up so that no worker idles
``progress`` what listens while it runs
===========  ================================================================================================
"""

from __future__ import annotations

from tacos_framework.study.progress import Progress, Silent
from tacos_framework.study.study import BROKEN_OFF, DEFECT, DESIGNED, Study, run_study

__all__ = ["BROKEN_OFF", "DEFECT", "DESIGNED", "Progress", "Silent", "Study", "run_study"]
