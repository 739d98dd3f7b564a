"""Soft tissue inside a 1 kHz haptic loop. SI units; vectors are x, y, z in the scene's frame.

`press` runs a scene with an emulated finger, `press_many` one scene many times. A `Session` is the haptic loop around your own device:
arm it, then pass it a position every millisecond, and it returns a force; `session_many` runs many sessions at once.
"""

from ._native import PalpateError, Session, press, press_many, session_many

__all__ = ["PalpateError", "Session", "press", "press_many", "session_many"]
__version__ = "0.1.0"
