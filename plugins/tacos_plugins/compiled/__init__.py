"""Loops over pixels as machine code (numba).

``loops``      what makes a function of arrays machine code
``kept_code``  that code on disk
``spline``     the spline through pixels, which the framework takes by its entry point
"""
