"""The results folder of a run: a database, and files beside it.

================  ===========================================================================================
``run``           a run: what stands where, how it begins and goes on
``folder``        a folder that one process writes into at a time
``database``      what stands there in transactions, each entry with a digest
``writers``       files that are there whole or not at all
``log``           who hears what a run notes, and the file it is kept in
``readers``       files as the run left them, or a sentence on what is wrong
``differences``   where the recipe it is to go on with is another one
``manifest``      what a run was started with, held against what is there when it goes on
``dependencies``  what that is, of a study and of a procedure
================  ===========================================================================================
"""

from __future__ import annotations

from tacos_framework.store.database import DATABASE, Database
from tacos_framework.store.folder import is_in_use, lines_file
from tacos_framework.store.readers import (
    DESIGNED,
    FILES,
    RESULT,
    DamagedError,
    digest,
    file_of_run,
    read_result,
    read_run_json,
    read_run_lines,
)
from tacos_framework.store.run import CHECKPOINT, MANIFEST, RECIPE, Results, read_recipe
from tacos_framework.store.writers import replace_file

__all__ = [
    "CHECKPOINT",
    "DATABASE",
    "DESIGNED",
    "FILES",
    "MANIFEST",
    "RECIPE",
    "RESULT",
    "DamagedError",
    "Database",
    "Results",
    "digest",
    "file_of_run",
    "is_in_use",
    "lines_file",
    "read_recipe",
    "read_result",
    "read_run_json",
    "read_run_lines",
    "replace_file",
]
