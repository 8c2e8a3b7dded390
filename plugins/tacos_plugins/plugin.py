"""Lists the default components. Light: names code by string and imports none of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from tacos_framework import Command, Component, EnvironmentFinding, Gpu, hookimpl
from tacos_plugins.authoring import commands as authoring
from tacos_plugins.kept_worlds import commands as kept_worlds

RIGS = {
    "monocular": ("monocular:MonocularRig", "One camera, pitched up or down, with a sensor from a catalog."),
    "stereo": ("stereo:StereoRig", "Two parallel cameras a baseline apart."),
    "ring": ("ring:RingRig", "Equal cameras evenly around the agent, as many as are wanted."),
    "front-back-sides": (
        "front_back_sides:FrontBackSidesRig",
        "A camera ahead, and others behind and to the sides where they are wanted.",
    ),
}

RENDERERS = {
    "moderngl": (
        "moderngl.renderer:ModernglRenderer",
        "Headless OpenGL rasterizer: physically based light, exact depth and ids.",
    ),
    "analytic": (
        "analytic:AnalyticRenderer",
        "Small ray caster without OpenGL, for tests and machines without it.",
    ),
    "mitsuba": (
        "mitsuba.renderer:MitsubaRenderer",
        "Path tracing with Mitsuba 3: slow, the reference the rasterizer is compared with.",
        "mitsuba=tacos-framework[mitsuba]",
    ),
    "blender": (
        "blender.renderer:BlenderRenderer",
        "Path tracing with Blender's Cycles: slow, for a last test of the highest realism.",
        "bpy=tacos-framework[blender]",
    ),
}

EFFECTS = {
    "pose-error": (
        "pose_error:PoseError",
        "A rotation and a shift of the camera from its pose in the simulation.",
    ),
    "illumination-gradient": (
        "illumination_gradient:IlluminationGradient",
        "Uneven light on the scene: a plane over the image.",
    ),
    "focal-length-error": (
        "focal_length_error:FocalLengthError",
        "A focal length and principal point other than those of the simulation.",
    ),
    "lens-distortion": (
        "lens_distortion:LensDistortion",
        "Bent straight lines: OpenCV's Brown-Conrady or fisheye model.",
    ),
    "lateral-chromatic-aberration": (
        "lateral_chromatic_aberration:LateralChromaticAberration",
        "Red and blue magnified against green: colour fringes that grow outwards.",
    ),
    "defocus": (
        "defocus:Defocus",
        "Light spread over a disc: everywhere alike, or by focus, f-number and depth.",
    ),
    "lens": (
        "lens:Lens",
        "Diffraction, depth of field and fall-off, by focal length, projection and f-number.",
    ),
    "lens-blur": ("lens_blur:LensBlur", "A Gaussian that grows over the field, diffraction, or both."),
    "veiling-glare": ("veiling_glare:VeilingGlare", "A share of the light strays over the image."),
    "vignetting": (
        "vignetting:Vignetting",
        "Light that falls off towards the corners: an even polynomial of the radius.",
    ),
    "motion": (
        "motion:Motion",
        "Blur and rolling shutter from the motion of the agent and of objects.",
    ),
    "rolling-shutter": (
        "rolling_shutter:RollingShutter",
        "Rows exposed one after another: what moves is sheared.",
    ),
    "motion-blur": (
        "motion_blur:MotionBlur",
        "Light smeared along a straight line while the shutter is open.",
    ),
    "exposure-error": ("exposure_error:ExposureError", "More or less light than the exposure settings say."),
    "flicker": ("flicker:Flicker", "Lamps on alternating current: a wave of light over the rows."),
    "auto-exposure": (
        "auto_exposure:AutoExposure",
        "Metering: exposes to a target mean or evens out changes, within limits, with a lag.",
    ),
    "conversion-gain-error": (
        "conversion_gain_error:ConversionGainError",
        "Another slope of the photon-transfer curve: more or fewer electrons per digital number.",
    ),
    "conversion-gain-mode": (
        "conversion_gain_mode:ConversionGainMode",
        "A second conversion gain from some gain on, with other noise in the dark.",
    ),
    "prnu": ("prnu:Prnu", "Photosites that respond more or less than others, a pattern fixed to the sensor."),
    "dsnu": ("dsnu:Dsnu", "Photosites and columns with offsets of their own, a pattern fixed to the sensor."),
    "defect-lines": (
        "defect_lines:DefectLines",
        "Single rows and columns that are offset or dead, in every frame.",
    ),
    "dark-current": (
        "dark_current:DarkCurrent",
        "Charge that gathers over the exposure without light, and hot pixels.",
    ),
    "saturation": (
        "saturation:Saturation",
        "Noisy samples cut off at a level below full scale: the full well.",
    ),
    "crosstalk": ("crosstalk:Crosstalk", "Noisy samples shared with their neighbours; correlates noise."),
    "nonlinearity": (
        "nonlinearity:Nonlinearity",
        "A response that bends: a polynomial of the signal over full scale.",
    ),
    "read-noise": ("read_noise:ReadNoise", "Further noise in the dark, Gaussian or with heavier tails."),
    "row-noise": ("row_noise:RowNoise", "Rows and columns that jump from frame to frame."),
    "black-level": ("black_level:BlackLevel", "A pedestal other than that of the simulation."),
    "quantisation": (
        "quantisation:Quantisation",
        "A converter with coarser steps than the file, or one that rounds down.",
    ),
    "lens-shading-correction": (
        "lens_shading_correction:LensShadingCorrection",
        "Corners lifted after the noise: a gain map of the radius.",
    ),
    "white-balance": ("white_balance:WhiteBalance", "Gains on red and blue."),
    "auto-white-balance": (
        "auto_white_balance:AutoWhiteBalance",
        "Gains on red and blue that are still settling as an episode begins.",
    ),
    "colour-matrix": (
        "colour_matrix:ColourMatrix",
        "Colours mixed from one another; correlates the noise of channels.",
    ),
    "demosaic": ("demosaic:Demosaic", "Colour sampled through a Bayer mosaic and reconstructed."),
    "denoise": ("denoise:Denoise", "Adaptive Wiener filter: flat parts lose their noise, edges stay."),
    "sharpening": ("sharpening:Sharpening", "Unsharp mask: overdrawn edges and stronger noise."),
    "tone-curve": (
        "tone_curve:ToneCurve",
        "A curve between signal and code: a power, or monotone through knots.",
    ),
    "jpeg": ("jpeg:Jpeg", "Frames coded as JPEG and decoded."),
}

SENSORS = {
    "camera": (
        "camera:CameraSensor",
        "Electrons with noise before and after the gain; unpublished figures from stated priors.",
    ),
    "affine-noise": ("affine_noise:AffineNoise", "Photon and thermal noise, scaled by gain and pixel area."),
    "emva": (
        "emva:Emva",
        "Electrons as in EMVA 1288: quantum efficiency, full well, read and dark noise, system gain.",
    ),
}

CONTROLS = {
    "mean-level": (
        "mean_level:MeanLevel",
        "Exposure time, then gain, by the mean level of the frames before, with a lag.",
    ),
    "gradient": (
        "gradient:Gradient",
        "Exposure time, then gain, towards the image with most gradients (Shim et al. 2014).",
    ),
}

TASKS = {
    "orb-features": (
        "orb_features:OrbFeatures",
        "ORB features matched over consecutive frames; counts RANSAC inliers.",
    ),
    "visual-odometry": (
        "visual_odometry.task:VisualOdometry",
        "The camera's motion from its images, one camera or a stereo pair, against the known poses.",
    ),
    "fiducials": (
        "fiducials.task:Fiducials",
        "AprilTag and ArUco markers: from how far they are read, and how right they are placed.",
    ),
    "obstacle-visibility": (
        "obstacle_visibility:ObstacleVisibility",
        "Share of thresholds on the path that were seen before they were stepped on, and how early.",
    ),
    "surround-coverage": (
        "surround_coverage:SurroundCoverage",
        "What all cameras of a rig have in view around the agent: directions, and things well seen.",
    ),
    "sgbm": ("sgbm:Sgbm", "Depth from stereo by OpenCV's semi-global matcher, untrained."),
    "psmnet": (
        "psmnet.task:PsmnetDepth",
        "Depth from stereo by the network PSMNet, trained with the cameras.",
        "torch=tacos-framework[perception]",
    ),
    "faster-rcnn": (
        "faster_rcnn.task:FasterRcnn",
        "Object detector (Faster R-CNN), trained with the camera; average precision.",
        "torch=tacos-framework[perception]",
        "torchvision=tacos-framework[perception]",
        "pycocotools=tacos-framework[perception]",
    ),
}

OPTIMIZERS = {
    "genetic": (
        "genetic:Genetic",
        "The paper's genetic algorithm: elites, uniform crossover, factor and offset mutation.",
    ),
    "physical-gp": (
        "physical_gp.optimizer:PhysicalGp",
        "Gaussian processes of the scores along physical coordinates: few images for a good camera.",
    ),
    "random": ("random_search:RandomSearch", "Independent uniform draws: the baseline any search must beat."),
    "sobol": ("sobol:Sobol", "Scrambled Sobol points: covers the space more evenly than random draws."),
    "cma-es": ("cma_es:CmaEs", "Covariance matrix adaptation with restarts, on snapped candidates.", "cma"),
    "optuna": (
        "optuna_search:OptunaSearch",
        "Optuna's samplers: Parzen estimators (tpe) and Gaussian processes (gp).",
        "optuna",
    ),
    "ppo": (
        "policy.ppo:Ppo",
        "The published reinforcement learning: a policy network that changes cameras step by step.",
        "stable_baselines3=tacos-framework[rl]",
    ),
}

EXECUTORS = {
    "local": ("local:LocalExecutor", "Evaluates candidates one after another in this process."),
    "process": ("process:ProcessExecutor", "Evaluates candidates in spawned processes, one GL context each."),
    "ray": (
        "on_ray.executor:RayExecutor",
        "Evaluates candidates on a Ray cluster, of this machine or of many, with shares of GPUs.",
        "ray=tacos-framework[ray]",
    ),
}

PROCEDURES = {
    "pretrain": (
        "pretraining.pretrain:Pretrain",
        "A task that learns, trained on images of our own scenes: weights for studies to start with.",
    ),
    "calibrate-noise": (
        "noise_calibration.calibrate:CalibrateNoise",
        "From frames of grey bars to an affine noise calibration with confidence intervals.",
    ),
    "calibrate-camera": (
        "emva_calibration.calibrate:CalibrateCamera",
        "A camera's data sheet by EMVA 1288 from frames of even light and of darkness.",
    ),
}

TRANSFORMS = {"resize": ("resize:Resize", "Smaller images, each pixel the mean of the area that it covers.")}

FAMILIES: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "rig": RIGS,
    "renderer": RENDERERS,
    "effect": EFFECTS,
    "sensor": SENSORS,
    "transform": TRANSFORMS,
    "control": CONTROLS,
    "task": TASKS,
    "optimizer": OPTIMIZERS,
    "executor": EXECUTORS,
}
"""Kind -> name -> module and class within the family's folder, summary, and packages it needs."""

