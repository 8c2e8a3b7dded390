"""Makes cases for the blind check: captures of a camera with injected, known effects.

Nothing here may import the solver (`tacos_gap`) or the effects it tries (`tacos_plugins.effects`):
what inverts its own formulas proves nothing. Scenes are rendered through the geometry with its effects rather
than warped, light is counted in electrons rather than given Gaussian noise, codecs and filters come from
other packages where there are some.
"""
