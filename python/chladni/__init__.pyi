from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

FrfKind: TypeAlias = Literal["receptance", "mobility", "accelerance"]
Unit: TypeAlias = Literal["N", "V"]
DampingLaw: TypeAlias = Literal["structural", "viscous"]
RfpWeight: TypeAlias = Literal["linear", "sk", "iv", "gn"]
FitMethod: TypeAlias = Literal["auto", "lean", "vf", "lscf", "plscf", "aaa", "rfp", "grfp", "peak", "circle"]
RenderMethod: TypeAlias = Literal[
    "default",
    "fast",
    "best",
    "pressure-matching",
    "mls",
    "robust",
    "min-effort",
    "modal",
    "tikhonov",
    "tsvd",
    "contrast-control",
    "vast",
    "time-reversal",
]
ShapeModel: TypeAlias = Literal["auto", "free", "rank1", "real"]
Progress: TypeAlias = bool | Callable[[str], object] | None
Scene: TypeAlias = str | PathLike[str] | dict[str, Any]
Mask: TypeAlias = NDArray[np.bool_] | Sequence[bool]

class ChladniError(ValueError):
    code: int
    kind: str
    file: str | None
    dataset: int | None
    line: int | None
    byte: int | None
    field: str | None
    found: str | None
    expected: str | None
    help: str | None

class FrfSet:
    """
    FRFs of a structure in SI units of the kind, per N or V.

    With a driving point (a reference that is also a response), shapes are scaled to unit modal
    mass. A set pickles.

    Parameters
    ----------
    frequency_hz : array_like of float, shape (line,)
        Lines, Hz.
    values : array_like of complex, shape (response, reference, line)
        The FRFs; complex64 stays what it is, in the byte order of the machine.
    responses, references : list of str, optional
        Names such as ``"12:+Z"`` (node 12, +Z); without them responses are nodes 1, 2, ...
        and references the nodes after those.
    kind : {"mobility", "receptance", "accelerance"}
        What they are.
    reference_unit : {"N", "V"}
        Unit of the references.
    nodes_m : array_like of float, shape (node, 3), optional
        Positions of nodes 1, 2, ..., m.
    """
    def __init__(
        self,
        frequency_hz: ArrayLike,
        values: ArrayLike,
        *,
        responses: Sequence[str] | None = None,
        references: Sequence[str] | None = None,
        kind: FrfKind = "mobility",
        reference_unit: Unit = "N",
        nodes_m: ArrayLike | None = None,
    ) -> None: ...
    @property
    def frequency_hz(self) -> NDArray[np.float64]:
        """Lines, Hz: (line,)."""
    @property
    def values(self) -> NDArray[np.complex128] | NDArray[np.complex64]:
        """
        FRFs without a copy, read-only: (response, reference, line), complex128 or
        complex64.
        """
    @property
    def responses(self) -> list[str]:
        """Names of the response DOFs."""
    @property
    def references(self) -> list[str]:
        """Names of the reference DOFs."""
    @property
    def kind(self) -> FrfKind | None:
        """receptance, mobility or accelerance; None where the file does not say."""
    @property
    def reference_unit(self) -> Unit:
        """Unit of the references, N or V."""
    @property
    def nodes_m(self) -> NDArray[np.float64]:
        """Positions of the nodes, m: (node, 3)."""
    @property
    def warnings(self) -> list[str]:
        """The sentences of cautions and faults about the files."""
    @property
    def findings(self) -> list[dict[str, Any]]:
        """
        All findings: dictionaries with code, severity, modes, dofs, values, text and help. Modes
        are counted from 1, as in the table of modes; arrays and `select` count from 0.
        """
    def save(self, path: str | PathLike[str], *, force: bool = False) -> list[str]:
        """
        Writes the set; the format follows from the name (.h5, .uff, .unv, .csv, .npz).

        Parameters
        ----------
        path : path
            File to write.
        force : bool
            Overwrite it.

        Returns
        -------
        list of str
            What the format cannot hold.
        """

