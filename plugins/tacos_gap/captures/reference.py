"""The reference page of ``captures.yaml``."""

from __future__ import annotations

from tacos_gap.captures.entries import FolderEntry
from tacos_gap.captures.files import MAX_FRAMES
from tacos_plugins.authoring.reference.pages import NOTICE, settings_table


def captures_page() -> str:
    sections = [
        "# Folders of captures",
        NOTICE,
        "What a diagnosis reads: a folder with `captures.yaml`, images of a real camera, and what a "
        "simulator expects of each where there is one. "
        "[Photograph captures](../how-to/photograph_captures.md) says how to take them, "
        "`tacos captures import PHOTOS --out DIR` makes a folder of photographs, "
        "`tacos captures simulate bench --out DIR` one to look at, and `tacos captures check DIR` checks "
        "one.",
        _CAPTURES_RULES,
        "## Keys",
        settings_table(FolderEntry),
    ]
    return "\n\n".join(sections) + "\n"


_CAPTURES_RULES = f"""\
## Files

- Images are PNG or TIFF of 8 or 16 bits, `.npy`, or camera RAW (extra `raw`), in the order R, G, B; a mosaic
  has one channel. Values are right-aligned (a 12-bit camera's reach up to 4095) and the camera's own: no
  gamma added, not scaled, not rotated. JPEG files should be the camera's own: how they were coded is read
  from their headers, and taken as given. Files that ask to be turned (EXIF, TIFF) are read as they lie, alpha
  is left out, and a TIFF of several images is refused: each frame is a file.
- Paths start from the folder. `real` and `simulated` take a file, a list, or a glob, whose files come in the
  order of their names, 10 after 9. Of the frames of a capture the first {MAX_FRAMES} are read.
- `simulated` is linear, in digital numbers with the pedestal, without noise, not clipped: (height, width) or
  (height, width, channels), one for all frames or one per frame, or a number where it is the same everywhere.
  Any simulator may have made it. Where a capture names a `scene` instead, ours renders it: a bench recipe,
  the path of one from the folder or the name of a shipped one (`bench`), whose capture of the same `id` is
  taken. A list of images that are all the same counts as one, which its frames repeat.
- Without either, dark frames expect the pedestal, boards the pose that fits best, and walls (`flat`),
  brackets, edges and ColorCheckers what their own pictures tell of the target. A `scene` or `sequence` is
  left out.
- `chart.patches` is a table with the columns `id`, `x`, `y`, `width`, `height` [px] and `r`, `g`, `b` [linear
  DN].
- Captures, and the frames of one, stand in the order they were taken. `taken_s` says when, from any moment
  on: captures are then read in its order, those without one behind what they are listed after. Light that
  only rises or only falls over captures that should be equally bright is named as a drift, and times that
  cannot be (frames that take longer than what lies between two captures) are doubted.
- `velocity_px_s` and `exposure_ms` tell how far the picture moves while the shutter is open. `simulated` is
  taken to be sharp unless `motion_blurred` says that it holds this blur: what is found of
  `effect.motion-blur` then comes on top of it.
- YAML's anchors and aliases are read, up to 10000 repeated entries; merge keys (`<<`) are not.
- Pixels count from 0, and (0, 0) is the centre of the first.

All that is wrong with a folder is said at once, with line and column. What is not wrong but tells little
(frames that are constant, saturated, or single) is a limitation, which the check prints."""
