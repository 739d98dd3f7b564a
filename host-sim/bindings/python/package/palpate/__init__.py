"""Soft tissue inside a 1 kHz haptic loop. SI units; vectors are x, y, z in the scene's frame.

`press` runs a scene with an emulated finger. A `Session` is the haptic loop around your own device:
arm it, then pass it a position every millisecond, and it returns a force.
"""

from ._native import PalpateError, Session, press

__all__ = ["PalpateError", "Session", "press"]
__version__ = "0.1.0"