class Model:
    """
    A modal model. Arrays hold the modes of the band (sure and weak) by rising frequency;
    to_dict() holds all.
    """
    @property
    def frequency_hz(self) -> NDArray[np.float64]:
        """Undamped natural frequencies, Hz: (mode,)."""
    @property
    def frequency_std_hz(self) -> NDArray[np.float64]:
        """Their standard deviations, Hz: (mode,)."""
    @property
    def loss_factor(self) -> NDArray[np.float64]:
        """Loss factors: (mode,)."""
    @property
    def loss_factor_std(self) -> NDArray[np.float64]:
        """Their standard deviations: (mode,)."""
    @property
    def damping_ratio(self) -> NDArray[np.float64]:
        """Damping ratios, half the loss factors: (mode,)."""
    @property
    def nat_freq(self) -> NDArray[np.float64]:
        """Natural frequencies, Hz (SDyPy-EMA's name)."""
    @property
    def nat_xi(self) -> NDArray[np.float64]:
        """Damping ratios (SDyPy-EMA's name)."""
    @property
    def shapes(self) -> NDArray[np.complex128]:
        """Mode shapes: (mode, response)."""
    @property
    def shapes_std(self) -> NDArray[np.float64]:
        """Standard deviations of the shapes: (mode, response)."""
    @property
    def participations(self) -> NDArray[np.complex128]:
        """Participations: (mode, reference)."""
    @property
    def trust(self) -> list[Literal["sure", "weak"]]:
        """"sure" or "weak" of each mode."""
    @property
    def reasons(self) -> list[list[str]]:
        """Reasons that a mode is not sure, a list for each mode."""
    @property
    def poles(self) -> NDArray[np.complex128]:
        """Poles of the viscous law with these frequencies and damping ratios, rad/s: (mode,)."""
    @property
    def A(self) -> NDArray[np.complex128]:
        """Residues of the first reference, receptance, (response, mode): SDyPy-EMA's A."""
    @property
    def band_hz(self) -> tuple[float, float]:
        """Fitted band, Hz."""
    @property
    def kind(self) -> FrfKind:
        """receptance, mobility or accelerance: the kind of the FRFs that were fitted."""
    @property
    def reference_unit(self) -> Unit:
        """Unit of the references, N or V."""
    @property
    def scaling(self) -> Literal["unit_modal_mass", "unscaled"]:
        """unit_modal_mass where a driving point or the panel set the scale, else unscaled."""
    @property
    def points_m(self) -> NDArray[np.float64]:
        """Positions of the responses, m, NaN where they are not known: (response, 3)."""
    @property
    def trusted(self) -> bool:
        """False where no mode is sure, or the data as a whole contradict the model."""
    @property
    def relative_error(self) -> float:
        """Rms residual over rms data."""
    @property
    def chi2_per_dof(self) -> float:
        """χ² per degree of freedom."""
    @property
    def damping(self) -> DampingLaw:
        """structural or viscous."""
    @property
    def warnings(self) -> list[str]:
        """The sentences of cautions and faults."""
    @property
    def findings(self) -> list[dict[str, Any]]:
        """
        All findings: dictionaries with code, severity, modes, dofs, values, text and help. Modes
        are counted from 1, as in the table of modes; arrays and `select` count from 0.
        """
    @property
    def responses(self) -> list[str]:
        """Names of the response DOFs."""
    @property
    def references(self) -> list[str]:
        """Names of the reference DOFs."""
    def synthesise(self, frequency_hz: ArrayLike) -> NDArray[np.complex128]:
        """
        FRFs of the model, in the kind that it was fitted in.

        Parameters
        ----------
        frequency_hz : array_like of float, shape (line,)
            Lines, Hz.

        Returns
        -------
        ndarray of complex128, shape (response, reference, line)
            NaN at 0 Hz where the model moves as a rigid body, too.
        """
    def FRF_reconstruct(self, frequency_hz: ArrayLike) -> NDArray[np.complex128]:
        """FRFs of the model on the lines given: the name that users of SDyPy-EMA know for `synthesise`."""
    def mac(self, other: Model | None = None) -> NDArray[np.float64]:
        """
        MAC between the shapes of this model and of another at the DOFs that both have, paired by
        name.

        Parameters
        ----------
        other : Model, optional
            This model itself without one.

        Returns
        -------
        ndarray of float64, shape (mode, mode of the other)
        """
    def get_poles(self) -> NDArray[np.complex128]:
        """Poles, rad/s: the name that users of SDyPy-EMA know for `poles`, which are found by `fit` already."""
    def to_dataframe(self) -> Any:
        """A pandas DataFrame with a row for each mode of the band."""
    def plot_frf(
        self,
        response: int | str = 0,
        reference: int | str = 0,
        *,
        frf: FrfSet | None = None,
        frequency_hz: NDArray[np.float64] | Sequence[float] | None = None,
        ax: Any = None,
    ) -> Any:
        """
        Amplitude of one FRF of the model, and of the measured one where `frf` is given.

        Parameters
        ----------
        response, reference : int or str
            Place (from the end where negative) or name of the DOFs, such as ``"12:+Z"``.
        frf : FrfSet, optional
            The measured FRFs, drawn below the model's, in the kind of the model.
        frequency_hz : array_like, optional
            Lines, Hz; those of `frf`, or 2000 over the band.
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure without it.

        Returns
        -------
        matplotlib.axes.Axes
        """
    def plot_shape(self, mode: int = 0, *, ax: Any = None) -> Any:
        """
        Real part of a mode shape over the plane of the responses, turned to its largest value.

        Parameters
        ----------
        mode : int
            Place of the mode, from 0; from the end where negative.
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure without it.

        Returns
        -------
        matplotlib.axes.Axes
        """
    def autoMAC(self) -> NDArray[np.float64]:
        """MAC of the shapes with each other: the name that users of SDyPy-EMA know for `mac()`."""
    def to_json(self) -> str:
        """The model file's text."""
    def to_dict(self) -> dict[str, Any]:
        """Everything the file holds, as a dictionary."""
    def save(self, path: str | PathLike[str], *, force: bool = False) -> None:
        """
        Writes the model.

        Parameters
        ----------
        path : path
            .json or .h5.
        force : bool
            Overwrite it.
        """
    def __len__(self) -> int: ...

