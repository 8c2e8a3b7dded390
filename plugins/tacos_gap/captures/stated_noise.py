"""The noise that ``captures.yaml`` states, by gain."""

from __future__ import annotations

from collections.abc import Sequence

from tacos_gap.captures.capture import Noise
from tacos_gap.captures.entries import CaptureEntry, FolderEntry, NoiseEntry
from tacos_gap.captures.files import CaptureFiles


class StatedNoise:
    def __init__(self, entry: FolderEntry, files: CaptureFiles):
        self._entry = entry
        self._files = files
        self._check()

    def at(self, i: int, capture: CaptureEntry) -> Noise | None:
        blocks = self._blocks
        if not blocks:
            return None
        matching = [block for block in blocks if block.gain_db == capture.gain_db]
        if not matching and len(blocks) == 1 and "gain_db" not in blocks[0].model_fields_set:
            gains = {each.gain_db for each in self._entry.captures}
            matching = list(blocks) if len(gains) == 1 else []
        if not matching:
            self._files.fault(
                ("captures", i),
                f"noise has no block for gain_db {capture.gain_db:g} of {capture.id!r}",
                "noise: a list with one block per gain_db",
            )
            return None
        return Noise(_per_channel(matching[0].photon_dn), _per_channel(matching[0].thermal_dn2))

    @property
    def _blocks(self) -> Sequence[NoiseEntry]:
        given = self._entry.noise
        if isinstance(given, str):
            return ()
        return (given,) if isinstance(given, NoiseEntry) else given

    def _check(self) -> None:
        seen: set[float] = set()
        for place, block in enumerate(self._blocks):
            at = ("noise",) if isinstance(self._entry.noise, NoiseEntry) else ("noise", place)
            for name in ("photon_dn", "thermal_dn2"):
                if isinstance(getattr(block, name), tuple) and self._entry.camera.channels == 1:
                    self._files.fault((*at, name), f"{name} has 3 numbers for 1 channel", "one number")
            if block.gain_db in seen:
                self._files.fault(at, f"two blocks are for gain_db {block.gain_db:g}", "one block per gain")
            seen.add(block.gain_db)


def _per_channel(value: float | tuple[float, ...]) -> tuple[float, ...]:
    return tuple(value) if isinstance(value, tuple) else (value,)
