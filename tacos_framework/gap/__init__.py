"""The gap between a simulation and a real camera: where it lies, what causes it, what would close it.

=================  ==========================================================================================
``captures``       folders of real images with what a simulator expects of them
``formation``      the simulator itself on plain arrays: effects, noise, rounding
``statistics``     what images are compared by, family by family
``evidence``       captures turned into numbers, with the floor below which differences mean nothing
``hypothesis``     effects with parameters, and the fit of the parameters
``attribution``    which effects: forward selection on held-out conditions
``ambiguity``      what captures cannot tell apart, and the capture that would
``unknown``        whether what is left fits no effect
``closure``        how much of the gap each effect removes
``diagnosis``      all of it in order, and ``diagnosis.json``
=================  ==========================================================================================
"""
