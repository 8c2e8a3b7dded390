"""A simulated measuring bench: captures of any camera of ours, to rehearse a diagnosis with."""

from tacos_gap.simulation.bench.rendering import recipe_renderer
from tacos_gap.simulation.bench.settings import BenchCapture, BenchSettings
from tacos_gap.simulation.bench.simulated import CaptureBench

__all__ = ["BenchCapture", "BenchSettings", "CaptureBench", "recipe_renderer"]
