"""Newton on Warp's CPU device: stable neo-Hookean tets on particles, pressed by a sphere on a heavy body
whose position and velocity are set before every step.

There are two solvers: semi-implicit (explicit forces, symplectic Euler), whose contact force is read from the body, and
vertex block descent (VBD, implicit), whose contact force is computed here by summing its penalty law over the particles
at the end of the step.
"""

import numpy as np
import warp as wp

wp.config.quiet = True
wp.config.verify_fp = False
wp.init()
wp.set_device("cpu")

import newton

NAME = "Newton"
VERSION = f"{newton.__version__} (Warp {wp.__version__}; CPU)"
FORCE = "penalty force of its particle contacts on the probe"


class Engine:
    def __init__(self, press, mesh, youngs_modulus_pa, substeps, settings):
        self.substeps, self.step_s = substeps, press.tick_s / substeps
        self.radius = press.radius_m
        self.vbd = settings["solver"] == "vbd"
        nu = press.poisson_ratio
        mu, lam = youngs_modulus_pa / (2 * (1 + nu)), youngs_modulus_pa * nu / ((1 + nu) * (1 - 2 * nu))
        if settings["constants"] == "smith":
            # the constants of Smith et al. (2018) that give these moduli at small strain
            mu, lam = 4 / 3 * mu, lam + 5 / 6 * mu
        builder = newton.ModelBuilder(up_axis=newton.Axis.Z, gravity=(0.0, 0.0, 0.0))
        masses = mesh.node_masses_kg(press.density)
        for x, m, fixed in zip(mesh.nodes_m, masses, mesh.fixed):
            builder.add_particle(pos=wp.vec3(*x), vel=wp.vec3(0.0, 0.0, 0.0), mass=0.0 if fixed else float(m), radius=1e-6)
        for tet in mesh.tets:
            builder.add_tetrahedron(*(int(n) for n in tet), k_mu=mu, k_lambda=lam, k_damp=settings["damping"])
        start = wp.transform(wp.vec3(0.0, 0.0, self.radius + 0.02), wp.quat_identity())
        # VBD requires a body with a joint; with a joint, the other solver does not report the force on the body
        body = builder.add_body(xform=start, is_kinematic=True, mass=1.0) if self.vbd else builder.add_link(xform=start, mass=1e3)
        ke = settings["contact_n_per_m"]
        cfg = newton.ModelBuilder.ShapeConfig(density=0.0, ke=ke, kd=settings["contact_damping"], kf=0.0, mu=0.0, ka=0.0)
        builder.add_shape_sphere(body, radius=self.radius, cfg=cfg)
        if self.vbd:
            builder.color()
        self.model = builder.finalize(device="cpu")
        self.model.soft_contact_ke, self.model.soft_contact_kd = ke, settings["contact_damping"]
        self.model.soft_contact_kf = self.model.soft_contact_mu = 0.0
        self.model.particle_grid = None
        self.ke = ke
        if self.vbd:
            self.solver = newton.solvers.SolverVBD(self.model, iterations=settings["iterations"], integrate_with_external_rigid_solver=True)
        else:
            self.solver = newton.solvers.SolverSemiImplicit(self.model, enable_tri_contact=False)
        self.states = [self.model.state(), self.model.state()]
        self.control = self.model.control()
        self.pipeline = newton.CollisionPipeline(self.model, soft_contact_gap=settings.get("gap_m", 2e-3))
        self.contacts = self.pipeline.contacts()
        self.depth = None
        self.mass = masses

    def tick(self, depth_m):
        before = depth_m if self.depth is None else self.depth
        self.depth = depth_m
        speed = -(depth_m - before) / (self.step_s * self.substeps)
        now, after = self.states
        for k in range(self.substeps):
            share = k / self.substeps if not self.vbd else (k + 1) / self.substeps
            tip = -(before + (depth_m - before) * share)
            now.clear_forces()
            q, qd = now.body_q.numpy(), now.body_qd.numpy()
            q[0, :3] = (0.0, 0.0, tip + self.radius)
            qd[0] = (0.0, 0.0, speed, 0.0, 0.0, 0.0)
            if self.vbd:
                # the motion of the body is prescribed: VBD reads it at both ends of the step
                q_after, qd_after = after.body_q.numpy(), after.body_qd.numpy()
                q_after[:], qd_after[:] = q, qd
            self.pipeline.collide(now, self.contacts)
            self.solver.step(now, after, self.control, self.contacts, self.step_s)
            self.states = now, after = after, now
        if not self.vbd:
            return float(after.body_f.numpy()[0, 2])
        # penalty law of the contact: along the normal, ke times the depth of each particle in the ball
        x = now.particle_q.numpy()
        way = x - np.array([0.0, 0.0, -depth_m + self.radius], dtype=np.float32)
        far = np.linalg.norm(way, axis=1)
        inside = far < self.radius
        return float(-(self.ke * (self.radius - far[inside]) * way[inside, 2] / far[inside]).sum())

    def positions(self):
        return self.states[0].particle_q.numpy().astype(float)

    def cpu_s(self):
        return None


MESHES = ["patch-130", "grid-245", "patch-410", "grid-726", "grid-2025"]


def settings(youngs_modulus_pa):
    """Settings of the search: the stiffness of the contact, which compensates for coarse meshes as our
    foundation does. VBD runs with 2 iterations (5 cost 2.5 times as much and gave the same errors).
    The constants of the law give the correct moduli at small strain."""
    for contact in (30.0, 60.0, 100.0, 300.0):
        contact *= youngs_modulus_pa / 3500.0
        yield "NH semi-implicit", {"solver": "semi", "constants": "smith", "damping": 1e-3, "contact_n_per_m": contact, "contact_damping": 0.0}
    for iterations in (2,):
        for contact in (30.0, 60.0, 100.0, 300.0):
            contact *= youngs_modulus_pa / 3500.0
            yield "NH VBD", {"solver": "vbd", "constants": "smith", "damping": 1e-3, "contact_n_per_m": contact, "contact_damping": 0.0, "iterations": iterations}
