"""The YAML dialect: YAML 1.2 scalars, positions for everything, and a sentence for each refusal."""

from __future__ import annotations

import json
from dataclasses import replace
from multiprocessing import Pipe
from pathlib import Path
from textwrap import dedent

import pytest
import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tacos_framework.errors import Fault, UserError
from tacos_framework.settings.yaml_document import Document
from tacos_framework.settings.yaml_reader import MAX_DEPTH, read_yaml, read_yaml_draft


def faults_of(text: str | Path) -> list[tuple[str, str]]:
    with pytest.raises(UserError) as caught:
        read_yaml(text, name="recipe.yaml")
    return [(fault.where, fault.what) for fault in caught.value.faults]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 1e-3),
        ("1.0e-4", 1e-4),
        ("-.5", -0.5),
        ("3.", 3.0),
        ("+7", 7),
        ("010", 10),
        ("0o10", 8),
        ("0x1F", 31),
        ("1:30", "1:30"),
        ("1_000", "1_000"),
        ("0b101", "0b101"),
        ("no", "no"),
        ("on", "on"),
        ("y", "y"),
        ("2024-01-02", "2024-01-02"),
        ("=", "="),
        ("true", True),
        ("FALSE", False),
        ("~", None),
        ("", None),
        ("'1e-3'", "1e-3"),
        ('"nan"', "nan"),
        ("|-\n  12", "12"),
    ],
)
def test_scalars_follow_the_core_schema_of_yaml_1_2(text: str, value: object) -> None:
    found = read_yaml(f"key: {text}\n").data["key"]
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    "text", [".nan", ".NaN", "-.inf", "+.INF", "nan", "NaN", "-inf", "Infinity", "1e999"]
)
def test_numbers_that_are_not_finite_are_refused(text: str) -> None:
    [(where, what)] = faults_of(f"a: 1\nkey: {text}\n")
    assert where == "recipe.yaml:2:6"
    assert text in what


def test_every_entry_has_the_position_of_its_key_or_item() -> None:
    document = read_yaml(
        dedent("""\
        # a comment
        rig:
          use: rig.monocular
        fitness:
          - {score: a.b, weight: 1}
          - score: c.d
        """),
        name="recipe.yaml",
    )
    assert document.where(("rig",)) == "recipe.yaml:2:1"
    assert document.where(("rig", "use")) == "recipe.yaml:3:3"
    assert document.where(("fitness", 0)) == "recipe.yaml:5:5"
    assert document.where(("fitness", 0, "weight")) == "recipe.yaml:5:18"
    assert document.where(("fitness", 1, "score")) == "recipe.yaml:6:5"


def test_an_unknown_path_is_where_its_nearest_ancestor_is() -> None:
    document = read_yaml("rig:\n  use: x\n", name="recipe.yaml")
    assert document.where(("rig", "missing", 3)) == "recipe.yaml:1:1"
    assert document.where(("rig", "use", 0)) == "recipe.yaml:2:3"
    assert document.where() == "recipe.yaml:1:1"
    assert read_yaml("", name="empty.yaml").where(("a",)) == "empty.yaml:1:1"


def test_only_real_entries_have_positions() -> None:
    assert set(read_yaml("a: [1, {b: 2}]").positions) == {(), ("a",), ("a", 0), ("a", 1), ("a", 1, "b")}


def test_all_faults_of_a_text_come_at_once() -> None:
    text = dedent("""\
        a: 1
        a: {b: .nan}
        c: &anchor 2
        d: *anchor
        e: !!python/object:os.system x
        <<: {f: 1}
        7: 8
        ? [g]
        : {h: 1, h: 2}
    """)
    assert faults_of(text) == [
        ("recipe.yaml:2:1", "key 'a' stands here again, first in line 1"),
        ("recipe.yaml:2:8", ".nan is not a number that can be used"),
        ("recipe.yaml:3:4", "anchor &anchor is not supported"),
        ("recipe.yaml:4:4", "alias *anchor is not supported"),
        ("recipe.yaml:5:4", "tag tag:yaml.org,2002:python/object:os.system is not supported"),
        ("recipe.yaml:6:1", "merge keys '<<' are not supported"),
        ("recipe.yaml:7:1", "a key is the number 7"),
        ("recipe.yaml:8:3", "a key is a list"),
        ("recipe.yaml:9:10", "key 'h' stands here again, first in line 9"),
    ]


