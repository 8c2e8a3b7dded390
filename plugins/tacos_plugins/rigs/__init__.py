"""Default rigs."""
