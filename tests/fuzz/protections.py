"""What protects from files and plugins, taken away piece by piece: does a test notice? Run by hand.

``python -m tests.fuzz.protections [WORDS OF A PROMISE]`` changes one line at a time in a copy of the sources,
and runs the test that `docs/explanation/threat_model.md` names for it. Each must fail; the status is 1 where
one does not.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
COPIED = ("tacos_framework", "plugins", "tests", "recipes", "catalogs", "docs", "pyproject.toml")
LIMIT_S = 300.0


@dataclass(frozen=True)
class Protection:
    """A line that protects, and the test that notices when it is gone."""

    promise: str
    """What would no longer hold."""
    file: str
    """Where the line is."""
    line: str
    """A piece of it, which the file has once."""
    without: str
    """What stands there when it no longer protects."""
    test: str
    """Its test."""


PROTECTIONS = (
    Protection(
        "arrays are of numbers alone",
        "plugins/tacos_files/arrays.py",
        "if dtype.kind not in kinds:",
        "if False:",
        "tests/gap/captures/test_bad_folders.py::test_arrays_never_run_code",
    ),
    Protection(
        "checkpoints run no code",
        "plugins/tacos_plugins/tasks/learning/checkpoints.py",
        "weights_only=True",
        "weights_only=False",
        "tests/tasks/learning/test_checkpoints.py::test_code_in_a_checkpoint_is_never_run",
    ),
    Protection(
        "YAML has no tags",
        "tacos_framework/settings/yaml_reader.py",
        "if event.tag is not None:",
        "if False:",
        "tests/settings/test_yaml_reader.py::test_all_faults_of_a_text_come_at_once",
    ),
    Protection(
        "what a library raises on a damaged file is a fault",
        "plugins/tacos_worlds/kit/mesh_files/read.py",
        "except UNREADABLE as error:",
        "except ImportError as error:",
        "tests/fuzz/test_damaged_files.py::test_damage_is_a_value_or_a_fault",
    ),
    Protection(
        "so is what a decoder refuses under a limit that was raised",
        "plugins/tacos_files/images.py",
        "except cv2.error as error:",
        "except ImportError as error:",
        "tests/fuzz/test_hostile_files.py::test_what_a_decoder_refuses_under_a_raised_limit_is_a_fault",
    ),
    Protection(
        "what is cut short is a fault",
        "plugins/tacos_files/arrays.py",
        "or wanted != there:",
        "or wanted < there:",
        "tests/fuzz/test_damaged_files.py::test_what_lacks_its_end_is_a_fault",
    ),
    Protection(
        "nothing large is decoded",
        "plugins/tacos_files/images.py",
        'if header.decoded_bytes > limits().bytes_of("image_mb"):',
        "if False:",
        "tests/fuzz/test_hostile_files.py::test_files_that_claim_gigabytes_take_no_memory",
    ),
    Protection(
        "regular files alone are read",
        "tacos_framework/files/regular.py",
        "if stat.S_ISREG(mode):",
        "if True:",
        "tests/fuzz/test_hostile_files.py::test_only_regular_files_are_read",
    ),
    Protection(
        "links do not lead out of a folder",
        "tacos_framework/files/regular.py",
        "if within is not None and",
        "if False and",
        "tests/fuzz/test_hostile_files.py::test_links_may_not_leave_the_folder",
    ),
    Protection(
        "captures name files of their folder",
        "tacos_framework/files/regular.py",
        "if within is not None and",
        "if False and",
        "tests/gap/captures/test_bad_folders.py::test_captures_may_not_name_files_elsewhere",
    ),
    Protection(
        "files are read by one door",
        "plugins/tacos_worlds/imported/labels.py",
        "headings, lines = read_rows(file)",
        "headings, lines = [], [(1, {'': file.read_text()})]",
        "tests/files/test_one_door.py::test_no_module_reads_files_by_itself",
    ),
    Protection(
        "no control character reaches a terminal",
        "tacos_framework/cli/terminal.py",
        "self.stream.write(printable(text))",
        "self.stream.write(text)",
        "tests/cli/test_terminal.py::test_what_commands_print_is_printable_and_bars_keep_their_cursor",
    ),
    Protection(
        "pages fetch nothing",
        "plugins/tacos_report/page.py",
        "default-src 'none';",
        "default-src *;",
        "tests/report/test_study_page.py::test_the_page_stands_alone",
    ),
    Protection(
        "text in pages is escaped",
        "plugins/tacos_report/page.py",
        "autoescape=True",
        "autoescape=False",
        "tests/report/test_study_page.py::test_what_users_name_is_escaped",
    ),
    Protection(
        "a run pulls in no other files",
        "plugins/tacos_report/study_data.py",
        "if path.is_relative_to(folder.resolve()) and path.is_file()",
        "if path.is_file()",
        "tests/report/test_study_page.py::test_samples_outside_the_folder_are_not_embedded",
    ),
    Protection(
        "Ray listens on the loopback",
        "plugins/tacos_plugins/executors/on_ray/cluster.py",
        'LOOPBACK = "127.0.0.1"',
        'LOOPBACK = "0.0.0.0"',
        "tests/executors/test_ray_executor.py::"
        "test_a_cluster_of_our_own_listens_on_the_loopback_alone_and_is_quiet",
    ),
    Protection(
        "entries of the database of a run carry digests",
        "tacos_framework/store/database.py",
        "if digest != _digest(kind, key, value):",
        "if False:",
        "tests/study/test_damaged_runs.py::test_a_damaged_file_is_named_and_never_gives_another_result",
    ),
)


def main() -> int:
    """Take each away in turn; 1 where a test did not notice."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder)
        for name in COPIED:
            source = ROOT / name
            (shutil.copytree if source.is_dir() else shutil.copy)(source, copy / name)
        asked = [each for each in PROTECTIONS if " ".join(sys.argv[1:]) in each.promise]
        unnoticed = [protection for protection in asked if not _noticed(protection, copy)]
    print(f"{len(asked) - len(unnoticed)} of {len(asked)} are noticed")
    return 1 if unnoticed else 0


def _noticed(protection: Protection, copy: Path) -> bool:
    """Whether the test passes as things are, and fails without the protection."""
    file = copy / protection.file
    whole = file.read_text("utf-8")
    passes = _passes(protection.test, copy)
    file.write_text(whole.replace(protection.line, protection.without), "utf-8")
    passes_without = _passes(protection.test, copy)
    file.write_text(whole, "utf-8")
    noticed = passes and not passes_without
    said = "noticed" if noticed else "NOT NOTICED" if passes else "FAILS AS THINGS ARE"
    print(f"{said}: {protection.promise} ({protection.test})", flush=True)
    return noticed


def _passes(test: str, copy: Path) -> bool:
    """Whether a test passes; one that does not end fails."""
    command = [sys.executable, "-m", "pytest", "-q", "-n0", "-x", "-p", "no:cacheprovider", test]
    path = os.pathsep.join([str(copy), str(copy / "plugins")])
    try:
        done = subprocess.run(
            command,
            cwd=copy,
            env={**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"},
            capture_output=True,
            timeout=LIMIT_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


if __name__ == "__main__":
    sys.exit(main())
