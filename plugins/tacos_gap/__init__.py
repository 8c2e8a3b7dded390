"""The gap between a simulation and a real camera: where it lies, what causes it, what would close it.

=================  ==========================================================================================
``captures``       folders of real images with what a simulator expects of them
``sensing``        the noise of captures as a sensor, or a sensor component in its place
``formation``      captures simulated by the image formation of studies
``statistics``     what images are compared by, family by family
``evidence``       captures turned into numbers, with the noise floor below which differences mean nothing
``boards``         the same for chessboards, by their corners
``problem``        all evidence together, and how a hypothesis fares on it
``locate``         where a gap lies
``candidates``     the effects that are considered: all that are installed and can be built
``parameters``     effects as hypotheses, and where the search for each begins
``fit``            parameters that explain the evidence best, with ``jacobian``: how residuals move with them
``screening``      which effects are worth a fit
``attribution``    which effects: forward selection on held-out conditions, with ``pruning`` of parameters
``intervals``      how well the captures settle the parameters
``unknown``        whether what is left fits no effect
``ambiguity``      what captures cannot tell apart, and with ``next_capture`` the one that would
``transfer``       parameters in physical units, and effects for the recipes of other cameras
``closure``        how much of the gap each effect removes
``causes``         from the best explanation to causes, with ``findings`` as they are written
``bench``          captures from our own simulator, to rehearse with
``diagnosis``      all of it in order
=================  ==========================================================================================
"""
