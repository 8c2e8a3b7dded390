"""torch and OpenGL in one process."""

from __future__ import annotations

import subprocess
import sys

import pytest

pytest.importorskip("torch", reason="the extra perception is not installed")

TRAIN_AFTER_GL = """
from tacos_plugins.renderers.moderngl.context import describe_gl
describe_gl()
import tacos_plugins.tasks.learning
import torch
torch.optim.Adam([torch.nn.Parameter(torch.zeros(1))])
print("both")
"""


@pytest.mark.gl
def test_an_optimizer_can_be_made_where_opengl_is_loaded_already():
    """Triton's LLVM ends the process beside Mesa's; torch imports triton when an optimizer is made."""
    done = subprocess.run([sys.executable, "-c", TRAIN_AFTER_GL], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, "both"), done.stderr[-500:]
