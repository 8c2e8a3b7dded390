"""Ctrl-C while a picture is taken, at any moment of it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

TIMES = 80
LOOKS = """
import os, random, signal, threading, time
from small_worlds import box, camera, matte, quad, rig, standing, world
from tacos_framework.values import Exposure
from tacos_plugins.renderers.moderngl.renderer import ModernglRenderer

renderer = ModernglRenderer(ModernglRenderer.Config())
parts = [quad((5, 0, 0), (0, 0, 3), (0, 3, 0)), *box((3, -1, -1), (4, 1, 1), 1)]
episode = standing(world(parts, [matte(0.5), matte(0.5, roughness=0.3)]))
take = lambda: renderer.capture(episode, rig=rig(camera(160, 120, focal_px=100.0)), exposure=Exposure())
take()
random.seed(0)
lost = 0
for _ in range({times}):
    pressed = threading.Event()

    def press():
        time.sleep(random.uniform(0, 0.02))
        pressed.set()
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=press)
    try:
        thread.start()
        since = None
        while since is None or time.monotonic() < since + 1:
            take()
            if since is None and pressed.is_set():
                since = time.monotonic()
        lost += 1
    except KeyboardInterrupt:
        pass
    thread.join()
print("lost", lost)
"""


@pytest.mark.gl
def test_ctrl_c_is_never_lost_and_never_a_crash():
    """Compiled loops once made arrays by way of Python, where an interrupt was dropped, or ended it all."""
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[1])}
    command = [sys.executable, "-c", LOOKS.format(times=TIMES)]
    found = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=200)
    assert found.returncode == 0, found.stderr
    assert found.stdout.split()[-2:] == ["lost", "0"]
