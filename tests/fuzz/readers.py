"""All that reads files from outside, by name; shared by the tests, the campaign and the harness."""

from __future__ import annotations

from collections.abc import Mapping

from tests.fuzz.image_readers import IMAGES
from tests.fuzz.model_readers import MODELS
from tests.fuzz.reader import Reader
from tests.fuzz.run_readers import RUNS
from tests.fuzz.text_readers import TEXTS

READERS: Mapping[str, Reader] = {**IMAGES, **MODELS, **RUNS, **TEXTS}