class Comparison:
    mac: NDArray[np.float64]
    mac_std: NDArray[np.float64]
    mac_noise_bias: NDArray[np.float64]
    pairs: NDArray[np.int_]
    frequency_shift_hz: NDArray[np.float64]
    frequency_shift_sigmas: NDArray[np.float64]
    loss_factor_shift: NDArray[np.float64]
    loss_factor_shift_sigmas: NDArray[np.float64]
    only_in_a: NDArray[np.int_]
    only_in_b: NDArray[np.int_]
    paired_by: Literal["name", "nearest"]
    common_dofs: int
    largest_distance_m: float | None
    warnings: list[str]
    def to_dict(self) -> dict[str, Any]: ...
    def to_dataframe(self) -> Any: ...

class Partial:
    """
    The products of one or more blocks of FRFs after a pass over them: a few megabytes
    whatever the size of the blocks. Made by `reduce_block` and `merge`; pickles.
    """
    @property
    def frfs(self) -> int:
        """Number of FRFs in its blocks."""
    @property
    def blocks(self) -> int:
        """Number of its blocks."""
    @property
    def poles(self) -> Poles | None:
        """Poles of the pass; None: of the first pass."""
    def to_bytes(self) -> bytes:
        """
        The bytes of a partial file: the same blocks give the same bytes, whoever reduced
        and merged them in whatever order.
        """
    @classmethod
    def from_bytes(cls, data: bytes | bytearray) -> Partial:
        """
        Reads the bytes of `to_bytes`; refuses another version and damaged ones.

        Parameters
        ----------
        data : bytes
            What `to_bytes` gave.
        """
    def __contains__(self, number: int) -> bool: ...

class Poles:
    """
    Poles to run the second pass with. Arrays hold those of the band by rising frequency,
    as far as the first pass tells them. Made by `solve_poles`; pickles.
    """
    @property
    def frequency_hz(self) -> NDArray[np.float64]:
        """Undamped natural frequencies, Hz: (mode,)."""
    @property
    def loss_factor(self) -> NDArray[np.float64]:
        """Loss factors: (mode,)."""
    @property
    def evidence(self) -> str:
        """The way they were found, in words."""
    def to_bytes(self) -> bytes:
        """The bytes of a poles file."""
    @classmethod
    def from_bytes(cls, data: bytes | bytearray) -> Poles:
        """
        Reads the bytes of `to_bytes`; refuses another version and damaged ones.

        Parameters
        ----------
        data : bytes
            What `to_bytes` gave.
        """

