"""Wrong calls of the Python package raise exceptions that name the error, and the session remains usable."""

import pathlib
import sys
import threading

import numpy as np
import palpate

patch = sys.argv[1]

# every name has its types
types = (pathlib.Path(palpate.__file__).parent / "_native.pyi").read_text()
public = palpate.__all__ + [name for name in dir(palpate.Session) if not name.startswith("_")]
assert [name for name in public if f"def {name}(" not in types and f"class {name}(" not in types and f"class {name}:" not in types] == []
assert set(palpate.press("block")) == {line.split(":")[0].strip() for line in types.split("class Press(")[1].split("\n\n")[0].splitlines()[1:]}


def raises(kind, words, call):
    try:
        call()
    except kind as error:
        assert words in str(error) and "\n" not in str(error), error
    else:
        raise AssertionError(f"{words!r} was not said")


raises(palpate.PalpateError, "did you mean", lambda: palpate.Session("blok"))
raises(palpate.PalpateError, "check the path", lambda: palpate.Session(patch="nowhere.patch"))
raises(palpate.PalpateError, "is no profile", lambda: palpate.Session(patch=patch, device="q"))
raises(palpate.PalpateError, "did you mean", lambda: palpate.press("blok"))
raises(TypeError, "", lambda: palpate.Session(3))
raises(palpate.PalpateError, "did you mean", lambda: palpate.press("block", set={"tissue.youngs_modulus": 5000}))
raises(palpate.PalpateError, "outside 1 ..", lambda: palpate.press_many("block", [{}, {"tissue.youngs_modulus_pa": 0.5}]))
raises(TypeError, "tissue.nodes: give a number", lambda: palpate.press("block", set={"tissue.nodes": None}))
raises(palpate.PalpateError, "radius_m = NaN must be above", lambda: palpate.press("block", set={"probe.radius_m": np.nan}))
raises(palpate.PalpateError, "give the table whole", lambda: palpate.press("block", set={"probe.shape": "ellipsoid"}))
raises(palpate.PalpateError, "probe.radius_m = -1", lambda: palpate.press("block", set={"probe": {"shape": "sphere", "radius_m": -1}}))
for wrong in ({"probe.radius_m": 0.006}, [None], "up", None):
    raises(TypeError, "sets: give a list", lambda: palpate.press_many("block", wrong))

# a sweep on all cores gives what single presses give; the finite elements are those of the block
small = {"tissue.block_m": [0.06, 0.06, 0.03], "tissue.nodes": 130, "drive.hold_s": 0.05, "probe.shape": "sphere"}
moduli = [2000, np.float64(4000.0)]
swept = palpate.press_many("block", [{**small, "tissue.youngs_modulus_pa": modulus} for modulus in moduli])
single = palpate.press("block", set={**small, "tissue.youngs_modulus_pa": 4000.0})
assert [found["state_hash"] for found in swept].count(single["state_hash"]) == 1
assert swept[1]["state_hash"] == single["state_hash"] and "uncalibrated" in single["model"] and single["warnings"] == []
assert 1.9 < swept[1]["hold_force_n"][-1] / swept[0]["hold_force_n"][-1] < 2.1 and np.isnan(single["hold_elements_n"]).all()
# a hundred random presses at once give the bits of single ones
rng = np.random.default_rng(54)
drawn = [
    {
        "tissue.block_m": [0.06, 0.06, 0.03], "tissue.nodes": 60, "tissue.youngs_modulus_pa": rng.uniform(2e3, 2e4),
        "drive.hold_s": 0.01, "drive.holds_m": [rng.uniform(5e-4, 3e-3)], "probe.position_m": rng.uniform(-5e-3, 5e-3, 2).tolist(),
    }
    for _ in range(100)
]
for changes, found in zip(drawn, palpate.press_many("block", drawn)):
    single = palpate.press("block", set=changes)
    for name in ("tip_m", "force_n", "depth_m", "hold_force_n", "state_hash", "residual_m"):
        assert np.array_equal(found[name], single[name]), (changes, name)
    assert found["hold_force_n"][0] > 1e-3

block = palpate.press("block", set={"tissue.density_kg_per_m3": 1.06})
assert (abs(block["hold_force_n"] / block["hold_elements_n"] - 1) < 0.02).all()
assert "% rms off" in block["model"] and "kilograms" in block["warnings"][0]

# a hundred random presses at once give the bits of single ones
rng = np.random.default_rng(54)
single = palpate.Session(patch=patch)
across, depths = rng.uniform(-2e-3, 2e-3, (100, 1, 3)), rng.uniform(1e-3, 4e-3, (100, 1, 1))
ways = np.minimum(np.arange(900)[None, :, None] * 1e-5 - 7e-3, 0) + depths * np.clip(np.arange(900) / 150 - 5, 0, 1)[None, :, None]
tips = single.site_m + across - across @ np.outer(single.axis, single.axis) - ways * single.axis
many = palpate.session_many(None, tips, patch=patch)
assert many["tissue_n"].shape == (100, 900, 3) and many["mode"].shape == (100, 900) and (many["tissue_n"][:, -1, 2] > 0.01).all()
for n, tips_m in enumerate(tips):
    single.reset()
    single.arm()
    assert all((of == many[name][n]).all() for name, of in single.run(tips_m).items()), n