def test_aliases_stand_for_what_they_name_where_they_are_asked_for() -> None:
    """As PyYAML writes what a program holds twice."""
    board = {"inner_corners": [9, 6], "square_mm": 25}
    data = {
        "captures": [{"id": "a", "board": board}, {"id": "b", "board": board, "at": board["inner_corners"]}]
    }
    text = yaml.safe_dump(data)
    assert "*id001" in text
    document = read_yaml(text, name="captures.yaml", aliases=True)
    assert document.data == data
    aliased = document.where(("captures", 1, "board", "square_mm"))
    assert aliased == document.where(("captures", 1, "board")), "what an alias repeats stands at the alias"


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("a: *b\nb: &b 1\n", "names nothing that ends before it"),
        ("a: &a [*a]\n", "names nothing that ends before it"),
        ("a: &a 1\n<<: *a\n", "merge keys"),
        (
            "\n".join(
                ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
                + [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 30)]
            ),
            "repeat more than",
        ),
        ("\n".join(["a0: &a0 " + "[" * 30 + "]" * 30, "a1: " + "[" * 30 + "*a0" + "]" * 30]), "nest deeper"),
    ],
    ids=["later", "itself", "merged", "a_billion_laughs", "deep"],
)
def test_aliases_are_bounded(text: str, what: str) -> None:
    with pytest.raises(UserError, match=what):
        read_yaml(text, aliases=True)


@pytest.mark.parametrize(
    ("text", "where", "hint"),
    [
        ("a: b: c\n", "recipe.yaml:1:5", "colon"),
        ("a:\n\tb: 1\n", "recipe.yaml:2:1", "spaces"),
        ("a: [1, 2\n", "recipe.yaml:2:1", ""),
        ("a: 1\nword\n", "recipe.yaml:3:1", "space after the colon"),
        ("a: @x\n", "recipe.yaml:1:4", "Quote"),
    ],
)
def test_a_syntax_error_is_one_fault_with_its_place(text: str, where: str, hint: str) -> None:
    with pytest.raises(UserError) as caught:
        read_yaml(text, name="recipe.yaml")
    [fault] = caught.value.faults
    assert fault.where == where
    assert hint in fault.remedy


def test_faults_before_a_syntax_error_are_told_too() -> None:
    assert [where for where, _ in faults_of("a: 1\na: 2\nb: ]\n")] == ["recipe.yaml:2:1", "recipe.yaml:3:4"]


def test_a_second_document_is_refused() -> None:
    assert faults_of("a: 1\n---\nb: 2\n") == [("recipe.yaml:2:1", "a second document starts here")]
    assert faults_of("a: 1\n---\n''\n") == [("recipe.yaml:2:1", "a second document starts here")]


def test_an_empty_document_at_the_end_is_nothing() -> None:
    assert read_yaml("a: 1\n---\n").data == {"a": 1}


def test_nesting_is_bounded_however_it_is_written() -> None:
    assert read_yaml("[" * MAX_DEPTH + "]" * MAX_DEPTH).data is not None
    for text in ("[" * 100_000, "{a: " * 20_000, "- " * 20_000, "? " * 20_000):
        assert faults_of(text)[-1][1] == f"nesting is deeper than {MAX_DEPTH} levels"


def test_size_is_bounded(tmp_path: Path) -> None:
    (tmp_path / "large.yaml").write_text("#" * (1_000_000 + 1))
    assert "larger than" in faults_of(tmp_path / "large.yaml")[0][1]
    assert "larger than" in faults_of("#" * (1_000_000 + 1))[0][1]


@pytest.mark.parametrize(
    ("content", "where", "what"),
    [
        (b"a: 1\nb: \xff\n", "recipe.yaml:2", "byte 0xff is not UTF-8"),
        (b"a: 1\nb: x\x00\n", "recipe.yaml:2:5", r"character '\x00' is not allowed in YAML"),
        (b'a: "\\0"\n', "recipe.yaml:1:4", r"text holds the character '\x00', which no file can"),
        (b'a: "\\uD800"\n', "recipe.yaml:1:4", r"text holds the character '\ud800', which no file can"),
    ],
)
def test_bytes_that_are_no_text_are_refused(tmp_path: Path, content: bytes, where: str, what: str) -> None:
    (tmp_path / "bad.yaml").write_bytes(content)
    assert faults_of(tmp_path / "bad.yaml") == [(where, what)]


