"""The gap between a simulation and a real camera: where it lies, what causes it, what would close it.

Rooms, each built on those above it:

================  ===========================================================================================
``captures``      folders of real images with what a simulator expects of them, and targets that need none
``photographs``   photographs turned into such folders, and what to photograph
``hypotheses``    the effects that are considered, their parameters, and what cannot be told apart
``simulation``    captures simulated by the image formation of studies; ``bench`` makes some to rehearse with
``statistics``    what images are compared by, family by family
``nuisances``     what the captures leave open beside the effects: level, registration, expectation
``evidence``      captures turned into numbers, with their noise floor; ``boards`` by the corners they show
``inference``     how a hypothesis fares on all evidence, and the parameters that explain it best
``attribution``   which effects: forward selection on held-out conditions
``tasks``         what the gap does to perception tasks, and to the choice between cameras
``answer``        all of it in order: causes with intervals, what is left, what to photograph next
``report``        the answer in words, pictures and a page
``procedures``    ``tacos-run diagnose`` and ``simulate_captures``
================  ===========================================================================================
"""
