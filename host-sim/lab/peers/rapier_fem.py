"""rapier3d's soft bodies: drives the program in rapier/ through a pipe; the program itself times the ticks.

The ball is a kinematic body; the force is the impulse of its contacts in the last step divided by the time step.
"""

import os
import pathlib
import subprocess

import numpy as np

HERE = pathlib.Path(__file__).parent
PROGRAM = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", HERE / "rapier" / "target")) / "release" / "rapier-press"
if not PROGRAM.exists():
    raise ImportError(f"{PROGRAM} is not built")

NAME = "rapier3d"
VERSION = "0.36.1"
FORCE = "impulses of the probe's contacts in the last step"


class Engine:
    def __init__(self, press, mesh, youngs_modulus_pa, substeps, settings):
        self.child = subprocess.Popen([PROGRAM], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        write = self.child.stdin.write
        given = {
            "substeps": substeps,
            "tick_s": press.tick_s,
            "radius_m": press.radius_m,
            "youngs_modulus_pa": youngs_modulus_pa,
            "poisson_ratio": press.poisson_ratio,
            **settings,
        }
        for key, value in given.items():
            write(f"{key} {value}\n")
        masses = mesh.node_masses_kg(press.density)
        write(f"nodes {len(mesh.nodes_m)}\n")
        for x, m, fixed in zip(mesh.nodes_m, masses, mesh.fixed):
            write(f"{x[0]:.9g} {x[1]:.9g} {x[2]:.9g} {m:.9g} {int(fixed)}\n")
        write(f"tets {len(mesh.tets)}\n")
        for tet in mesh.tets:
            write(" ".join(str(n) for n in tet) + "\n")
        write("go\n")
        self.depth, self.spent = None, 0.0

    def ask(self, text):
        self.child.stdin.write(text + "\n")
        self.child.stdin.flush()
        answer = self.child.stdout.readline()
        if not answer:
            raise RuntimeError("rapier-press ended")
        return np.array(answer.split(), dtype=float)

    def tick(self, depth_m):
        before = depth_m if self.depth is None else self.depth
        self.depth = depth_m
        force, self.spent = self.ask(f"t {before:.9g} {depth_m:.9g}")
        return float(force)

    def positions(self):
        return self.ask("p").reshape(-1, 3)

    def cpu_s(self):
        return float(self.spent)

    def __del__(self):
        if hasattr(self, "child"):
            self.child.stdin.close()
            self.child.stdout.close()
            self.child.wait()


MESHES = ["patch-130", "grid-245", "patch-410", "grid-726", "grid-2025"]


def settings(youngs_modulus_pa):
    """Settings of the search: law and solver, and the stiffness of the contact, which compensates for coarse meshes as our
    foundation does. The finite elements also run with a dense factor, for up to 3000 unknowns, instead of conjugate
    gradients."""
    common = {"cg_iterations": 20}
    contacts = {"length_unit": 0.1, "skin_m": 1e-4, "damping_ratio": 0.1, "pgs_iterations": 3}
    for contact in (1.0, 2.0, 4.0, 8.0):
        yield "FEM NH", {"neo_hookean": 1, "fem": 1, **common, "contact_stiffening": contact, **contacts}
    for contact in (1.0, 2.0, 4.0, 8.0):
        yield "FEM NH", {"neo_hookean": 1, "fem": 1, **common, "contact_stiffening": contact, **contacts, "dense_dofs": 3000}
    for contact in (2.0, 8.0):
        yield "FEM corotational", {"neo_hookean": 0, "fem": 1, **common, "contact_stiffening": contact, **contacts}
        yield "rows NH", {"neo_hookean": 1, "fem": 0, **common, "contact_stiffening": contact, **contacts}
