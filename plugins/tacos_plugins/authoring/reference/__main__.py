"""``python -m tacos_plugins.authoring.reference FOLDER``: writes all pages into a folder."""

from __future__ import annotations

import sys
from pathlib import Path

from tacos_plugins.authoring.reference.pages import main

if __name__ == "__main__":
    main(Path(sys.argv[1]))
