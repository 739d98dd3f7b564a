"""The press of `palpate chart` for any engine; all numbers come from press.json.

An engine is an object with

    tick(depth_m) -> force on the probe along the press [N], after one millisecond that ends at that depth
    positions() -> positions of the nodes [m], shape [nodes][3]
    cpu_s() -> processor time of its ticks so far [s], or None if that is the time of this thread

An engine divides a tick into the number of steps with which it was built, and moves the probe evenly over them.
"""

import json
import math
import time
from dataclasses import dataclass

import numpy as np


class Press:
    def __init__(self, path):
        with open(path, encoding="utf-8") as file:
            self.all = json.load(file)
        self.hash = self.all["hash"]
        self.tick_s = self.all["tick_s"]
        self.poisson_ratio = self.all["poisson_ratio"]
        self.density = self.all["density_kg_per_m3"]
        self.radius_m = self.all["probe_radius_m"]
        self.meshes = {m["name"]: Mesh(m) for m in self.all["meshes"]}


class Mesh:
    def __init__(self, stored):
        self.name = stored["name"]
        self.nodes_m = np.array(stored["nodes_m"], dtype=float)
        self.tets = np.array(stored["tets"], dtype=np.int32)
        self.fixed = np.zeros(len(self.nodes_m), dtype=bool)
        self.fixed[stored["fixed"]] = True

    def node_masses_kg(self, density):
        a, b, c, d = (self.nodes_m[self.tets[:, k]] for k in range(4))
        volumes = np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a)) / 6.0
        masses = np.zeros(len(self.nodes_m))
        for k in range(4):
            np.add.at(masses, self.tets[:, k], 0.25 * density * volumes)
        return masses

    def top_triangles(self):
        """Faces on the surface z = 0, counter-clockwise as seen from above."""
        found = []
        for tet in self.tets:
            for face in ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)):
                nodes = tet[list(face)]
                if np.all(np.abs(self.nodes_m[nodes, 2]) < 1e-9):
                    found.append(nodes)
        return np.array(found, dtype=np.int32)


class Diverged(Exception):
    """The force is not finite or too large, or a node is not finite or far from the block."""


def go(engine, depth_m):
    force = engine.tick(depth_m)
    if not math.isfinite(force) or abs(force) > 1e4:
        raise Diverged(f"diverges at {depth_m * 1e3:.1f} mm")
    return force


def sound(engine, depth_m):
    """Checks the positions: a force of zero may hide nodes that are not finite or far from the block."""
    x = engine.positions()
    if not np.isfinite(x).all() or np.abs(x).max() > 1.0:
        raise Diverged(f"diverges at {depth_m * 1e3:.1f} mm")
    return x


def survive(press, engine):
    """Runs the deepest press; returns None if the engine survives it, else the reason why not."""
    s = press.all["survival"]
    step = s["speed_m_per_s"] * press.tick_s
    travel = round((s["deepest_m"] + s["clear_m"]) / step)
    rest = engine.positions()
    try:
        for n in range(travel + 1):
            go(engine, n * step - s["clear_m"])
        for _ in range(s["wait_ticks"] - s["still_ticks"]):
            go(engine, s["deepest_m"])
        before = sound(engine, s["deepest_m"])
        forces = [go(engine, s["deepest_m"]) for _ in range(s["still_ticks"])]
        held = sound(engine, s["deepest_m"])
        moved = np.linalg.norm(held - before, axis=1).max()
        change = (max(forces) - min(forces)) / max(abs(max(forces)), 1e-30)
        if not (moved <= s["still_m"] and change <= s["still_force_share"]):
            return f"does not come to rest: {moved * 1e3:.2f} mm and {change * 100:.0f} % of the force in 20 ms"
        for n in range(travel, -1, -1):
            go(engine, n * step - s["clear_m"])
        for _ in range(s["wait_ticks"]):
            go(engine, -s["clear_m"])
    except Diverged as why:
        return str(why)
    left = np.linalg.norm(engine.positions() - rest, axis=1).max()
    if not left <= s["returned_m"]:
        return f"does not return: {left * 1e3:.2f} mm left after the release"
    return None


def held_forces(press, engine):
    """Settled force [N] in each hold that the engine reaches before it diverges."""
    h = press.all["held"]
    step = h["speed_m_per_s"] * press.tick_s
    depth = -press.all["survival"]["clear_m"]
    found = []
    try:
        for target in h["depths_m"]:
            ramp = math.ceil((target - depth) / step)
            for k in range(1, ramp + 1):
                go(engine, depth + (target - depth) * k / ramp)
            depth = target
            force = settled(engine, depth, h)
            sound(engine, depth)
            found.append(force)
    except Diverged:
        pass
    return found


def settled(engine, depth, h):
    last, still = math.nan, 0
    for _ in range(h["most_means"]):
        mean = sum(go(engine, depth) for _ in range(h["averaged_ticks"])) / h["averaged_ticks"]
        still = still + 1 if abs(mean - last) <= h["settled_share"] * abs(mean) else 0
        last = mean
        if still == h["in_a_row"]:
            break
    return last


def held_errors_pct(press, forces_n, youngs_modulus_pa):
    truths = press.all["held"]["force_over_e_m2"]
    return [(f / youngs_modulus_pa / t - 1.0) * 100.0 for f, t in zip(forces_n, truths)]


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values))


def moving_error_pct(ramp, engine):
    """Root mean square error over the judged ticks, relative to the largest reference force in them [%]."""
    truths = np.array(ramp["judged_force_over_e_m2"])
    touch = next(n for n, d in enumerate(ramp["depths_m"]) if d > 1e-12)
    forces = np.array([go(engine, d) for d in ramp["depths_m"]])
    sound(engine, ramp["depths_m"][-1])
    own = forces[touch : touch + len(truths)] / ramp["youngs_modulus_pa"]
    return math.sqrt(np.mean((own - truths) ** 2)) / truths.max() * 100.0


@dataclass
class TickTime:
    min_us: float
    median_us: float


def tick_time(press, engine):
    """Processor time of a tick while the probe moves slowly about 4 mm deep, as our own methods are timed."""
    t = press.all["timing"]
    clear = press.all["survival"]["clear_m"]
    down = math.ceil((t["depth_m"] + clear) / t["approach_m"])
    for n in range(down + t["settle_ticks"] + 1):
        go(engine, min(n * t["approach_m"] - clear, t["depth_m"]))
    clock = engine.cpu_s if engine.cpu_s() is not None else time.thread_time
    begun = clock()
    batches = []
    while len(batches) < t["least_batches"] or clock() - begun < t["long_enough_s"]:
        started = clock()
        for n in range(1, t["batch_ticks"] + 1):
            go(engine, t["depth_m"] + min(n, t["batch_ticks"] - n) * t["step_m"])
        batches.append((clock() - started) * 1e6 / t["batch_ticks"])
    batches.sort()
    return TickTime(batches[0], batches[len(batches) // 2])
