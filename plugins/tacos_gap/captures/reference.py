"""The reference page of ``captures.yaml``."""

from __future__ import annotations

from tacos_gap.captures.entries import FolderEntry
from tacos_gap.captures.files import MAX_FRAMES
from tacos_plugins.authoring.reference.pages import NOTICE, settings_table


def captures_page() -> str:
    sections = [
        "# Folders of captures",
        NOTICE,
        "A diagnosis reads a folder with `captures.yaml`, images of a real camera, and the values that a "
        "simulator expects, if there is one. [Photograph captures](../how-to/photograph_captures.md) says "
        "how to take them. `tacos captures import PHOTOS --out DIR` makes a folder of photographs, "
        "`tacos captures simulate bench --out DIR` an example, and `tacos captures check DIR` checks one.",
        _CAPTURES_RULES,
        "## Keys",
        settings_table(FolderEntry),
    ]
    return "\n\n".join(sections) + "\n"


_CAPTURES_RULES = f"""\
## Files

- Images are PNG or TIFF of 8 or 16 bits, `.npy`, or camera RAW (extra `raw`), in the order R, G, B; a
  mosaic has one channel. Values are right-aligned (a 12-bit camera reaches 4095) and the camera's own: no
  gamma, no scaling, no rotation. JPEG files should be the camera's own, as their coding is read from the
  headers. EXIF and TIFF rotations and alpha are ignored, and a TIFF of several images is refused.
- Paths start from the folder. `real` and `simulated` take a file, a list, or a glob in the order of
  names, 10 after 9. The first {MAX_FRAMES} frames of a capture are read.
- `simulated` is linear, in digital numbers with the pedestal, without noise, not clipped: (height, width)
  or (height, width, channels), one for all frames or one per frame, or a number for a uniform image. Any
  simulator may make it. With `scene` instead, a bench recipe renders it: its path from the folder or a
  shipped name (`bench`); the capture with the same `id` is used. A list of equal images counts as one.
- Without both, dark frames expect the pedestal, boards their best pose, and walls (`flat`), brackets,
  edges and ColorCheckers an estimate from their own pictures. A `scene` or `sequence` is left out.
- `chart.patches` is a table with the columns `id`, `x`, `y`, `width`, `height` [px] and `r`, `g`, `b`
  [linear DN].
- Captures, and the frames of one, are in the order they were taken, or in the order of `taken_s` (any
  origin); captures without it stay behind their predecessor in the list. Light that only rises or falls
  over captures of one brightness is reported as a drift, and impossible times are doubted.
- `velocity_px_s` and `exposure_ms` give the motion during the exposure. `simulated` is taken to be sharp
  unless `motion_blurred` is set; `effect.motion-blur` then comes on top of it.
- YAML's anchors and aliases are read, up to 10000 repeated entries; merge keys (`<<`) are not.
- Pixels count from 0, and (0, 0) is the centre of the first.

All faults of a folder are reported together, with line and column. Weak captures (constant, saturated or
single frames) are limitations, which the check prints."""
