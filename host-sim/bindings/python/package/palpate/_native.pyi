from collections.abc import Mapping, Sequence
from typing import TypedDict, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Value = Union[bool, int, float, str, Sequence["_Value"]]
_Numbers = NDArray[np.float64]

class Trace(TypedDict):
    force_n: _Numbers
    tissue_n: _Numbers
    normal: _Numbers
    depth_m: _Numbers
    mode: NDArray[np.uint8]
    fault: NDArray[np.uint8]
    limiters: NDArray[np.uint8]

class Press(TypedDict):
    t_s: _Numbers
    tip_m: _Numbers
    command_m: _Numbers
    force_n: _Numbers
    depth_m: _Numbers
    tick_us: _Numbers
    hold_target: _Numbers
    hold_force_n: _Numbers
    hold_depth_m: _Numbers
    hold_elements_n: _Numbers
    residual_m: float
    state_hash: int
    fault: str | None
    model: str
    warnings: list[str]

class Contact(TypedDict):
    normal_n: _Numbers
    friction_n: _Numbers
    torque_nm: _Numbers
    centre_m: _Numbers
    axes: _Numbers
    half_lengths_m: _Numbers
    area_m2: float
    peak_pressure_pa: float
    pressure_pa: _Numbers

class PalpateError(Exception): ...

class Session:
    def __init__(
        self, scene: str | None = None, *, patch: str | None = None, device: str = "touch"
    ) -> None: ...
    def tick(
        self,
        tip_m: ArrayLike,
        *,
        orientation: Sequence[float] | None = None,
        late_ticks: int = 0,
        stale: bool = False,
        sensor_failed: bool = False,
        operator_absent: bool = False,
    ) -> NDArray[np.float64]: ...
    def run(self, tips_m: ArrayLike) -> Trace: ...
    def read_contact(self) -> Contact: ...
    def arm(self) -> None: ...
    def stop(self) -> None: ...
    def commission(
        self, reading: ArrayLike, *, confirmed: bool = False, distance_m: float = 0.05
    ) -> tuple[NDArray[np.float64], str]: ...
    def commission_text(self, *, distance_m: float = 0.05) -> str: ...
    def write_profile(self, path: str) -> None: ...
    @property
    def cautions(self) -> list[str]: ...
    def clear(self) -> None: ...
    def reset(self) -> None: ...
    def turn(self, orientation: Sequence[float]) -> None: ...
    def lower_force(self, max_force_n: float) -> None: ...
    @property
    def mode(self) -> str: ...
    @property
    def fault(self) -> str | None: ...
    @property
    def contact(self) -> bool: ...
    @property
    def depth_m(self) -> float: ...
    @property
    def force_n(self) -> NDArray[np.float64]: ...
    @property
    def refused(self) -> bool: ...
    @property
    def youngs_modulus_pa(self) -> float: ...
    @youngs_modulus_pa.setter
    def youngs_modulus_pa(self, value: float) -> None: ...
    @property
    def site_m(self) -> NDArray[np.float64]: ...
    @property
    def axis(self) -> NDArray[np.float64]: ...
    @property
    def max_force_n(self) -> float: ...
    @property
    def nodes_m(self) -> NDArray[np.float64]: ...
    @property
    def triangles(self) -> NDArray[np.uint32]: ...
    @property
    def state_hash(self) -> int: ...

def press(scene: str, *, set: Mapping[str, _Value] | None = None) -> Press: ...
def press_many(scene: str, sets: Sequence[Mapping[str, _Value]]) -> list[Press]: ...
def session_many(
    scene: str | None, tips_m: ArrayLike, *, patch: str | None = None, device: str = "touch"
) -> Trace: ...