class Rendering:
    """Actuator weights for a scene, and how they do in the model."""
    @property
    def points_m(self) -> NDArray[np.float64]:
        """Place of each response, m: (response, 2)."""
    @property
    def other_tones(self) -> list[Rendering]:
        """The same for what sounds with it at other frequencies."""
    def plot_field(self, *, ax: Any = None) -> Any:
        """
        Velocity amplitude at the responses, mm/s peak, that a drive makes in the model.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure without it.

        Returns
        -------
        matplotlib.axes.Axes
        """
    @property
    def weights(self) -> NDArray[np.complex128]:
        """Peak phasors of the weights in N or V: (actuator,)."""
    @property
    def references(self) -> list[str]:
        """Names of the actuators, as the weights."""
    @property
    def frequency_hz(self) -> float:
        """Drive frequency, Hz."""
    @property
    def velocity_m_per_s(self) -> NDArray[np.complex128]:
        """Velocities along +Z in the model, m/s, peak phasors: (response,)."""
    @property
    def responses(self) -> list[str]:
        """Names of the responses, as the velocities."""
    @property
    def method(self) -> str:
        """The method that ran."""
    @property
    def feasible(self) -> bool:
        """True where every judged response keeps its limit within the force limits."""
    @property
    def kappa(self) -> float | None:
        """
        Model errors, in standard deviations, under which every judged response keeps its
        limit.
        """
    @property
    def warnings(self) -> list[str]:
        """The sentences of cautions and faults."""
    @property
    def findings(self) -> list[dict[str, Any]]:
        """
        All findings: dictionaries with code, severity, modes, dofs, values, text and help. Modes
        are counted from 1, as in the table of modes; arrays and `select` count from 0.
        """
    def to_json(self) -> str:
        """The weights file's text."""
    def to_dict(self) -> dict[str, Any]:
        """Everything the file holds, as a dictionary."""
    def save(self, path: str | PathLike[str], *, force: bool = False) -> None:
        """
        Writes the weights file.

        Parameters
        ----------
        path : path
            .json.
        force : bool
            Overwrite it.
        """

