"""The results folder of a run.

=============  ==============================================================================================
``results``    the folder: what stands where, and who may write
``checksums``  how its files carry checksums
``writing``    files that are there whole or not at all
``reading``    files as the run left them, or a sentence on what is wrong
``verifying``  what is whole and what is damaged, for ``tacos verify``
=============  ==============================================================================================
"""

from __future__ import annotations

from tacos_framework.results.reading import read_run_json, read_run_lines, read_run_text
from tacos_framework.results.results import Results, read_recipe

__all__ = ["Results", "read_recipe", "read_run_json", "read_run_lines", "read_run_text"]
