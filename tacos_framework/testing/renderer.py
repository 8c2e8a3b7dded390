"""Conformance suite of renderers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pytest

from tacos_framework.camera.geometry import project
from tacos_framework.testing.call import supplied
from tacos_framework.testing.component import ComponentConformance
from tacos_framework.testing.fingerprint import fingerprint
from tacos_framework.testing.samples import (
    SIGN_CENTRE_M,
    SIGN_ID,
    WALL_X_M,
    sample_episode,
    sample_exposure,
    sample_rig,
)
from tacos_framework.values import Capture, Episode, Exposure, Rig


class RendererConformance(ComponentConformance):
    """The suite for renderers: a wall, a sign and a lamp, seen on a short walk."""

    kind: ClassVar[str] = "renderer"

    @pytest.fixture(scope="class")
    @classmethod
    def renderer(cls) -> Any:
        """One renderer for all tests: building one may take long."""
        return cls().make()

    def capture(
        self,
        renderer: Any,
        episode: Episode | None = None,
        rig: Rig | None = None,
        exposure: Exposure | None = None,
    ) -> Capture:
        """The renderer's capture of the sample episode, or another."""
        keywords = supplied(renderer.capture, rig=rig or sample_rig(), exposure=exposure or sample_exposure())
        capture = renderer.capture(episode or sample_episode(frames=3), **keywords)
        assert isinstance(capture, Capture)
        return capture

    def test_it_gives_a_view_per_camera_in_order(self, renderer: Any) -> None:
        capture = self.capture(renderer, rig=sample_rig("left", "right"))
        assert [view.camera.name for view in capture.views] == ["left", "right"]
        assert [len(view.depth_m) for view in capture.views] == [3, 3]

    def test_its_light_is_finite_and_not_negative(self, renderer: Any) -> None:
        light = self.capture(renderer).views[0].luminance_cd_m2
        assert np.isfinite(light).all()
        assert light.min() >= 0
        assert light.max() > 0

    def test_twice_the_light_gives_twice_the_luminance(self, renderer: Any) -> None:
        one, two = (
            self.capture(renderer, sample_episode(frames=1, brightness=brightness)).views[0]
            for brightness in (1.0, 2.0)
        )
        np.testing.assert_allclose(two.luminance_cd_m2.mean() / one.luminance_cd_m2.mean(), 2.0, rtol=0.01)

    def test_it_measures_depth_along_the_optical_axis(self, renderer: Any) -> None:
        episode = sample_episode(frames=3)
        view = self.capture(renderer, episode).views[0]
        corner = (slice(None), 18, 60)  # off the axis: depth is not distance
        walked_m = episode.trajectory.at(episode.time_s)[:, 0, 3]
        np.testing.assert_allclose(view.depth_m[corner], WALL_X_M - walked_m, rtol=1e-3)

    def test_it_names_objects_where_they_are(self, renderer: Any) -> None:
        view = self.capture(renderer).views[0]
        for frame, pose in enumerate(view.world_from_camera):
            (x, y), depth_m = (np.asarray(value) for value in project(SIGN_CENTRE_M, view.camera, pose))
            assert view.object_id[frame, round(float(y)), round(float(x))] == SIGN_ID
            np.testing.assert_allclose(
                view.depth_m[frame, round(float(y)), round(float(x))], depth_m, rtol=1e-3
            )
        assert set(np.unique(view.object_id)) == {0, SIGN_ID}

    def test_it_repeats_itself(self, renderer: Any) -> None:
        assert fingerprint(self.capture(renderer).views) == fingerprint(self.capture(renderer).views)

    def test_batches_may_be_cut_anywhere(self, renderer: Any) -> None:
        episode = sample_episode(frames=3)
        whole = self.capture(renderer, episode).views[0]
        last = self.capture(renderer, episode[2:]).views[0]
        for name in ("luminance_cd_m2", "depth_m", "object_id", "world_from_camera"):
            np.testing.assert_array_equal(getattr(last, name)[0], getattr(whole, name)[2], err_msg=name)

    @pytest.mark.parametrize("changes", [{"gain_db": 20.0}, {"f_number": 8.0}])
    def test_the_light_of_a_scene_does_not_depend_on_how_it_is_exposed(
        self, renderer: Any, changes: dict[str, float]
    ) -> None:
        changed = replace(sample_exposure(), **changes)
        assert fingerprint(self.capture(renderer, exposure=changed).views) == fingerprint(
            self.capture(renderer).views
        )