def read(
    paths: str | PathLike[str] | Sequence[str | PathLike[str]],
    *,
    frf_kind: FrfKind | None = None,
    time_sign: Literal["+", "-"] = "+",
    delay_s: float = 0.0,
    reference: int | Sequence[int] | None = None,
    response: int | Sequence[int] | None = None,
    dofs: str | PathLike[str] | Sequence[tuple[str, str] | tuple[str, str, str]] | None = None,
    map: Mapping[str, str] | None = None,
    duplicates: Literal["error", "first", "last", "mean"] = "error",
    phase_unit: Literal["deg", "rad"] | None = None,
    snap_df: bool = False,
    lenient: bool = False,
) -> FrfSet: ...
def simulate(
    panel: str | PathLike[str], *, snr_db: float | None = None, seed: int | None = None, memory_bytes: int = ...
) -> tuple[FrfSet, Model]: ...
def fit(
    frf: FrfSet,
    *,
    band: Sequence[float] | None = None,
    modes: int | None = None,
    damping: DampingLaw | None = None,
    method: FitMethod = "auto",
    shapes: ShapeModel = "auto",
    window: str | None = None,
    exponential_window_per_s: float | None = None,
    rfp_weight: RfpWeight | None = None,
    rfp_bands: int | None = None,
    rfp_local: bool = False,
    seed: int = 0,
    progress: Progress = None,
) -> Model: ...
def reduce_block(
    frf: FrfSet,
    number: int,
    *,
    poles: Poles | None = None,
    band: Sequence[float] | None = None,
    window: str | None = None,
    seed: int | None = None,
    blocks: int | None = None,
) -> Partial: ...
def merge(partials: Iterable[Partial]) -> Partial: ...
def solve_poles(
    partial: Partial,
    *,
    modes: int | None = None,
    damping: DampingLaw | None = None,
    shapes: ShapeModel = "auto",
    exponential_window_per_s: float | None = None,
    progress: Progress = None,
) -> Poles | Model: ...
def residues_block(frf: FrfSet, model: Model, *, window: str | None = None) -> Model: ...
def compare(
    a: Model | str | PathLike[str],
    b: Model | str | PathLike[str],
    *,
    pair_dofs: Literal["auto", "name", "nearest"] = "auto",
    least_mac: float = 0.5,
) -> Comparison: ...
def estimate(
    references: ArrayLike,
    responses: ArrayLike,
    sample_rate_hz: float,
    *,
    reference_names: Sequence[str] | None = None,
    response_names: Sequence[str] | None = None,
    kind: FrfKind = "mobility",
    reference_unit: Unit = "N",
    estimator: Literal["lrm", "lpm", "h1", "h2", "hv"] | None = None,
    window: Literal["hann", "rectangular", "exponential"] | None = None,
    exponential_window_per_s: float | None = None,
    block: int | None = None,
    overlap: float | None = None,
) -> FrfSet: ...
def select(
    model: Model,
    *,
    keep: Sequence[int] | NDArray[np.integer[Any]] | NDArray[np.bool_] | None = None,
    drop: Sequence[int] | NDArray[np.integer[Any]] | NDArray[np.bool_] | None = None,
    near_hz: Sequence[float] = (),
    within_hz: float = 0.5,
    add: Sequence[float] = (),
    frf: FrfSet | None = None,
) -> Model: ...
def cmif(frf: FrfSet) -> NDArray[np.float64]: ...
def stabilization(frf: FrfSet, *, band: Sequence[float] | None = None) -> dict[str, NDArray[Any]]: ...
def report(
    path: str | PathLike[str],
    model: Model,
    *,
    measured: FrfSet | None = None,
    renderings: Sequence[Rendering] = (),
    title: str = "Chladni",
    force: bool = False,
) -> None: ...
def scene(
    model: Model, frequency_hz: float | Sequence[float | Sequence[float]], hot: Mask, *, cold: Mask | None = None, **tables: Any
) -> dict[str, Any]: ...
def scene_to_toml(scene: dict[str, Any]) -> str: ...
def load_model(path: str | PathLike[str]) -> Model: ...
def render(
    model: Model,
    scene: Scene,
    *,
    method: RenderMethod = "default",
    modes: int | str = "all",
    actuators: int | str = "all",
    measured: FrfSet | None = None,
) -> Rendering: ...
class Playing:
    """A drive over time, and how it does in the model."""
    feasible: bool
    warnings: list[str]
    length_s: float
    references: list[str]
    time_s: NDArray[np.float64]
    hot_db: NDArray[np.float64]
    cold_db: NDArray[np.float64]
    largest_drive: NDArray[np.float64]
    indices: dict[str, Any]
    def drive(
        self,
        rate_hz: int = 48_000,
        *,
        full_scale: float | None = None,
        channel_map: Sequence[tuple[int, str, float]] | None = None,
    ) -> NDArray[np.float64]:
        """
        The drive of each channel.

        Parameters
        ----------
        rate_hz : int
            Frames per second.
        full_scale : float, optional
            Largest value, N or V.
        channel_map : sequence of (int, str, float), optional
            Rows (channel, reference, gain).

        Returns
        -------
        ndarray of float64, shape (frame, channel)
            N or V.
        """
    def save(
        self,
        path: str | PathLike[str],
        rate_hz: int = 48_000,
        *,
        format: Literal["f32", "i24", "i16"] = "f32",
        full_scale: float | None = None,
        channel_map: Sequence[tuple[int, str, float]] | None = None,
        force: bool = False,
    ) -> None:
        """
        Writes what a rig plays: .wav with a .json beside it (both or none), .csv or .npz.

        Parameters
        ----------
        path : path
            File to write.
        rate_hz : int
            Frames per second.
        format : {"f32", "i24", "i16"}
            Samples of a sound file.
        full_scale : float, optional
            What a sample of 1 means, N or V; without it the smallest round number above the peak.
        channel_map : sequence of (int, str, float), optional
            Rows (channel, reference, gain).
        force : bool
            Overwrite the files.
        """

def play(
    model: Model,
    scene: Scene,
    *,
    rendering: Rendering | None = None,
    ramps: Literal["modal", "plain", "program"] | None = None,
    method: RenderMethod = "default",
) -> Playing: ...
def correct(
    model: Model,
    scene: Scene,
    weights: str | PathLike[str] | Sequence[str | PathLike[str]],
    fields: str | PathLike[str] | Sequence[str | PathLike[str]],
    *,
    output: str | PathLike[str] | None = None,
    calibration: str | PathLike[str] | None = None,
    force: bool = False,
) -> dict[str, Any]: ...
def evaluate(rendering: Rendering, scene: Scene, on: FrfSet | Model) -> dict[str, Any]: ...