DEFAULT_FOR = {"executor.local": ("executor",), "executor.process": ("workers",)}
"""Thing not named in a recipe or on the command line -> the component that stands for it."""


@hookimpl
def tacos_components() -> list[Component]:
    return list(_components())


def _components() -> Iterator[Component]:
    for kind, family in FAMILIES.items():
        for name, (target, summary, *requires) in family.items():
            yield Component(
                kind,
                name,
                f"tacos_plugins.{kind}s.{target}",
                summary,
                tuple(requires),
                default_for=DEFAULT_FOR.get(f"{kind}.{name}", ()),
            )
    for name, (target, summary) in PROCEDURES.items():
        yield Component("procedure", name, f"tacos_plugins.{target}", summary)


@hookimpl
def tacos_commands() -> list[Command]:
    """Commands to look around and to write plugins, and ``tacos cache``."""
    return [*authoring.commands(), *kept_worlds.commands()]


@hookimpl
def tacos_gpus() -> list[Gpu]:
    """The GPUs that CUDA knows, on which pictures are rendered and networks run."""
    from tacos_plugins.chosen_device import gpus

    return gpus()


@hookimpl
def tacos_episode_stores() -> list[Any]:
    """Worlds on the disk of this machine, unless its user wants none."""
    from tacos_plugins.kept_worlds.episodes import StoredEpisodes
    from tacos_plugins.kept_worlds.store import store_of_user

    store = store_of_user()
    return [] if store is None else [StoredEpisodes(store)]


@hookimpl
def tacos_doctor() -> list[EnvironmentFinding]:
    """Renderer and device of networks here: a GPU, the CPU, or nothing."""
    return [_opengl(), _torch()]


def _opengl() -> EnvironmentFinding:
    from tacos_framework import UserError
    from tacos_plugins.renderers.moderngl.context import describe_gl

    try:
        return EnvironmentFinding("OpenGL", str(describe_gl()))
    except UserError as error:
        (fault,) = error.faults
        return EnvironmentFinding("OpenGL", fault.what, ok=False, remedy=fault.remedy)


def _torch() -> EnvironmentFinding:
    """By torch's metadata: every study asks, and importing torch takes seconds."""
    from importlib.metadata import PackageNotFoundError, version

    from tacos_plugins.chosen_device import gpus

    try:
        found = version("torch")
    except PackageNotFoundError:
        return EnvironmentFinding("torch", "not installed; only tasks that learn need it")
    return EnvironmentFinding("torch", f"{found}, {'cuda' if gpus() and '+cpu' not in found else 'cpu'}")
