"""The gallery of the site: pictures that `make docs` renders, beside those of the other pages.

A hook of MkDocs (``mkdocs.yml``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

PAGE = "gallery.md"


@dataclass(frozen=True)
class Rendered:
    """A picture that `tacos.render` makes, with the line that made it as its caption.

    Parameters
    ----------
    says
        What is to be seen.
    recipe, camera, sets
        As `tacos.render` takes them.
    """

    name: str
    says: str
    recipe: str
    camera: str | None = None
    sets: Mapping[str, Any] = field(default_factory=dict)

    @property
    def call(self) -> str:
        """The call that made it."""
        given = [repr(self.recipe), *([repr(self.camera)] if self.camera else [])]
        return f"tacos.render({', '.join([*given, f'sets={dict(self.sets)!r}'])})"

    def png(self) -> bytes:
        """The picture."""
        import tacos
        from tacos_view.pictures import encoded_png

        return encoded_png(tacos.render(self.recipe, self.camera, sets=self.sets).displayed()[0])


SMALL = {"rig.binning": 5}
RENDERED = (
    Rendered("indoor", "A furnished house at 20 lux, as a Flea3 sees it.", "headset_quick", "flea3", SMALL),
    Rendered(
        "indoor_dark",
        "The same house at half a lux, with more gain.",
        "headset_quick",
        "flea3",
        {**SMALL, "scenario.illumination_lux": 0.5, "scenario.gain_db": 24},
    ),
    Rendered(
        "street", "A town by day, from a car.", "scene.street", None, {"scenario.illumination_lux": 5000}
    ),
    Rendered("street_night", "A town by night.", "scene.street", None, {"scenario.illumination_lux": 10}),
)

FROM_PAGES = (
    (
        "how-to/images/imported_house.jpg",
        "A building of one's own: [use your own world](how-to/use_your_own_world.md).",
    ),
    ("explanation/images/effects.jpg", "Effects from lens to file: [effects](explanation/effects.md)."),
    (
        "tutorials/images/demo_report.jpg",
        "The report of a study: [your first camera](tutorials/first_camera.md).",
    ),
    (
        "explanation/images/diagnosis.jpg",
        "A diagnosis: [how a gap is diagnosed](explanation/gap_diagnosis.md).",
    ),
    (
        "tutorials/images/photographs_report.jpg",
        "A diagnosis [from photographs](tutorials/from_photographs.md).",
    ),
    (
        "how-to/images/blind_check.jpg",
        "Withheld effects, and what they were taken for: [the blind check](how-to/check_the_diagnosis.md).",
    ),
    (
        "explanation/images/rasterised_and_traced.jpg",
        "The rasteriser beside a path tracer: [how far apart they are](how-to/check_the_rasteriser.md).",
    ),
)


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Give the gallery its place in the navigation."""
    config.nav.append({"Gallery": PAGE})
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Render the pictures, and write their page."""
    for each in RENDERED:
        files.append(File.generated(config, f"gallery/{each.name}.png", content=each.png()))
    shown = [f"![{each.says}](gallery/{each.name}.png)\n\n{each.says} `{each.call}`" for each in RENDERED]
    shown += [f"![{says.partition(':')[0]}]({path})\n\n{says}" for path, says in FROM_PAGES]
    files.append(File.generated(config, PAGE, content="\n\n".join(["# Gallery", *shown])))
    return files
