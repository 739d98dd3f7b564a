"""Prints the examples' press, tick by tick and in one call, and the press of a scene, to be compared with Rust's."""

import numpy as np
import palpate

session = palpate.Session("block", device="touch")
ticks = np.arange(2500)
steps = np.where(ticks < 700, 0, np.minimum(ticks - 700, 2500 - ticks))
tips_m = session.site_m + np.outer(5e-3 - 1e-5 * steps, session.axis)
session.arm()
looped = np.array([session.tick(tip_m) for tip_m in tips_m])
state = session.state_hash
session.reset()
session.arm()
trace = session.run(tips_m)
assert (trace["force_n"] == looped).all() and trace["force_n"].dtype == np.float64 and session.state_hash == state
assert trace["mode"].dtype == np.uint8 and (trace["depth_m"] > 0).sum() > 500
for tip_m, force_n in zip(tips_m, looped):
    print("tick", *(f"{number:.17g}" for number in (*tip_m, *force_n)))
print("state", state)
pressed = palpate.press("block")
for force_n in pressed["force_n"]:
    print("press", *(f"{number:.17g}" for number in force_n))
print("pressed", pressed["state_hash"])
