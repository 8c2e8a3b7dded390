"""Reinforcement learning: a policy that learns to change a camera step by step.

As where tasks learn, triton is kept out of the process: torch imports it with its first optimizer, and its
LLVM ends a process in which Mesa has loaded another one for OpenGL. Nothing here compiles GPU code.
"""

from __future__ import annotations

import sys

sys.modules.setdefault("triton", None)  # type: ignore[arg-type]  # None: not to be imported
