"""A camera in use, diagnosed from its recording alone: no chart, no simulation.

============== ========================================================================
``detail``     fine detail of a frame beside that of a shorter exposure of the moment
``motion``     how much of the motion of the image is in the blur of an exposure
``overlap``    vignetting and unsteady brightness, by points that consecutive frames share
``diagnosis``  response, noise, motion, vignetting and brightness of a recording, at rest and in motion
``page``       what was found, as a report
============== ========================================================================
"""