def test_a_file_is_named_by_its_path_and_may_start_with_a_byte_order_mark(tmp_path: Path) -> None:
    path = tmp_path / "recipe.yaml"
    path.write_bytes(b"\xef\xbb\xbfa: 1\r\nb: 2\r\n")
    document = read_yaml(path)
    assert document.data == {"a": 1, "b": 2}
    assert document.where(("b",)) == f"{path}:2:1"


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    assert faults_of(tmp_path / "missing.yaml") == [("recipe.yaml", "there is no file 'missing.yaml'")]
    assert faults_of(tmp_path) == [("recipe.yaml", f"{tmp_path.name} is a folder")]
    assert "not a path" in faults_of(Path("a\0b"))[0][1]


def test_a_document_can_be_sent_to_another_process() -> None:
    document = read_yaml("a: [1]")
    here, there = Pipe()
    here.send(document)
    assert there.recv() == document


SIGNS = r"""a key : - [ ] { } , &x *x !!str !t << ? ' " \U00110000 \x # --- ... | >-2 .nan 1e-3 0x ~ @ ` %"""
SPACES = [": ", "- ", "\n", "  ", "\t", "\x85", "\u2028", "\ufeff", "%YAML 1.2\n", "%TAG ! x\n"]
FRAGMENTS = st.sampled_from([*SIGNS.split(), *SPACES])


@settings(max_examples=400, deadline=None)
@given(st.lists(FRAGMENTS, max_size=25).map("".join) | st.text(max_size=60))
@example('"\\UFFFFFFFF"')
@example('"\\U00110000"')
@example("%YAML " + "9" * 5000 + ".1\n---\n")
@example("a: " + "9" * 5000)
@example("\ud800")
def test_any_text_gives_a_document_or_a_user_error(text: str) -> None:
    try:
        outcome: Document | UserError = read_yaml(text)
    except UserError as error:
        outcome = error
    assert isinstance(outcome, Document) or outcome.faults


SCALARS = st.none() | st.booleans() | st.integers(-(10**30), 10**30)
NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
TEXTS = st.text(st.characters(exclude_categories=["Cs", "Cc", "Cn", "Zl", "Zp"]), max_size=10)
JSON = st.recursive(
    SCALARS | NUMBERS | TEXTS,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.text("abcxyz_", min_size=1, max_size=5), inner, max_size=4)
    ),
    max_leaves=12,
)


@settings(max_examples=150, deadline=None)
@given(JSON)
def test_json_is_read_as_json(data: object) -> None:
    assert read_yaml(json.dumps(data, ensure_ascii=False)).data == data


def test_a_key_at_the_line_and_column_of_a_list_index_keeps_both_positions() -> None:
    document = read_yaml("- [0]\n- [0, 1, 2, {a: 1}]\n- x\n")
    assert document.where((1, 3)) == "text:2:13"
    assert document.where((1, 3, "a")) == "text:2:14"
    assert len(document.positions) == 10


def test_a_draft_holds_what_can_be_read_and_says_what_cannot() -> None:
    document = read_yaml_draft("a: [1, .nan]\nb: {c: *x, c: 2}\nd: 3\n", name="recipe.yaml")
    assert document.data == {"a": [1, None], "b": {"c": None}, "d": 3}
    assert document.unread == {("a", 1), ("b", "c")}
    assert [fault.where for fault in document.faults] == [
        "recipe.yaml:1:8",
        "recipe.yaml:2:8",
        "recipe.yaml:2:12",
    ]
    echo = Fault(document.where(("a", 1)), "a.1 is null")
    other = Fault(document.where(("d",)), "d is 3")
    assert document.without_echoes([*document.faults, echo, other]) == [*document.faults, other]
    with pytest.raises(UserError):
        read_yaml("a: [1, .nan]\n")


def test_where_there_is_no_document_there_is_no_draft() -> None:
    for text in ("a: [1, 2\n", "[" * 60 + "]" * 60, "a: \x00"):
        with pytest.raises(UserError):
            read_yaml_draft(text)


def test_what_came_from_elsewhere_has_its_name_with_all_below_it() -> None:
    document = read_yaml("a: {b: {c: 1}, d: 2}\n", name="recipe.yaml")
    changed = replace(document, elsewhere={("a", "b"): "--set a.b", ("e", "f"): "--set e.f"})
    assert changed.where(("a", "b", "c")) == "--set a.b"
    assert changed.where(("a", "d")) == "recipe.yaml:1:16"
    assert changed.where(("a",)) == "recipe.yaml:1:1"
    assert changed.where(("e",)) == "--set e.f"
    assert changed.where(("g",)) == "recipe.yaml:1:1"
