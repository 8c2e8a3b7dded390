"""Cameras off the shelf, which designs are compared with and choose from."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tacos_framework.catalog.parts import Catalog
from tacos_framework.catalog.reader import CAMERAS, once_per_version, read_catalog
from tacos_framework.errors import Fault, UserError, did_you_mean
from tacos_framework.packaged_resources import find_file, shipped_folder
from tacos_framework.settings import Settings, check, setting
from tacos_framework.settings.yaml_document import Document
from tacos_framework.settings.yaml_reader import read_yaml

PRODUCT = "camera"
"""The variable of a rig that a whole camera fixes."""


class CatalogCamera(Settings):
    """A camera in a file."""

    title: str = setting(help="Its name for people.", min_length=1)
    maker: str = setting(help="Maker.", min_length=1)
    rig: str = setting(
        help="The rig whose variables it fixes, as in rig.monocular.", pattern=r"^rig\.[a-z-]+$"
    )
    fixes: dict[str, Any] = setting(help="Variables of the rig and their values.", min_length=1)
    sources: tuple[str, ...] = setting(help="Source.", min_length=1)
    notes: tuple[str, ...] = setting((), help="Notes for readers of a comparison.")


class OffTheShelf(CatalogCamera):
    """A camera that can be bought.

    It fixes some variables of a rig; the others (the mounting pitch) are left to whoever builds with it, and
    a comparison optimises them, as the paper does.
    """

    name: str = setting(help="Its name in recipes.")


class _Cameras(Settings):
    title: str = setting("", help="One line for people.")
    cameras: dict[str, CatalogCamera] = setting(help="The cameras.", min_length=1)


def load_cameras(
    names: Sequence[str], catalog: str | Path = "cameras", folder: Path | None = None
) -> tuple[OffTheShelf, ...]:
    """Cameras by name.

    - `names`: their names, in the order wanted.
    - `catalog`: a shipped catalog of cameras, or the path of a YAML file.
    - `folder`: the folder of the recipe: its paths start there and must not leave it. None lifts that.

    Raises `UserError` for every name that is not there or stands twice, or with all that is wrong with the
    file.
    """
    document, cameras = _read(catalog, folder)
    faults = [
        Fault(name, f"{document.name} has no camera {name!r}", "", did_you_mean(name, cameras))
        for name in dict.fromkeys(names)
        if name not in cameras
    ]
    faults += [
        Fault(name, f"camera {name!r} stands here more than once", remedy="Remove one.")
        for name in dict.fromkeys(names)
        if list(names).count(name) > 1
    ]
    if faults:
        raise UserError(faults)
    return tuple(cameras[name] for name in names)


def camera_names(catalog: str | Path = "cameras", folder: Path | None = None) -> tuple[str, ...]:
    """The names of all cameras in a catalog; raises as `load_cameras` does."""
    return tuple(_read(catalog, folder)[1])


def _read(catalog: str | Path, folder: Path | None) -> tuple[Document, dict[str, OffTheShelf]]:
    path = find_file(catalog, shipped_folder("catalogs"), folder=folder, noun="catalog of cameras")
    return once_per_version(path, _cameras_of)


def _cameras_of(path: Path) -> tuple[Document, dict[str, OffTheShelf]]:
    document = read_yaml(path)
    data = document.data
    has_rows = isinstance(data, dict) and "parts" in data
    own = {key: data[key] for key in (CAMERAS,) if key in data} if has_rows else data
    head, faults, _ = check(_Cameras, own, document.where)
    if head is None and not (has_rows and CAMERAS not in own):
        raise UserError(faults)
    fixing: dict[str, CatalogCamera] = {} if head is None else head.cameras
    cameras = {name: OffTheShelf(name=name, **dict(entry)) for name, entry in fixing.items()}
    products = _products(read_catalog(path)) if has_rows else {}
    if twice := sorted(cameras.keys() & products.keys()):
        raise UserError(
            Fault(document.where(("parts", name)), f"{name} is one of its cameras") for name in twice
        )
    return document, {**cameras, **products}


def _products(catalog: Catalog) -> dict[str, OffTheShelf]:
    """The rows whose kind some rig takes, each as the whole camera that it is."""
    if not catalog.rigs:
        what = "nothing says which rig takes these cameras"
        raise UserError(Fault(catalog.name, what, "rigs: {KIND: rig.NAME}, and a column kind"))
    return {
        row.name: OffTheShelf(
            name=row.name,
            title=str(row.values.get("title") or row.name),
            maker=str(row.values.get("maker") or "unknown"),
            rig=rig,
            fixes={PRODUCT: {name: value for name, value in row.as_dict().items() if value is not None}},
            sources=tuple(dict.fromkeys(row.provenance.values())),
            notes=(*row.doubts, *row.notes),
        )
        for row in catalog.rows
        if (rig := catalog.rigs.get(str(row.values.get("kind"))))
    }
