from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

__version__: str

FrfKind: TypeAlias = Literal["receptance", "mobility", "accelerance"]
Unit: TypeAlias = Literal["N", "V"]
DampingLaw: TypeAlias = Literal["structural", "viscous"]
RfpWeight: TypeAlias = Literal["linear", "sk", "iv", "gn"]
FitMethod: TypeAlias = Literal["auto", "lean", "vf", "lscf", "plscf", "aaa", "rfp", "grfp", "peak", "circle"]
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
    def __init__(
        self,
        frequency_hz: NDArray[np.float64],
        values: NDArray[np.complex128] | NDArray[np.complex64],
        *,
        responses: Sequence[str] | None = None,
        references: Sequence[str] | None = None,
        kind: FrfKind = "mobility",
        reference_unit: Unit = "N",
        nodes_m: NDArray[np.float64] | None = None,
    ) -> None: ...
    @property
    def frequency_hz(self) -> NDArray[np.float64]: ...
    @property
    def values(self) -> NDArray[np.complex128] | NDArray[np.complex64]: ...
    @property
    def responses(self) -> list[str]: ...
    @property
    def references(self) -> list[str]: ...
    @property
    def kind(self) -> FrfKind | None: ...
    @property
    def reference_unit(self) -> Unit: ...
    @property
    def nodes_m(self) -> NDArray[np.float64]: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def findings(self) -> list[dict[str, Any]]: ...
    def save(self, path: str | PathLike[str], *, force: bool = False) -> list[str]: ...

class Model:
    @property
    def frequency_hz(self) -> NDArray[np.float64]: ...
    @property
    def frequency_std_hz(self) -> NDArray[np.float64]: ...
    @property
    def loss_factor(self) -> NDArray[np.float64]: ...
    @property
    def loss_factor_std(self) -> NDArray[np.float64]: ...
    @property
    def damping_ratio(self) -> NDArray[np.float64]: ...
    @property
    def nat_freq(self) -> NDArray[np.float64]: ...
    @property
    def nat_xi(self) -> NDArray[np.float64]: ...
    @property
    def shapes(self) -> NDArray[np.complex128]: ...
    @property
    def shapes_std(self) -> NDArray[np.float64]: ...
    @property
    def participations(self) -> NDArray[np.complex128]: ...
    @property
    def trust(self) -> list[Literal["sure", "weak"]]: ...
    @property
    def reasons(self) -> list[list[str]]: ...
    @property
    def poles(self) -> NDArray[np.complex128]: ...
    @property
    def A(self) -> NDArray[np.complex128]: ...
    @property
    def band_hz(self) -> tuple[float, float]: ...
    @property
    def kind(self) -> FrfKind: ...
    @property
    def scaling(self) -> Literal["unit_modal_mass", "unscaled"]: ...
    @property
    def points_m(self) -> NDArray[np.float64]: ...
    @property
    def trusted(self) -> bool: ...
    @property
    def relative_error(self) -> float: ...
    @property
    def chi2_per_dof(self) -> float: ...
    @property
    def damping(self) -> DampingLaw: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def findings(self) -> list[dict[str, Any]]: ...
    @property
    def responses(self) -> list[str]: ...
    @property
    def references(self) -> list[str]: ...
    def synthesise(self, frequency_hz: NDArray[np.float64]) -> NDArray[np.complex128]: ...
    def FRF_reconstruct(self, frequency_hz: NDArray[np.float64]) -> NDArray[np.complex128]: ...
    def mac(self, other: Model | None = None) -> NDArray[np.float64]: ...
    def get_poles(self) -> NDArray[np.complex128]: ...
    def to_dataframe(self) -> Any: ...
    def plot_frf(
        self,
        response: int | str = 0,
        reference: int | str = 0,
        *,
        frf: FrfSet | None = None,
        frequency_hz: NDArray[np.float64] | Sequence[float] | None = None,
        ax: Any = None,
    ) -> Any: ...
    def plot_shape(self, mode: int = 0, *, ax: Any = None) -> Any: ...
    def autoMAC(self) -> NDArray[np.float64]: ...
    def to_json(self) -> str: ...
    def to_dict(self) -> dict[str, Any]: ...
    def save(self, path: str | PathLike[str], *, force: bool = False) -> None: ...
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
    @property
    def frfs(self) -> int: ...
    @property
    def blocks(self) -> int: ...
    @property
    def poles(self) -> Poles | None: ...
    def to_bytes(self) -> bytes: ...
    @classmethod
    def from_bytes(cls, data: bytes | bytearray) -> Partial: ...
    def __contains__(self, number: int) -> bool: ...

