"""pypbd's XPBD: a spring along every edge and a volume constraint in every tet, pressed by a rigid sphere of pypbd.

Springs and volumes have the stiffnesses that give E and nu at small strain in a uniform mesh. The sphere is a rigid body
of 1 kg whose position and velocity are set before every step; the force is the change of its momentum in a step. Gravity
cannot be switched off from Python, so before every step a velocity is added that cancels it.
"""

import importlib.metadata
import math
import time

import numpy as np
import pypbd

NAME = "pypbd"
VERSION = importlib.metadata.version("pypbd")
FORCE = "change of the probe's momentum in a step"
GRAVITY = np.array([0.0, -9.81, 0.0])


def sphere(radius, rings=6, around=12):
    """Corners and triangles of a ball, which a rigid body needs; contact uses the exact distance instead."""
    points = [[0, 0, radius], [0, 0, -radius]]
    for i in range(1, rings):
        polar = math.pi * i / rings
        for j in range(around):
            angle = 2 * math.pi * j / around
            points.append([radius * math.sin(polar) * math.cos(angle), radius * math.sin(polar) * math.sin(angle), radius * math.cos(polar)])
    at = lambda i, j: 2 + (i - 1) * around + j % around
    faces = []
    for j in range(around):
        faces += [0, at(1, j), at(1, j + 1), 1, at(rings - 1, j + 1), at(rings - 1, j)]
        for i in range(1, rings - 1):
            faces += [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)]
    return points, faces


class Engine:
    def __init__(self, press, mesh, youngs_modulus_pa, substeps, settings):
        self.step_s, self.substeps, self.radius = press.tick_s / substeps, substeps, press.radius_m
        # there is a single simulation, which is created once; each engine has its own model and stepper
        if not pypbd.Simulation.hasCurrent():
            pypbd.Simulation.getCurrent().initDefault()
        self.sim = pypbd.Simulation.getCurrent()
        self.model = pypbd.SimulationModel()
        self.model.init()
        self.sim.setModel(self.model)
        self.stepper = pypbd.TimeStepController()
        self.stepper.init()
        self.stepper.setValueUInt(pypbd.TimeStepController.NUM_SUB_STEPS, 1)
        self.stepper.setValueUInt(pypbd.TimeStepController.MAX_ITERATIONS, settings["iterations"])
        self.stepper.setValueUInt(pypbd.TimeStepController.MAX_ITERATIONS_V, settings["contact_iterations"])
        pypbd.TimeManager.getCurrent().setTimeStepSize(self.step_s)
        self.scale = scale = settings["units_per_m"]
        tets = self.model.addTetModel([x * scale for x in mesh.nodes_m], mesh.tets.ravel().tolist(), testMesh=False)
        tets.setFrictionCoeff(0.0)
        tets.setRestitutionCoeff(0.0)
        self.particles = self.model.getParticles()
        for n, (mass, fixed) in enumerate(zip(mesh.node_masses_kg(press.density), mesh.fixed)):
            self.particles.setMass(n, 0.0 if fixed else mass)
        nu = press.poisson_ratio
        mu, lam = youngs_modulus_pa / (2 * (1 + nu)), youngs_modulus_pa * nu / ((1 + nu) * (1 - 2 * nu))
        springs, kappa = 2.5 * mu, lam - mu
        stiffness = {}
        a, b, c, d = (mesh.nodes_m[mesh.tets[:, k]] for k in range(4))
        volumes = np.einsum("ij,ij->i", b - a, np.cross(c - a, d - a)) / 6.0
        for tet, volume in zip(mesh.tets, volumes):
            for i in range(4):
                for j in range(i):
                    key = tuple(sorted((int(tet[i]), int(tet[j]))))
                    stiffness[key] = stiffness.get(key, 0.0) + volume
        # stiffnesses are in N/m and Pa; in other units of length that of a spring is unchanged, that of a volume is
        # divided by scale^4
        for (i, j), volume in stiffness.items():
            length = np.linalg.norm(mesh.nodes_m[i] - mesh.nodes_m[j])
            self.model.addDistanceConstraint_XPBD(i, j, springs * volume / length**2)
        for tet, volume in zip(mesh.tets, volumes):
            self.model.addVolumeConstraint_XPBD(*(int(n) for n in tet), kappa / volume / scale**4)
        self.count = len(mesh.nodes_m)
        points, faces = sphere(self.radius * scale)
        vertices = pypbd.VertexData()
        for p in points:
            vertices.addVertex(np.array(p))
        surface = pypbd.IndexedFaceMesh()
        surface.initMesh(len(points), len(faces), len(faces) // 3) if hasattr(surface, "initMesh") else None
        for n in range(0, len(faces), 3):
            surface.addFace(faces[n : n + 3])
        surface.buildNeighbors()
        self.ball = self.model.addRigidBody(1000.0, vertices, surface, translation=np.array([0, 0, (self.radius + 0.02) * scale]))
        self.ball.setMass(1.0)
        self.ball.setFrictionCoeff(0.0)
        self.ball.setRestitutionCoeff(0.0)
        self.model.setContactStiffnessParticleRigidBody(settings["contact"])
        self.found = pypbd.DistanceFieldCollisionDetection()
        self.found.setTolerance(settings.get("tolerance_m", 0.0) * scale)
        bodies = pypbd.CollisionObject
        self.found.addCollisionSphere(0, bodies.RigidBodyCollisionObjectType, vertices, 0, vertices.size(), self.radius * scale, True, False)
        self.found.addCollisionObjectWithoutGeometry(0, bodies.TetModelCollisionObjectType, self.particles, 0, self.count, True)
        self.stepper.setCollisionDetection(self.model, self.found)
        self.depth, self.spent = None, 0.0

    def tick(self, depth_m):
        self.sim.setModel(self.model)
        pypbd.TimeManager.getCurrent().setTimeStepSize(self.step_s)
        before = depth_m if self.depth is None else self.depth
        self.depth = depth_m
        speed = -(depth_m - before) / (self.step_s * self.substeps) * self.scale
        back = -GRAVITY * self.step_s
        force = 0.0
        for k in range(self.substeps):
            tip = -(before + (depth_m - before) * k / self.substeps)
            for n in range(self.count):
                self.particles.setVelocity(n, self.particles.getVelocity(n) + back)
            self.ball.setPosition(np.array([0, 0, (tip + self.radius) * self.scale]))
            self.ball.setVelocity(np.array([0, 0, speed]) + back)
            # only the step is timed: cancelling gravity is not part of the engine's work
            started = time.thread_time()
            self.stepper.step(self.model)
            force = (self.ball.getVelocity()[2] - speed) / self.step_s / self.scale
            self.spent += time.thread_time() - started
        return float(force)

    def positions(self):
        return np.array([self.particles.getPosition(n) for n in range(self.count)]) / self.scale

    def cpu_s(self):
        return self.spent


MESHES = ["patch-130", "grid-245", "patch-410", "grid-726", "grid-2025"]


def settings(youngs_modulus_pa):
    """Settings of the search: iterations, and the stiffness of the contact, which compensates for coarse meshes as our
    foundation does and is proportional to E."""
    for iterations in (5, 20):
        for contact in (100.0, 300.0, 1000.0, 3000.0):
            contact *= youngs_modulus_pa / 3500.0
            yield "XPBD springs+volumes", {"iterations": iterations, "contact_iterations": 5, "contact": contact, "units_per_m": 1.0}
