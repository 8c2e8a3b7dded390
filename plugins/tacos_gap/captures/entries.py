"""The form of ``captures.yaml``."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, Tag, model_validator

from tacos_framework import Lens, Projection, Scenario, Settings, also_called, setting
from tacos_gap.captures.entry_forms import told_apart

Kind = Literal["dark", "flat", "bracket", "edge", "board", "chart", "scene", "sequence"]
Size = Annotated[int, Field(ge=1, le=100_000)]
NonNegative = Annotated[float, Field(ge=0, le=1e9)]
Level = Annotated[float, Field(ge=-1e9, le=1e9)]
Place = Annotated[float, Field(ge=-1e6, le=1e6)]
Moment = Annotated[float, Field(ge=-1e12, le=1e12)]
Corners = Annotated[int, Field(ge=3, le=1000)]
"""Bounds far beyond any camera, within which nothing overflows."""

ALSO_CALLED = also_called(Scenario)
"""What others call the settings of an exposure, here as in recipes."""

DICTIONARIES = r"^DICT_((4X4|5X5|6X6|7X7)_(50|100|250|1000)|ARUCO_ORIGINAL|APRILTAG_(16h5|25h9|36h10|36h11))$"
"""Names of OpenCV's marker dictionaries."""

PerChannel = Annotated[
    Annotated[NonNegative, Tag("<number>")]
    | Annotated[tuple[NonNegative, NonNegative, NonNegative], Tag("<list>")],
    told_apart("a number, or a list of three, one per channel", length=3),
]
Files = Annotated[
    Annotated[str, Tag("<text>")] | Annotated[tuple[str, ...], Tag("<list>")],
    told_apart("a file, a glob, or a list of files, as in [a.png, b.png]"),
]
FilesOrLevel = Annotated[
    Annotated[Level, Tag("<number>")]
    | Annotated[str, Tag("<text>")]
    | Annotated[tuple[str, ...], Tag("<list>")],
    told_apart("a number, a file, or a list of files, as in [a.npy, b.npy]"),
]
Velocity = Annotated[
    Annotated[tuple[Level, Level], Tag("<list>")] | Annotated[str, Tag("<text>")],
    told_apart("two numbers, as in [120, 0], or a .npy file", length=2),
]


class CropEntry(Settings):
    """Place of the files on the sensor."""

    x: int = setting(0, help="Sensor column of the files' first column.", unit="px", ge=0, le=100_000)
    y: int = setting(0, help="Sensor row of the files' first row.", unit="px", ge=0, le=100_000)
    full_width_px: Size = setting(help="Width of the sensor.", unit="px")
    full_height_px: Size = setting(help="Height of the sensor.", unit="px")


class CaptureCamera(Settings):
    """The simulator's description of the camera."""

    width_px: Size = setting(help="Width of the files.", unit="px")
    height_px: Size = setting(help="Height of the files.", unit="px")
    pixel_um: float = setting(
        3.0, help="Pitch of the pixels.", unit="um", gt=0, le=1e4, also=("pitch_um", "pixel_size")
    )
    focal_length_mm: float | None = setting(
        None,
        help="Focal length; from the boards if absent, 4 mm without any.",
        unit="mm",
        gt=0,
        le=1e5,
        also=("fov", "hfov", "vfov", "zoom", "efl"),
    )
    principal_point_px: tuple[Place, Place] | None = setting(
        None,
        help="Principal point in the files; from the boards if absent, else their centre (or the sensor's).",
        unit="px",
    )
    projection: Projection = setting(
        "rectilinear", help="Assumed projection of the lens; effects on boards come on top of it."
    )
    lens_coefficients: tuple[Place, ...] = setting(
        (), help="Its coefficients in OpenCV's order: k1 to k4 of a fisheye, k1, k2, p1, p2, k3 else."
    )
    lens_is_a_start: bool = setting(
        False,
        help="Take focal length and principal point as first guesses, which boards replace.",
    )
    crop: CropEntry | None = setting(None, help="Place of the files on the sensor.")
    f_number: float | None = setting(
        None, help="Focal length over aperture.", gt=0, le=1e4, also=ALSO_CALLED["f_number"]
    )
    bit_depth: int = setting(8, help="Bits of a sample.", unit="bit", ge=1, le=16)
    white_level_dn: float | None = setting(
        None, help="Largest value of the files; 2**bit_depth - 1 if absent.", unit="DN", gt=0, le=65535
    )
    black_level_dn: float = setting(0.0, help="Pedestal in the files.", unit="DN", ge=0)
    channels: Literal[1, 3] = setting(1, help="1 for mono or a mosaic, 3 for RGB.")
    cfa: Literal["RGGB", "BGGR", "GRBG", "GBRG"] | None = setting(
        None,
        help="Colour filters of a mosaic, from the top-left pixel of the files on; those of a capture with a "
        "crop of its own begin where that does.",
    )

    @model_validator(mode="after")
    def _levels(self) -> CaptureCamera:
        if self.black_level_dn >= self.white:
            origin = "white_level_dn" if self.white_level_dn else "2**bit_depth - 1"
            raise ValueError(
                f"black_level_dn is {self.black_level_dn:g}, which is not below the white level of "
                f"{self.white:g} DN ({origin})"
            )
        Lens(self.projection, self.lens_coefficients)
        if self.cfa is not None and self.channels != 1:
            raise ValueError(f"cfa is {self.cfa}, and a mosaic has 1 channel, not {self.channels}")
        return self

    @property
    def white(self) -> float:
        return self.white_level_dn or 2.0**self.bit_depth - 1