class Poles:
    @property
    def frequency_hz(self) -> NDArray[np.float64]: ...
    @property
    def loss_factor(self) -> NDArray[np.float64]: ...
    @property
    def evidence(self) -> str: ...
    def to_bytes(self) -> bytes: ...
    @classmethod
    def from_bytes(cls, data: bytes | bytearray) -> Poles: ...

class Rendering:
    @property
    def points_m(self) -> NDArray[np.float64]: ...
    @property
    def other_tones(self) -> list[Rendering]: ...
    def plot_field(self, *, ax: Any = None) -> Any: ...
    @property
    def weights(self) -> NDArray[np.complex128]: ...
    @property
    def references(self) -> list[str]: ...
    @property
    def frequency_hz(self) -> float: ...
    @property
    def velocity_m_per_s(self) -> NDArray[np.complex128]: ...
    @property
    def responses(self) -> list[str]: ...
    @property
    def method(self) -> str: ...
    @property
    def feasible(self) -> bool: ...
    @property
    def kappa(self) -> float | None: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def findings(self) -> list[dict[str, Any]]: ...
    def to_json(self) -> str: ...
    def to_dict(self) -> dict[str, Any]: ...
    def save(self, path: str | PathLike[str], *, force: bool = False) -> None: ...

def read(
    paths: str | PathLike[str] | Sequence[str | PathLike[str]],
    *,
    frf_kind: FrfKind | None = None,
    time_sign: Literal["+", "-"] = "+",
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
    band: tuple[float, float] | None = None,
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
    band: tuple[float, float] | None = None,
    window: str | None = None,
    seed: int | None = None,
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
    references: NDArray[np.float64],
    responses: NDArray[np.float64],
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
    keep: Sequence[int] | None = None,
    drop: Sequence[int] | None = None,
    near_hz: Sequence[float] = (),
    within_hz: float = 0.5,
    add: Sequence[float] = (),
    frf: FrfSet | None = None,
) -> Model: ...
def cmif(frf: FrfSet) -> NDArray[np.float64]: ...
def stabilization(frf: FrfSet, *, band: tuple[float, float] | None = None) -> dict[str, NDArray[Any]]: ...
def report(
    path: str | PathLike[str],
    model: Model,
    *,
    measured: FrfSet | None = None,
    renderings: Sequence[Rendering] = (),
    title: str = "Chladni",
    force: bool = False,
) -> None: ...
def scene(model: Model, frequency_hz: float, hot: Mask, *, cold: Mask | None = None, **tables: Any) -> dict[str, Any]: ...
def scene_to_toml(scene: dict[str, Any]) -> str: ...
def load_model(path: str | PathLike[str]) -> Model: ...
def render(
    model: Model,
    scene: Scene,
    *,
    method: str = "default",
    modes: str = "all",
    actuators: str = "all",
    measured: FrfSet | None = None,
) -> Rendering: ...
class Playing:
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
    ) -> NDArray[np.float64]: ...
    def save(
        self,
        path: str | PathLike[str],
        rate_hz: int = 48_000,
        *,
        format: Literal["f32", "i24", "i16"] = "f32",
        full_scale: float | None = None,
        channel_map: Sequence[tuple[int, str, float]] | None = None,
        force: bool = False,
    ) -> None: ...

def play(
    model: Model,
    scene: Scene,
    *,
    rendering: Rendering | None = None,
    ramps: Literal["modal", "plain", "program"] | None = None,
    method: str = "default",
) -> Playing: ...
def correct(
    model: Model,
    scene: Scene,
    weights: Sequence[str | PathLike[str]],
    fields: Sequence[str | PathLike[str]],
    *,
    output: str | PathLike[str] | None = None,
    calibration: str | PathLike[str] | None = None,
    force: bool = False,
) -> dict[str, Any]: ...
def evaluate(rendering: Rendering, scene: Scene, on: FrfSet | Model) -> dict[str, Any]: ...
