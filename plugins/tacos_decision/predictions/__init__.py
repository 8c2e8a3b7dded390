"""Predictions of scores, written before measuring and held against what was measured later.

================  ==========================================================================
``prediction``    values with intervals, dated and hashed, as a file
``sources``       predictions from the results of a study or of a replayed recording
``outcome``       a prediction beside what was measured
``register``      predictions measured so far, and the model error they show
``commands``      ``tacos predict``
================  ==========================================================================
"""
