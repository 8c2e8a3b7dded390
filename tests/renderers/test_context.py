"""The OpenGL context: what it says of itself, and what it says when there is none."""

from __future__ import annotations

import os

import moderngl
import pytest

from tacos_framework.errors import UserError
from tacos_plugins.renderers.moderngl import context


@pytest.mark.gl
def test_description_names_the_renderer_and_tells_software_from_a_gpu():
    info = context.describe_gl()
    assert info.renderer in str(info)
    assert info.is_software == ("llvmpipe" in info.renderer or "softpipe" in info.renderer)


@pytest.mark.gl
def test_one_context_per_process():
    assert context.gl_context() is context.gl_context()


def test_without_opengl_the_message_says_what_to_install(monkeypatch):
    tried = []

    def refuse(**settings):
        tried.append((settings["libgl"], settings["libegl"]))
        raise Exception("libEGL not loaded")

    monkeypatch.setattr(context, "_context", None)
    monkeypatch.setattr(moderngl, "create_context", refuse)
    with pytest.raises(UserError) as caught:
        context.gl_context()
    message = str(caught.value)
    assert "renderer.moderngl: no OpenGL 3.3 context" in message
    assert "libEGL not loaded" in message
    assert "libegl1 libgl1-mesa-dri libegl-mesa0" in message
    assert "renderer.analytic" in message
    assert ("libGL.so.1", "libEGL.so.1") in tried
    assert ("libGL.so", "libEGL.so") in tried


@pytest.mark.gl
def test_a_forked_process_is_refused_instead_of_hanging(monkeypatch):
    context.gl_context()
    monkeypatch.setattr(os, "getpid", lambda: -1)
    with pytest.raises(RuntimeError, match="spawn"):
        context.gl_context()
