"""Coverage-guided fuzzing of the readers with atheris; run by hand, see CONTRIBUTING.md.

``python -m tests.fuzz.harness READER [libFuzzer options]``, such as ``-max_total_time=120``. The corpus
starts from the reader's example; an input that breaks the reader is written to ``crash-*`` in this folder.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["tacos_framework", "yaml"]):
    from tests.fuzz.reader import read_or_refuse
    from tests.fuzz.readers import READERS


def main() -> None:
    """Fuzz until the time is up or a reader breaks."""
    if len(sys.argv) < 2 or sys.argv[1] not in READERS:
        sys.exit(f"usage: python -m tests.fuzz.harness {'|'.join(READERS)} [libFuzzer options]")
    reader = READERS[sys.argv.pop(1)]
    with tempfile.TemporaryDirectory() as folder:
        corpus = Path(folder) / "corpus"
        corpus.mkdir()
        (corpus / "example").write_bytes(reader.example())
        atheris.Setup([*sys.argv, str(corpus)], lambda content: read_or_refuse(reader, content, Path(folder)))
        atheris.Fuzz()


if __name__ == "__main__":
    main()
