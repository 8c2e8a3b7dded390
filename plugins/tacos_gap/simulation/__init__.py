"""Captures simulated by the sensors and effects that studies use."""
