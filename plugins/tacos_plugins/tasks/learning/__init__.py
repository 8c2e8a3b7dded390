"""Shared parts of tasks that learn with torch; importing its modules imports torch.

torch imports triton, where it is installed, as soon as an optimizer is made. Triton holds an LLVM of its own,
which ends the process when Mesa has loaded another one for OpenGL before. Nothing here compiles GPU code, so
triton is kept out of processes that have not imported it already.
"""

from __future__ import annotations

import sys

sys.modules.setdefault("triton", None)  # type: ignore[arg-type]  # None: not to be imported
