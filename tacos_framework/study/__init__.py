"""The design loop: ask, simulate, train, score, tell; then judge on unseen scenes.

======================  ====================================================================================
``running``             a study in its results folder: begun, gone on with, broken off
``study``               one run of a recipe: searches, test, checkpoint, result
``search``              one run of an optimizer over a design space, with ``search_state``, what it knows
``guarded_optimizer``   the optimizer, guarded: what it asks for is checked
``problem``             what it is told of the problem beside the design space
``episodes``            which episodes candidates are scored and trained on
``unique_evaluations``  candidates that do not hand on what they learn: each thing once
``pipelined``           weights that candidates share: the next one trains while the last is scored
``finalists``           the most promising of every search, scored once more at the same time
``account``             what evaluations took, and why those failed that did
``shards``              a few cameras on many episodes, cut up so that no worker idles
``worlds_ahead``        worlds of the test, built while workers would wait
``failure_policy``      when candidates keep failing by one defect
``unseen_test``         cameras on scenes that none was designed on, with ``sequential``, its statistics,
                        and ``fitness_contributions``, what each scene tells about the fitness
``samples``             frames of the cameras, to look at
``analysis``            all that was scored, as a ``record`` for those who analyse it
``degenerate``          when no winner may be named
``score_spread``        how far each score tells cameras apart
``outcome``             what came out, as ``result.json`` has it
``records``             what lines of the run's folder keep of candidates and generations
``journal``             what was evaluated since the last of the ``checkpoints``
``run_files``           types of what the files of a run hold, with ``kept_evaluation``
``extension``           studies that go on for longer
``progress``            what listens while it runs
======================  ====================================================================================
"""

from __future__ import annotations

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
