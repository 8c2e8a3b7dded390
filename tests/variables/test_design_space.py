"""The design space: whatever an optimizer proposes becomes something that can be built, and back."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from collections import Counter
from multiprocessing import Pipe
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tacos_framework.variables.design_space import (
    Candidate,
    Categorical,
    DesignSpace,
    Gene,
    Integer,
)
from tests.variables.spaces import COLUMNS, SENSORS, full_space, sensor, sensor_choice


def test_genes_name_their_variable_column_and_bounds() -> None:
    assert full_space().genes == (
        Gene("pitch_deg", "pitch_deg", "continuous", -30.0, 30.0),
        Gene("sensor.width_mm", "sensor", "continuous", 3.0, 16.1),
        Gene("sensor.height_mm", "sensor", "continuous", 2.3, 12.0),
        Gene("sensor.pixel_um", "sensor", "continuous", 1.5, 9.0),
        Gene("cameras", "cameras", "integer", 1.0, 4.0),
        Gene("lens", "lens", "choice", 0.0, 4.0),
    )
    assert full_space(scheme="discrete").genes[1] == Gene("sensor", "sensor", "choice", 0.0, 3.0)


def test_decode_clips_rounds_and_snaps() -> None:
    candidate = full_space().decode([-99, 6.1, 4.6, 2.0, 2.6, 1e9])
    assert candidate.values == {
        "pitch_deg": -30.0,
        "sensor": SENSORS[1],
        "cameras": 3,
        "lens": None,
    }
    assert candidate.genes == (-30.0, 6.0, 4.5, 1.5, 3.0, 4.0)
    assert type(candidate.values["cameras"]) is int


def test_normalised_and_plain_distance_choose_different_parts() -> None:
    rows = (sensor("4 mm wider", 14, 4, 2), sensor("3 um coarser", 10, 4, 5), sensor("far", 100, 4, 9))
    wanted = [10.0, 4.0, 2.0]  # plain: 16 against 9; normalised: (4/90)^2 against (3/7)^2
    chosen = {
        distance: sensor_choice(*rows, distance=distance).decode(wanted)[0].name
        for distance in ("normalised", "plain")
    }
    assert chosen == {"normalised": "4 mm wider", "plain": "3 um coarser"}


def test_a_column_in_which_all_parts_agree_tells_nothing() -> None:
    rows = (sensor("a", 1, 4, 2), sensor("b", 2, 4, 2))
    assert sensor_choice(*rows).decode([1.6, 400.0, 2.0])[0].name == "b"


@settings(max_examples=60)
@given(st.lists(st.tuples(*[st.integers(1, 40)] * 3), min_size=1, max_size=12, unique=True), st.data())
def test_quantized_decoding_gives_the_nearest_row(sizes: list[tuple[int, ...]], data: st.DataObject) -> None:
    rows = tuple(sensor(f"s{i}", *size) for i, size in enumerate(sizes))
    choice = sensor_choice(*rows, distance="plain")
    wanted = data.draw(st.tuples(*[st.floats(gene.lower, gene.upper) for gene in choice.genes]))
    part, genes = choice.decode(wanted)
    distances = {row.name: math.dist(wanted, [row.number(column) for column in COLUMNS]) for row in rows}
    assert distances[part.name] == pytest.approx(min(distances.values()))
    assert genes == tuple(part.number(column) for column in COLUMNS)


def test_discrete_rows_are_ordered_by_area() -> None:
    choice = sensor_choice(scheme="discrete")
    assert [choice.decode([index])[0].name for index in range(4)] == ["tiny", "fine", "coarse", "huge"]


@pytest.mark.parametrize("scheme", ["quantized", "discrete"])
@pytest.mark.parametrize("distance", ["normalised", "plain"])
def test_every_part_is_reached_from_its_own_genes(scheme: str, distance: str) -> None:
    space = DesignSpace([sensor_choice(scheme=scheme, distance=distance)])
    for part in SENSORS:
        for value in (part, part.name, part.as_dict()):
            assert space.decode(space.encode({"sensor": value})).values == {"sensor": part}


@pytest.mark.parametrize(
    "variable",
    [sensor_choice(scheme="discrete"), Integer("sensor", 1, 4), Categorical("sensor", ("a", "b", "c", "d"))],
    ids=["catalog", "integer", "categorical"],
)
def test_every_value_is_drawn_about_as_often_the_last_one_too(variable: Any) -> None:
    space, rng = DesignSpace([variable]), np.random.default_rng(1)
    counts = Counter(space.sample(rng).genes for _ in range(800))
    assert len(counts) == 4
    assert min(counts.values()) > 150


def test_quantized_drawing_is_even_in_the_box_of_the_columns() -> None:
    space, rng = DesignSpace([sensor_choice()]), np.random.default_rng(1)
    drawn = np.array([sensor_choice().draw(rng) for _ in range(2000)])
    lower, upper = (np.array([getattr(gene, end) for gene in space.genes]) for end in ("lower", "upper"))
    assert (drawn >= lower).all()
    assert (drawn <= upper).all()
    np.testing.assert_allclose(drawn.mean(axis=0), (lower + upper) / 2, rtol=0.05)
    assert {space.sample(rng).values["sensor"].name for _ in range(200)} == {row.name for row in SENSORS}


def test_sampling_is_repeatable() -> None:
    draws = [full_space().sample(np.random.default_rng(3)).key for _ in range(2)]
    assert draws[0] == draws[1]


VALUES = st.fixed_dictionaries(
    {
        "pitch_deg": st.floats(-30, 30),
        "sensor": st.sampled_from(SENSORS),
        "cameras": st.integers(1, 4),
        "lens": st.sampled_from(["wide", "tele", 1, True, None]),
    }
)


@given(VALUES, st.sampled_from(["quantized", "discrete"]))
def test_values_survive_encoding(values: dict[str, Any], scheme: str) -> None:
    space = full_space(scheme=scheme)
    candidate = space.decode(space.encode(values))
    assert candidate.values == values
    assert {name: type(value) for name, value in candidate.values.items()} == {
        name: type(value) for name, value in values.items()
    }


@given(st.lists(st.floats(allow_nan=False), min_size=6, max_size=6))
def test_any_genes_give_a_candidate_that_decodes_to_itself(genes: list[float]) -> None:
    space = full_space()
    candidate = space.decode(genes)
    assert all(
        gene.lower <= value <= gene.upper for gene, value in zip(space.genes, candidate.genes, strict=True)
    )
    assert space.decode(candidate.genes) == candidate
    assert space.decode(space.encode(candidate.as_dict())) == candidate


def test_equal_values_are_equal_candidates() -> None:
    space = full_space()
    one = space.decode([0.0, 6.0, 4.5, 1.5, 2, 0])
    other = space.decode([-0.0, 6.01, 4.49, 1.5, 2.4, 0.1])
    assert one == other
    assert len({one, other}) == 1
    assert one != space.decode([0.1, 6.0, 4.5, 1.5, 2, 0])
    assert space.decode([0, 6, 4.5, 1.5, 1, 2]) != space.decode([0, 6, 4.5, 1.5, 1, 3])  # 1 is not True


def test_a_candidate_can_be_sent_to_another_process() -> None:
    candidate = full_space().decode([0.0, 6.0, 4.5, 1.5, 2, 0])
    here, there = Pipe()
    here.send(candidate)
    copy = there.recv()
    assert copy == candidate
    assert copy.values == candidate.values
    assert copy.genes == candidate.genes


def test_keys_do_not_depend_on_the_process() -> None:
    program = (
        "from tacos_framework.variables.design_space import Candidate; "
        "print(Candidate({'b': 1, 'a': 'x'}, ()).key)"
    )
    printed = subprocess.run(
        [sys.executable, "-c", program],
        env={"PYTHONHASHSEED": "5"},
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert printed.strip() == Candidate({"a": "x", "b": 1}, (1.0,)).key


def test_candidates_are_reported_with_the_columns_of_their_parts() -> None:
    assert full_space().decode([0.0, 6.0, 4.5, 1.5, 2, 0]).as_dict() == {
        "pitch_deg": 0.0,
        "sensor": {"name": "fine", "width_mm": 6.0, "height_mm": 4.5, "pixel_um": 1.5, "maker": None},
        "cameras": 2,
        "lens": "wide",
    }


def test_fixing_leaves_the_other_variables() -> None:
    space = full_space().fix({"sensor": "a product's own", "pitch_deg": 99})
    assert space.names == ("cameras", "lens")
    assert space.sample(np.random.default_rng(0)).values.keys() == {"cameras", "lens"}
    nothing_left = space.fix(space.names)
    assert nothing_left.decode([]).values == {}
    assert nothing_left.sample(np.random.default_rng(0)).genes == ()


def test_a_space_describes_itself_in_json() -> None:
    described = json.loads(json.dumps(full_space().as_data()))
    assert described == [
        {"name": "pitch_deg", "kind": "continuous", "unit": "deg", "lower": -30, "upper": 30},
        {
            "name": "sensor",
            "kind": "catalog",
            "unit": "",
            "catalog": "sensors",
            "values": 4,
            "left_out": [],
            "scheme": "quantized",
            "columns": list(COLUMNS),
            "distance": "normalised",
        },
        {"name": "cameras", "kind": "integer", "unit": "1", "lower": 1, "upper": 4},
        {"name": "lens", "kind": "categorical", "unit": "", "values": ["wide", "tele", 1, True, None]},
    ]