class NoiseEntry(Settings):
    """The simulator's affine noise at a gain, before rounding and clipping."""

    photon_dn: PerChannel = setting(
        help="Variance per DN of signal above the pedestal; one, or one per channel.", unit="DN"
    )
    thermal_dn2: PerChannel = setting(help="Variance at no signal; one, or one per channel.", unit="DN^2")
    gain_db: float = setting(
        0.0, help="The gain it holds at.", unit="dB", ge=-200, le=200, also=ALSO_CALLED["gain_db"]
    )


class BoardEntry(Settings):
    """A flat target with a known pattern."""

    pattern: Literal["chessboard", "charuco", "circles", "asymmetric_circles"] = setting(
        "chessboard", help="Its pattern, as OpenCV names them. Of a charuco parts may be seen."
    )
    inner_corners: tuple[Corners, Corners] = setting(
        help="Inner corners along its rows and columns, or circles."
    )
    square_mm: float = setting(
        help="Side of its squares, or from circle to circle (asymmetric: along a row).",
        unit="mm",
        gt=0,
        le=1e5,
    )
    marker_mm: float | None = setting(None, help="Side of the markers of a charuco.", unit="mm", gt=0)
    dictionary: Annotated[str, Field(pattern=DICTIONARIES)] = setting(
        "DICT_4X4_50", help="OpenCV's dictionary of the markers of a charuco."
    )

    @model_validator(mode="after")
    def _markers_fit(self) -> BoardEntry:
        if self.pattern == "charuco" and not (self.marker_mm and self.marker_mm < self.square_mm):
            raise ValueError("a charuco needs marker_mm, below square_mm")
        return self


class EdgeEntry(Settings):
    """A straight slanted edge."""

    angle_deg: float = setting(help="Angle to the nearest image axis.", unit="deg", ge=-45, le=45)


class ChartEntry(Settings):
    """A colour chart."""

    patches: str = setting(help="CSV with id, x, y, width, height [px], r, g, b [linear DN].")


class ObjectsEntry(Settings):
    """Labelled objects of a still, for tasks that find things."""

    ids: str = setting(
        help="Image or .npy of whole numbers: the object each pixel shows, 0 for the background, 1 for the "
        "first of `classes`."
    )
    classes: tuple[str, ...] = setting(
        help="Class of each object, as tasks name it, e.g. chair.", min_length=1
    )


class CaptureEntry(Settings):
    """One capture: frames taken with the same settings, or the frames of a sequence."""

    id: str = setting(help="Its name.", min_length=1, max_length=200)
    kind: Kind = setting(help="Its subject.")
    real: Files = setting(help="Files of the frames, or a glob.")
    simulated: FilesOrLevel | None = setting(
        None, help="Expected file values without noise: a file, one per frame, or a number.", unit="DN"
    )
    scene: str | None = setting(None, help="A recipe that renders the expected values.")
    exposure_ms: float | None = setting(
        None, help="Exposure time.", unit="ms", gt=0, le=1e9, also=ALSO_CALLED["exposure_ms"]
    )
    gain_db: float = setting(0.0, help="Gain.", unit="dB", ge=-200, le=200, also=ALSO_CALLED["gain_db"])
    group: str | None = setting(None, help="Captures of one group differ in exposure_ms only.")
    level_uncertainty: float = setting(
        0.0,
        help="Equivalence margin of the level of light: within it a relative difference is no error.",
        ge=0,
        le=1,
    )
    mask: str | None = setting(None, help="Image, 0 where `simulated` says nothing.")
    simulated_frames: int | None = setting(None, help="Noisy frames that `simulated` is the mean of.", ge=1)
    width_px: Size | None = setting(None, help="Width of the files, where it is not the camera's.", unit="px")
    height_px: Size | None = setting(None, help="Height of the files.", unit="px")
    crop: CropEntry | None = setting(None, help="Place of the files on the sensor.")
    board: BoardEntry | None = setting(None, help="The board, for kind board.")
    edge: EdgeEntry | None = setting(None, help="The edge; without it, edges of any direction.")
    chart: ChartEntry | None = setting(None, help="The patches of a chart.")
    depth: str | None = setting(None, help="Depth along the optical axis, .npy.", unit="m")
    objects: ObjectsEntry | None = setting(None, help="Labelled objects, for tasks that find things.")
    velocity_px_s: Velocity | None = setting(
        None, help="Motion in the image, or a .npy of (height, width, 2).", unit="px/s"
    )
    frame_interval_ms: float | None = setting(
        None, help="From frame to frame.", unit="ms", gt=0, le=1e9, also=("fps",)
    )
    row_time_us: float = setting(
        0.0, help="Readout from row to row the simulator has.", unit="us", ge=0, le=1e9
    )
    row_time_reference: Place = setting(0.0, help="Row that shares its moment with `simulated`.", unit="px")
    motion_blurred: bool = setting(False, help="`simulated` includes the blur of motion during the exposure.")
    taken_s: Moment | None = setting(
        None, help="Time of the picture, from any moment on: captures stand in this order.", unit="s"
    )


NoiseEntries = Annotated[
    Annotated[Literal["unknown"], Tag("<text>")]
    | Annotated[NoiseEntry, Tag("<keys>")]
    | Annotated[tuple[NoiseEntry, ...], Tag("<list>")],
    told_apart("unknown, {photon_dn: 0.06, thermal_dn2: 4}, or a list of such, one for each gain_db"),
]


class FolderEntry(Settings):
    """``captures.yaml``."""

    tacos_captures: Literal[1] = setting(help="Format of the file.")
    camera: CaptureCamera = setting(help="The simulator's description of the camera.")
    noise: NoiseEntries = setting("unknown", help="The simulator's noise, or unknown.")
    captures: tuple[CaptureEntry, ...] = setting(help="The captures, one at least.")