assert palpate.session_many("block", np.zeros((0, 5, 3)))["depth_m"].shape == (0, 5)
for wrong in (np.zeros((4, 3)), np.zeros((2, 4, 2))):
    raises(ValueError, "give (sessions, ticks, 3)", lambda: palpate.session_many("block", wrong))
for wrong in ([[[0.0] * 3] * 2, [[0.0] * 3] * 3], "up"):
    raises(ValueError, "ragged", lambda: palpate.session_many("block", wrong))
raises(palpate.PalpateError, "did you mean", lambda: palpate.session_many("blok", np.zeros((1, 1, 3))))

session = palpate.Session(patch=patch)
assert set(session.read_contact()) == {line.split(":")[0].strip() for line in types.split("class Contact(")[1].split("\n\n")[0].splitlines()[1:]}
assert not session.read_contact()["normal_n"].any() and session.read_contact()["pressure_pa"].shape == (len(session.triangles),)
corners = session.triangles
assert corners.shape[1] == 3 and corners.max() < len(session.nodes_m) and (np.unique(corners, axis=0).shape == corners.shape)
up = session.site_m + 2e-3 * session.axis
assert session.mode == "boot" and session.fault is None and not session.contact and session.depth_m == 0.0
raises(palpate.PalpateError, "quaternion", lambda: session.turn([0.0, 0.0, 0.0, 2.0]))
raises(palpate.PalpateError, "tilt", lambda: session.tick(up, orientation=[0.0, 0.5**0.5, 0.0, 0.5**0.5]))
for wrong in ([1.0, 2.0], [1.0] * 4, np.zeros(0), None, 1.0, np.zeros((1, 3))):
    raises(ValueError, "tip_m has shape", lambda: session.tick(wrong))
for wrong in (np.zeros((4, 2)), np.zeros(3), np.zeros((2, 2, 3))):
    raises(ValueError, "tips_m has shape", lambda: session.run(wrong))
raises(ValueError, "tip_m is ragged or not of numbers: give x, y and z", lambda: session.tick("up"))
for wrong in ([[0.0] * 3, [0.0] * 2], np.zeros((2, 3), dtype=complex), np.full((2, 3), "0"), [["a"] * 3]):
    raises(ValueError, "tips_m is ragged or not of numbers: give rows", lambda: session.run(wrong))
raises(palpate.PalpateError, "from 0.005 to 0.5", lambda: session.commission_text(distance_m=-1.0))
raises(OverflowError, "", lambda: session.tick(up, late_ticks=-1))
raises(palpate.PalpateError, "nothing to clear", session.clear)
raises(palpate.PalpateError, "outside", lambda: setattr(session, "youngs_modulus_pa", 1e9))
raises(palpate.PalpateError, "outside", lambda: session.lower_force(1e3))
raises(AttributeError, "", lambda: setattr(session, "mode", "active"))

# arrays of any numeric type and memory order, arrays without rows, and lists
assert session.run(np.zeros((0, 3)))["force_n"].shape == (0, 3)
session.run(np.asfortranarray(np.tile(up, (5, 1))))
session.tick(list(up)), session.tick(np.array(up, dtype=np.float32)), session.tick(np.repeat(up, 2)[::2])
assert session.fault is None and session.mode == "idle"

# a second thread is told so at once, and its call changes nothing
long = threading.Thread(target=session.run, args=(np.tile(up, (50_000, 1)),))
long.start()
while long.is_alive():
    try:
        session.tick(up)
    except palpate.PalpateError as error:
        assert "another thread is in a call with this session: let one thread" in str(error), error
        break
else:
    raise AssertionError("the call of a second thread was not refused")
long.join()

# after a fault the force is zero and the fault is reported in words, until it is cleared
session.arm()
session.run(np.tile(up, (800, 1)))
pressed = session.run(session.site_m + np.outer(2e-3 - 1e-5 * np.arange(400), session.axis))
contact, state = session.read_contact(), session.state_hash
radius_m = np.linalg.norm(np.cross(session.axis, contact["torque_nm"])) / np.linalg.norm(contact["normal_n"][:2])
assert abs(contact["normal_n"][2] / pressed["tissue_n"][-1, 2] - 1) < 0.1 and abs(radius_m / 0.008 - 1) < 1e-2 and session.state_hash == state
assert contact["pressure_pa"].max() == contact["peak_pressure_pa"] and contact["axes"].shape == (2, 3) and not contact["friction_n"].any()
assert session.mode == "active" and session.contact and session.force_n[2] > 0.005 and (pressed["mode"] == 4).all()
assert not session.tick(np.full(3, np.nan)).any()
assert session.mode == "fault" and "not finite" in session.fault
raises(palpate.PalpateError, "clear", session.arm)
session.run(np.tile(up, (120, 1)))
session.clear()
session.run(np.tile(up, (3, 1)))
assert session.fault is None and session.mode == "idle"
session.lower_force(0.25)
session.reset()
assert session.max_force_n == 0.25 and session.mode == "boot"
print("0 wrong")
