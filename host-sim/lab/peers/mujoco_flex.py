"""MuJoCo's flex: tets whose nodes have three slide joints each, pressed by MuJoCo's own sphere.

The sphere is a heavy body on one slide joint whose position and velocity are set before every step, so that the contact
takes the velocity into account; the force is the contact force on that joint.
"""

import math

import mujoco
import numpy as np

NAME = "MuJoCo"
VERSION = mujoco.__version__
FORCE = "contact force on the probe's joint (qfrc_constraint)"
INTEGRATORS = {"euler": mujoco.mjtIntegrator.mjINT_EULER, "discrete": mujoco.mjtIntegrator.mjINT_DISCRETE}


class Engine:
    def __init__(self, press, mesh, youngs_modulus_pa, substeps, settings):
        self.substeps = substeps
        self.step_s = press.tick_s / substeps
        self.radius = press.radius_m
        spec = mujoco.MjSpec()
        spec.option.gravity = [0, 0, 0]
        spec.option.timestep = self.step_s
        spec.option.integrator = INTEGRATORS[settings["integrator"]]
        spec.option.solver = getattr(mujoco.mjtSolver, "mjSOL_" + settings.get("solver", "cg").upper())
        spec.option.tolerance = settings.get("tolerance", 1e-6)
        if "iterations" in settings:
            spec.option.iterations = settings["iterations"]
        spec.memory = 1 << 29
        masses = mesh.node_masses_kg(press.density)
        names = []
        for n, x in enumerate(mesh.nodes_m):
            if mesh.fixed[n]:
                names.append("world")
                continue
            name = f"n{n}"
            body = spec.worldbody.add_body(name=name, pos=x, mass=masses[n], inertia=[masses[n] * 1e-6] * 3, ipos=[0, 0, 0], explicitinertial=True)
            for axis in np.eye(3):
                body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis, damping=0.0)
            names.append(name)
        # a node on a body is at the origin of that body; a node of the world is at its own position
        local = [list(x) if mesh.fixed[n] else [0.0, 0.0, 0.0] for n, x in enumerate(mesh.nodes_m)]
        flex = spec.add_flex(name="tissue")
        flex.dim = 3
        flex.vertbody = names
        flex.vert = np.array(local).ravel()
        flex.elem = mesh.tets.ravel().tolist()
        flex.young = youngs_modulus_pa
        flex.poisson = press.poisson_ratio
        flex.damping = settings["damping_s"]
        flex.elastic3d = settings.get("material", 0)
        flex.radius = settings.get("flex_radius_m", 1e-5)
        flex.selfcollide = mujoco.mjtFlexSelf.mjFLEXSELF_NONE
        flex.condim = 1
        flex.contype, flex.conaffinity = 1, 0
        flex.passive = settings.get("passive", 0)
        flex.activelayers = 1
        solref, solimp = settings["solref"], settings.get("solimp", [0.95, 0.99, 1e-3, 0.5, 2])
        flex.solref, flex.solimp = solref, solimp
        probe = spec.worldbody.add_body(name="probe", pos=[0, 0, self.radius + 0.02], mass=1e3, inertia=[1e3] * 3, explicitinertial=True)
        probe.add_joint(name="press", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1])
        ball = probe.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[self.radius, 0, 0], condim=1)
        ball.contype, ball.conaffinity = 0, 1
        ball.solref, ball.solimp = solref, solimp
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        joint = self.model.joint("press")
        self.q, self.v = joint.qposadr[0], joint.dofadr[0]
        self.at = -0.02 + 0.0
        self.depth = None
        mujoco.mj_forward(self.model, self.data)

    def tick(self, depth_m):
        model, data = self.model, self.data
        before = depth_m if self.depth is None else self.depth
        speed = -(depth_m - before) / (self.step_s * self.substeps)
        self.depth = depth_m
        for k in range(self.substeps):
            # position at the start of the step, so that the probe ends at the requested depth
            data.qpos[self.q] = -(before + (depth_m - before) * k / self.substeps) - 0.02
            data.qvel[self.v] = speed
            mujoco.mj_step(model, data)
        if data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number or data.warning[mujoco.mjtWarning.mjWARN_BADQPOS].number:
            return float("nan")
        return float(data.qfrc_constraint[self.v])

    def positions(self):
        return self.data.flexvert_xpos.copy()

    def cpu_s(self):
        return None


MESHES = ["patch-130", "grid-245", "patch-410", "grid-726", "grid-2025"]


def settings(youngs_modulus_pa):
    """Settings of the search: material and integrator (the stable neo-Hookean law works only with the implicit one), and
    the time constant of the contact. It determines how far a node sinks into the probe, which compensates for coarse
    meshes as our foundation does. A contact is defined by its acceleration, so in stiffer tissue a node sinks in equally
    far only if the time constant decreases with the square root of E. A damping of 2 ms instead of 0.5 ms, and contacts
    of 2 ms, were tried on two meshes at 3.5 kPa and were never the best."""
    faster = math.sqrt(3500.0 / youngs_modulus_pa)
    laws = (("flex StVK explicit", 0, "euler"), ("flex StVK implicit", 0, "discrete"), ("flex NH implicit", 1, "discrete"))
    for model, material, integrator in laws:
        for time_s in (0.004, 0.01, 0.02, 0.04):
            yield model, {"integrator": integrator, "material": material, "damping_s": 0.0005, "solref": [round(time_s * faster, 6), 1.0]}
