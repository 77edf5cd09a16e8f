#!/usr/bin/env python3
"""Twelve pushes in seven engines: where the bodies end, and what a finer step changes.

    python3 -m venv venv && venv/bin/pip install numpy pybullet==3.2.7 mujoco==4.0.0 drake==1.51.1
    venv/bin/python bench/which_engine.py target/release/libjostle.so [--only NAME,...] [--part pushes,headings,...]

The first argument is jostle's shared library, built with the features cli and bullet. An engine that is not installed
is left out with the reason. Prints the tables of docs/which-engine-says-what.md, which says what they mean.

Metres, radians, seconds, kilograms; x along the push and y to its left, at heading 0. Results are printed in
millimetres and degrees. A heading turns bodies and push together about the origin, and the result is turned back.
"""

import argparse
import copy
import ctypes
import json
import logging
import math
import statistics
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np

# ---- the bodies and the pushes --------------------------------------------------------------------------------------

MASS, HEIGHT, GRAVITY = 0.1, 0.045, 9.8
# Coefficients of a pair: the products of jostle's surfaces (ground 1.1, body 0.5, tip 0.9).
GROUND, BODIES, TIP = 0.55, 0.25, 0.45
# The tip, closed fingers: along the push, across it, from the lower to the upper end.
TIP_LONG, TIP_WIDE, TIP_LOW, TIP_HIGH = 0.022, 0.0289, 0.011, 0.061
SPEED = 0.13
# The tip's face starts so far before the first body and travels so far.
GAP, TRAVEL = 0.010, 0.060
SETTLE = 0.25


class Body:
    """An upright prism of boxes (centre, half sides) and discs (centre, radius) about its centre of mass."""

    def __init__(self, name, boxes=(), discs=()):
        area = sum(4 * hx * hy for _, _, hx, hy in boxes) + sum(math.pi * r * r for _, _, r in discs)
        cx = sum(4 * hx * hy * x for x, _, hx, hy in boxes) + sum(math.pi * r * r * x for x, _, r in discs)
        cy = sum(4 * hx * hy * y for _, y, hx, hy in boxes) + sum(math.pi * r * r * y for _, y, r in discs)
        cx, cy = cx / area, cy / area
        self.name = name
        self.boxes = [(x - cx, y - cy, hx, hy) for x, y, hx, hy in boxes]
        self.discs = [(x - cx, y - cy, r) for x, y, r in discs]
        xx = sum(4 * hx * hy * (x * x + hx * hx / 3) for x, _, hx, hy in self.boxes)
        xx += sum(math.pi * r * r * (x * x + r * r / 4) for x, _, r in self.discs)
        yy = sum(4 * hx * hy * (y * y + hy * hy / 3) for _, y, hx, hy in self.boxes)
        yy += sum(math.pi * r * r * (y * y + r * r / 4) for _, y, r in self.discs)
        zz = area * HEIGHT**2 / 12
        # Moments of the uniform prism about x, y and z.
        self.inertia = [MASS / area * (yy + zz), MASS / area * (xx + zz), MASS / area * (xx + yy)]
        self.gyration = math.sqrt(self.inertia[2] / MASS)
        self.back = min([x - hx for x, _, hx, _ in self.boxes] + [x - r for x, _, r in self.discs])

    def corners(self):
        """Of each box, and of each disc as 32 corners, counter-clockwise."""
        angles = [math.tau * k / 32 for k in range(32)]
        signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
        boxes = [[(x + i * hx, y + j * hy) for i, j in signs] for x, y, hx, hy in self.boxes]
        return boxes + [[(x + r * math.cos(a), y + r * math.sin(a)) for a in angles] for x, y, r in self.discs]


S = 0.0225
SQUARE = Body("square", boxes=[(0, 0, S, S)])
LONG = Body("2:1", boxes=[(0, 0, S, 2 * S)])
DISC = Body("disc", discs=[(0, 0, S)])
# 45 x 90 mm with a notch of 22.5 x 46 mm in the middle of the far side.
ARM = (S / 2, 0.011)
NOTCHED = Body("notched", boxes=[(-S / 2, 0, S / 2, 2 * S), (S / 2, -0.034, *ARM), (S / 2, 0.034, *ARM)])
FLOOR_OF_NOTCH = NOTCHED.back + S


class Push:
    """Bodies at poses (x, y, theta) and the tip's sideways offset; the tip's face starts GAP before `front`."""

    def __init__(self, name, bodies, offset=0.0, front=None, travel=TRAVEL):
        self.name, self.bodies, self.travel = name, bodies, travel
        body, (x, _, _) = bodies[0]
        front = x + body.back if front is None else front
        self.start = (front - GAP - TIP_LONG / 2, offset)

    def shifted(self):
        other = copy.copy(self)
        other.start = (self.start[0], self.start[1] + 1e-4)
        return other


def row(count, body=SQUARE):
    return [(body, (2 * S * k, 0.0, 0.0)) for k in range(count)]


TURNED = math.radians(30)
CORNER = -S * (math.cos(TURNED) + math.sin(TURNED))
PUSHES = [
    Push("square, centre", row(1)),
    Push("square, offset 10", row(1), 0.010),
    Push("square, offset 20", row(1), 0.020),
    Push("square turned by 30°, centre", [(SQUARE, (0.0, 0.0, TURNED))], front=CORNER),
    Push("2:1 across, offset 20", row(1, LONG), 0.020),
    Push("2:1 along, offset 20", [(LONG, (0.0, 0.0, math.pi / 2))], 0.020, front=-2 * S),
    Push("disc, offset 10", row(1, DISC), 0.010),
    Push("two in a row, centre", row(2)),
    Push("two in a row, offset 20", row(2), 0.020),
    Push("two side by side, on the seam", [(SQUARE, (0.0, S, 0.0)), (SQUARE, (0.0, -S, 0.0))]),
    Push("row of three, offset 10", row(3), 0.010),
    Push("notched with a disc, offset 20", [(NOTCHED, (0.0, 0.0, 0.0)), (DISC, (FLOOR_OF_NOTCH + S, 0.0, 0.0))], 0.020),
]
# For torque over force: short, so that the tip's corner stays where it touches the face first.
TORQUE_PUSH = Push("square, offset 20, 20 mm", row(1), 0.020, travel=GAP + 0.020)
HEADINGS = [0, 30, 45]


def turned(pose, heading):
    x, y, theta = pose
    c, s = math.cos(heading), math.sin(heading)
    return c * x - s * y, s * x + c * y, theta + heading


def change(start, end, heading):
    """Along and across the push, and the turn."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    along, across, _ = turned((dx, dy, 0.0), -heading)
    return along, across, math.remainder(end[2] - start[2], math.tau)


# ---- jostle, through its C API --------------------------------------------------------------------------------------

class SimulatorOptions(ctypes.Structure):
    _fields_ = [("struct_size", ctypes.c_uint32), ("reserved", ctypes.c_uint32), ("engine", ctypes.c_char_p),
                ("preset", ctypes.c_char_p), ("seed", ctypes.c_uint64), ("friction_spread", ctypes.c_double),
                ("position_noise", ctypes.c_double), ("angle_noise", ctypes.c_double)]


class Action(ctypes.Structure):
    _fields_ = [("kind", ctypes.c_int32), ("reserved", ctypes.c_uint32), ("body", ctypes.c_uint64),
                ("push", ctypes.c_double * 4), ("grasp", ctypes.c_double * 7)]


class BodyPose(ctypes.Structure):
    _fields_ = [("body", ctypes.c_uint64), ("pose", ctypes.c_double * 3), ("present", ctypes.c_uint32),
                ("reserved", ctypes.c_uint32)]


PUSH, PUSHED = 1, 1


class Jostle:
    """An engine of jostle: a simulator without noise, made anew for every push."""

    library = None

    @classmethod
    def load(cls, path):
        cls.library = ctypes.CDLL(path)
        for function in ("version", "build_info", "last_error", "effect_name"):
            getattr(cls.library, f"jostle_{function}").restype = ctypes.c_char_p
        cls.context = ctypes.c_void_p()
        cls.call("context_new", None, ctypes.byref(cls.context))

    @classmethod
    def call(cls, function, *arguments):
        if getattr(cls.library, f"jostle_{function}")(*arguments) != 0:
            raise RuntimeError(f"jostle_{function}: {cls.library.jostle_last_error().decode()}")

    @classmethod
    def scene(cls, push, heading):
        """A scene file with what the simulator needs."""
        bodies = []
        for i, (body, pose) in enumerate(push.bodies):
            x, y, theta = turned(pose, heading)
            parts = [{"shape": {"convex_polygon": box}} for box in body.corners()[:len(body.boxes)]]
            parts += [{"pose": {"x": a, "y": b}, "shape": {"disc": {"radius": r}}} for a, b, r in body.discs]
            shape = parts[0]["shape"] if len(parts) == 1 else {"compound": parts}
            bodies.append({"name": f"{i} {body.name}", "shape": shape, "height": HEIGHT, "mass": MASS, "friction": 0.5,
                           "outline_tolerance": 0, "pose": {"x": x, "y": y, "theta": theta}})
        return {"version": 1, "bodies": bodies, "clear": True, "friction": {"ground": 1.1, "tip": 0.9},
                "workspace": {"min": [-1, -1], "max": [1, 1]}}

    def __init__(self, push, heading, engine, preset):
        scene, target = ctypes.c_void_p(), ctypes.c_uint64()
        with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
            json.dump(self.scene(push, heading), file)
            file.flush()
            self.call("scene_read", self.context, file.name.encode(), ctypes.byref(scene), ctypes.byref(target))
        options = SimulatorOptions()
        self.call("simulator_options_init", ctypes.byref(options), ctypes.c_size_t(ctypes.sizeof(options)))
        options.engine, options.preset = engine.encode(), preset.encode()
        self.simulator = ctypes.c_void_p()
        self.call("simulator_new", self.context, scene, ctypes.c_uint64(0), ctypes.byref(options),
                  ctypes.byref(self.simulator))
        self.library.jostle_scene_free(scene)
        self.count = len(push.bodies)

    def push(self, push, heading):
        action = Action(kind=PUSH)
        (x, y), travel = push.start, push.travel
        action.push[:] = turned((x, y, 0), heading)[:2] + turned((x + travel, y, 0), heading)[:2]
        effect = ctypes.c_int32()
        self.call("simulator_execute", self.simulator, ctypes.byref(action), ctypes.byref(effect))
        if effect.value != PUSHED:
            raise RuntimeError(self.library.jostle_effect_name(effect).decode())
        poses, count = (BodyPose * self.count)(), ctypes.c_size_t()
        self.call("simulator_poses", self.simulator, poses, ctypes.c_size_t(self.count), ctypes.byref(count))
        self.library.jostle_simulator_free(self.simulator)
        return [tuple(p.pose) for p in poses]


# ---- simulators that are stepped: PyBullet, MuJoCo, Drake -----------------------------------------------------------

class Stepped:
    """A world with bodies and a tip that `step(travel, moving)` takes one time step on; `dt` is its length."""

    def push(self, push, heading):
        time_ahead, travel = 0.1, 0.0
        for _ in range(round(time_ahead / self.dt)):
            self.step(0.0, False)
        while travel < push.travel:
            # The tip begins each step where it should, so the last step ends at the whole travel.
            self.step(travel, True)
            travel += SPEED * self.dt
        for _ in range(round(SETTLE / self.dt)):
            # The tip is taken away, back along the push.
            self.step(-1.0, False)
        return self.poses()

    def free(self, velocity):
        """How fast a body slows down that is given (vx, vy, omega): lost in the time until it has half of it left."""
        for _ in range(round(0.1 / self.dt)):
            self.step(-1.0, False)
        self.set_velocity(velocity)
        size, steps = np.linalg.norm(velocity), 0
        while True:
            self.step(-1.0, False)
            steps += 1
            now = self.velocity()
            left = np.dot(now, velocity) / size
            if left < size / 2 or steps * self.dt > 5.0:
                return (size - left) / (steps * self.dt)


class PyBullet(Stepped):
    """`hulls`: meshes with Bullet's margin, rolling and spinning friction of 1 mm and a ground box, as the published
    planners have it; else boxes, cylinders and a plane. Their outlines are those of the bodies where bodies touch."""

    def __init__(self, push, heading, hulls=False, dt=1 / 240, iterations=50, residual=1e-7):
        import pybullet as p

        self.p, self.heading, self.start, self.dt = p, heading, push.start, dt
        p.resetSimulation()
        p.setGravity(0, 0, -GRAVITY)
        # A reset keeps the time step, so it is given where it is the default too. With file caching PyBullet would take
        # the files of the body before for those of the next one.
        p.setPhysicsEngineParameter(fixedTimeStep=dt, numSolverIterations=iterations, solverResidualThreshold=residual,
                                    enableFileCaching=0)
        ground = p.createCollisionShape(p.GEOM_BOX, halfExtents=[100, 100, 5]) if hulls else \
            p.createCollisionShape(p.GEOM_PLANE)
        self.ground = p.createMultiBody(0, ground, basePosition=[0, 0, -5.0005 if hulls else 0])
        p.changeDynamics(self.ground, -1, lateralFriction=1.1, restitution=0.5 if hulls else 0.0)
        self.bodies = []
        for body, pose in push.bodies:
            x, y, theta = turned(pose, heading)
            self.bodies.append(self.load(body, 0.001 if len(push.bodies) > 1 else 0.0, hulls))
            p.resetBasePositionAndOrientation(self.bodies[-1], [x, y, HEIGHT / 2 + (0.0005 if hulls else 0.0)],
                                              p.getQuaternionFromEuler([0, 0, theta]))
            friction = {"rollingFriction": 0.001, "spinningFriction": 0.001} if hulls else {}
            p.changeDynamics(self.bodies[-1], -1, mass=MASS, localInertiaDiagonal=body.inertia, lateralFriction=0.5,
                             **friction)
        box = p.createCollisionShape(p.GEOM_BOX, halfExtents=[TIP_LONG / 2, TIP_WIDE / 2, (TIP_HIGH - TIP_LOW) / 2])
        self.tip = p.createMultiBody(1000, box, basePosition=[0, 0, 5])
        p.changeDynamics(self.tip, -1, lateralFriction=0.9, linearDamping=0, angularDamping=0)

    def load(self, body, shrink, hulls):
        """A body from a URDF file: a mesh with an object for each part, its outline `shrink` inside, or primitives."""
        folder = Path(self.folder())
        place = 'origin xyz="{} {} 0"/>'
        if hulls:
            (folder / "hulls.obj").write_text(wavefront(inner(corners, shrink) for corners in body.corners()))
            parts = ['<mesh filename="hulls.obj"/>']
            places = [place.format(0, 0)]
        else:
            parts = [f'<box size="{2 * hx} {2 * hy} {HEIGHT}"/>' for _, _, hx, hy in body.boxes]
            parts += [f'<cylinder radius="{r}" length="{HEIGHT}"/>' for _, _, r in body.discs]
            places = [place.format(*part[:2]) for part in body.boxes + body.discs]
        shapes = "".join(f"<collision><{at}<geometry>{part}</geometry></collision>" for at, part in zip(places, parts))
        path = folder / "body.urdf"
        path.write_text(f'<robot name="body"><link name="body"><inertial><mass value="{MASS}"/>'
                        f'<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>{shapes}</link></robot>')
        return self.p.loadURDF(str(path))

    _folder = None

    @classmethod
    def folder(cls):
        cls._folder = cls._folder or tempfile.TemporaryDirectory()
        return cls._folder.name

    def step(self, travel, moving):
        p, (x, y) = self.p, self.start
        x, y, _ = turned((x + travel, y, 0), self.heading)
        p.resetBasePositionAndOrientation(self.tip, [x, y, (TIP_LOW + TIP_HIGH) / 2],
                                          p.getQuaternionFromEuler([0, 0, self.heading]))
        speed = SPEED if moving else 0.0
        # Gravity pulls at the tip before the step is made.
        velocity = [speed * math.cos(self.heading), speed * math.sin(self.heading), GRAVITY * self.dt]
        p.resetBaseVelocity(self.tip, velocity, [0, 0, 0])
        p.stepSimulation()

    def poses(self):
        out = []
        for body in self.bodies:
            (x, y, _), q = self.p.getBasePositionAndOrientation(body)
            out.append((x, y, yaw(q[3], *q[:3])))
        return out

    def set_velocity(self, velocity):
        self.p.resetBaseVelocity(self.bodies[0], [*velocity[:2], 0], [0, 0, velocity[2]])

    def velocity(self):
        (vx, vy, _), (_, _, w) = self.p.getBaseVelocity(self.bodies[0])
        return np.array([vx, vy, w])


def inner(corners, shrink):
    """A convex outline with its sides moved inwards."""
    lines = []
    for (ax, ay), (bx, by) in zip(corners, corners[1:] + corners[:1]):
        nx, ny = (ay - by) / math.dist((ax, ay), (bx, by)), (bx - ax) / math.dist((ax, ay), (bx, by))
        lines.append((nx, ny, nx * ax + ny * ay + shrink))
    pairs = zip(lines[-1:] + lines[:-1], lines)
    return [tuple(np.linalg.solve([a[:2], b[:2]], [a[2], b[2]])) for a, b in pairs]


def wavefront(outlines):
    """An OBJ file with a prism for each outline."""
    lines, first = [], 1
    for i, corners in enumerate(outlines):
        n = len(corners)
        lines += [f"o part{i}"] + [f"v {x} {y} {z}" for z in (-HEIGHT / 2, HEIGHT / 2) for x, y in corners]
        faces = [(0, k + 1, k) for k in range(1, n - 1)] + [(n, n + k, n + k + 1) for k in range(1, n - 1)]
        for k in range(n):
            j = (k + 1) % n
            faces += [(k, j, n + j), (k, n + j, n + k)]
        lines += [f"f {first + a} {first + b} {first + c}" for a, b, c in faces]
        first += 2 * n
    return "\n".join(lines) + "\n"


def yaw(w, x, y, z):
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


class MuJoCo(Stepped):
    """By default with a tip that is a mocap body, as most do it; with `joint` the tip is heavy, on a slide joint, and
    has its velocity."""

    def __init__(self, push, heading, options="", joint=False, dt=None):
        import mujoco

        self.mujoco, self.heading, self.joint = mujoco, heading, joint
        x, y, _ = turned((*push.start, 0), heading)
        degrees = math.degrees
        parts = []
        for body, pose in push.bodies:
            bx, by, theta = turned(pose, heading)
            shapes = [("box", a, b, f"{hx} {hy} {HEIGHT / 2}") for a, b, hx, hy in body.boxes]
            shapes += [("cylinder", a, b, f"{r} {HEIGHT / 2}") for a, b, r in body.discs]
            geoms = "".join(f'<geom type="{kind}" pos="{a} {b} 0" size="{size}" mass="0" friction="{BODIES}"/>'
                            for kind, a, b, size in shapes)
            inertia = " ".join(map(str, body.inertia))
            parts.append(f'<body pos="{bx} {by} {HEIGHT / 2}" euler="0 0 {degrees(theta)}"><freejoint/>'
                         f'<inertial pos="0 0 0" mass="{MASS}" diaginertia="{inertia}"/>{geoms}</body>')
        kind = 'mocap="true"' if not joint else ""
        slide = '<joint type="slide" axis="1 0 0"/>' if joint else ""
        step = f'timestep="{dt}"' if dt else ""
        tip = f"{TIP_LONG / 2} {TIP_WIDE / 2} {(TIP_HIGH - TIP_LOW) / 2}"
        self.model = mujoco.MjModel.from_xml_string(f"""<mujoco><option gravity="0 0 {-GRAVITY}" {step} {options}/>
          <worldbody><geom type="plane" size="2 2 .1" friction="{GROUND}"/>{''.join(parts)}
          <body {kind} pos="{x} {y} {(TIP_LOW + TIP_HIGH) / 2}" euler="0 0 {degrees(heading)}">{slide}
            <geom type="box" size="{tip}" mass="1000" friction="{TIP}"/>
          </body></worldbody></mujoco>""")
        self.data = mujoco.MjData(self.model)
        self.dt = self.model.opt.timestep
        self.count, self.start = len(push.bodies), push.start

    def step(self, travel, moving):
        if self.joint:
            self.data.qpos[-1], self.data.qvel[-1] = travel, SPEED if moving else 0.0
        else:
            x, y = self.start
            self.data.mocap_pos[0][:2] = turned((x + travel, y, 0), self.heading)[:2]
        self.mujoco.mj_step(self.model, self.data)

    def poses(self):
        q = self.data.qpos[:7 * self.count].reshape(-1, 7)
        return [(x, y, yaw(*r)) for x, y, _, *r in q]

    def set_velocity(self, velocity):
        self.data.qvel[:6] = [*velocity[:2], 0, 0, 0, velocity[2]]

    def velocity(self):
        return self.data.qvel[[0, 1, 5]].copy()


class Drake(Stepped):
    """`contact`: "default" is point contact; "feet" the same with a small sphere under every corner; "patch" is
    hydroelastic contact: compliant bodies, by default of 1e6 Pa, on a rigid ground and before a rigid tip."""

    def __init__(self, push, heading, contact="default", dt=0.001, approximation=None, modulus=1e6):
        warnings.filterwarnings("ignore")
        logging.getLogger("drake").setLevel(logging.ERROR)
        from pydrake.geometry import (AddCompliantHydroelasticProperties, AddContactMaterial,
                                      AddRigidHydroelasticProperties, Box, CollisionFilterDeclaration, Cylinder,
                                      GeometrySet, HalfSpace, ProximityProperties, Sphere)
        from pydrake.math import RigidTransform, RotationMatrix
        from pydrake.multibody.math import SpatialVelocity
        from pydrake.multibody.plant import (AddMultibodyPlant, ContactModel, CoulombFriction, MultibodyPlantConfig)
        from pydrake.multibody.tree import FixedOffsetFrame, PrismaticJoint, SpatialInertia, UnitInertia
        from pydrake.systems.analysis import Simulator
        from pydrake.systems.framework import DiagramBuilder

        self.SpatialVelocity, self.heading, self.dt = SpatialVelocity, heading, dt
        builder = DiagramBuilder()
        config = MultibodyPlantConfig(time_step=dt)
        if contact == "patch":
            config.contact_model = "hydroelastic_with_fallback"
        if approximation:
            config.discrete_contact_approximation = approximation
        plant, graph = AddMultibodyPlant(config, builder)
        plant.mutable_gravity_field().set_gravity_vector([0, 0, -GRAVITY])
        patch = contact == "patch"

        def properties(friction, rigid=False):
            found = ProximityProperties()
            AddContactMaterial(None, None, CoulombFriction(friction, friction), found)
            if patch and rigid:
                AddRigidHydroelasticProperties(0.005, found)
            elif patch:
                AddCompliantHydroelasticProperties(0.005, modulus, found)
            return found

        def register(body, at, shape, name, friction, rigid=False):
            return plant.RegisterCollisionGeometry(body, RigidTransform(at), shape, name, properties(friction, rigid))

        # Drake combines two coefficients a and b to 2 a b / (a + b): with one geometry a body, ground and bodies cannot
        # have 0.55 and 0.25. So what stands and what touches others are geometries of their own, except by default.
        single = contact == "default"
        side, foot = (0.5, None) if single else (BODIES, GROUND)
        combined = lambda pair: pair * side / (2 * side - pair)
        table = combined(GROUND) if single else GROUND
        ground = register(plant.world_body(), [0, 0, 0], HalfSpace(), "ground", table, True)
        sides, feet = [], []
        self.bodies = []
        for i, (body, _) in enumerate(push.bodies):
            ix, iy, iz = (moment / MASS for moment in body.inertia)
            link = plant.AddRigidBody(f"body{i}", SpatialInertia(MASS, [0, 0, 0], UnitInertia(ix, iy, iz)))
            self.bodies.append(link)
            shapes = [([x, y], Box(2 * hx, 2 * hy, HEIGHT)) for x, y, hx, hy in body.boxes]
            shapes += [([x, y], Cylinder(r, HEIGHT)) for x, y, r in body.discs]
            for k, (at, shape) in enumerate(shapes):
                sides.append(register(link, [*at, 0], shape, f"side{k}", side))
            if contact == "feet":
                for k, at in enumerate(self.support(body)):
                    feet.append(register(link, [*at, 0.001 - HEIGHT / 2], Sphere(0.001), f"foot{k}", foot))
            if patch:
                for k, (at, shape) in enumerate(shapes):
                    feet.append(register(link, [*at, 0], shape, f"foot{k}", foot))
        x, y, _ = turned((*push.start, 0), heading)
        tip = plant.AddRigidBody("tip", SpatialInertia(1000, [0, 0, 0], UnitInertia.SolidBox(1, 1, 1)))
        sides.append(register(tip, [0, 0, 0], Box(TIP_LONG, TIP_WIDE, TIP_HIGH - TIP_LOW), "tip", combined(TIP), True))
        place = RigidTransform(RotationMatrix.MakeZRotation(heading), [x, y, (TIP_LOW + TIP_HIGH) / 2])
        before = plant.AddFrame(FixedOffsetFrame("before", plant.world_frame(), place))
        self.joint = plant.AddJoint(PrismaticJoint("push", before, tip.body_frame(), [1, 0, 0]))
        if not single:
            manager = graph.collision_filter_manager()
            # Feet meet the ground alone, sides one another alone.
            manager.Apply(CollisionFilterDeclaration().ExcludeBetween(GeometrySet(sides), GeometrySet([ground, *feet])))
            manager.Apply(CollisionFilterDeclaration().ExcludeWithin(GeometrySet(feet)))
        plant.Finalize()
        self.plant = plant
        self.approximation = plant.get_discrete_contact_approximation()
        self.simulator = Simulator(builder.Build())
        self.context = plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        for link, (_, pose) in zip(self.bodies, push.bodies):
            bx, by, theta = turned(pose, heading)
            plant.SetFreeBodyPose(self.context, link,
                                  RigidTransform(RotationMatrix.MakeZRotation(theta), [bx, by, HEIGHT / 2]))
        self.steps = 0

    @staticmethod
    def support(body):
        """Where a body stands: at its outermost corners, a disc at eight points of its rim."""
        corners = [(x + i * hx, y + j * hy) for x, y, hx, hy in body.boxes for i in (-1, 1) for j in (-1, 1)]
        if corners:
            low, high = np.min(corners, axis=0), np.max(corners, axis=0)
            return [(a, b) for a in (low[0], high[0]) for b in (low[1], high[1])]
        (x, y, r), = body.discs
        return [(x + r * math.cos(k * math.pi / 4), y + r * math.sin(k * math.pi / 4)) for k in range(8)]

    def step(self, travel, moving):
        self.joint.set_translation(self.context, travel)
        self.joint.set_translation_rate(self.context, SPEED if moving else 0.0)
        self.steps += 1
        self.simulator.AdvanceTo(self.steps * self.dt)

    def poses(self):
        out = []
        for body in self.bodies:
            pose = self.plant.EvalBodyPoseInWorld(self.context, body)
            x, y, _ = pose.translation()
            q = pose.rotation().ToQuaternion()
            out.append((x, y, yaw(q.w(), q.x(), q.y(), q.z())))
        return out

    def set_velocity(self, velocity):
        self.plant.SetFreeBodySpatialVelocity(
            context=self.context, body=self.bodies[0],
            V_JpJc=self.SpatialVelocity([0, 0, velocity[2]], [*velocity[:2], 0]))

    def velocity(self):
        found = self.plant.EvalBodySpatialVelocityInWorld(self.context, self.bodies[0])
        return np.array([*found.translational()[:2], found.rotational()[2]])


# ---- theory: one body, friction on an ellipsoidal limit surface -----------------------------------------------------

def quasi_static_turn(push, rho):
    """The turn of a square that the lower corner of the tip pushes, where torque over force of the ground is `rho`."""
    x = y = theta = 0.0
    tip = np.array([-S, push.start[1] - TIP_WIDE / 2])
    step, way = 1e-5, push.travel - GAP
    for _ in range(round(way / step)):
        arm = tip - (x, y)
        normal = np.array([math.cos(theta), math.sin(theta)])
        side = np.array([-normal[1], normal[0]])
        turn = np.array([-arm[1], arm[0]])
        # Velocity of the body's point at the tip for a force there, over the force.
        yielding = np.eye(2) + np.outer(turn, turn) / rho**2
        force = np.linalg.solve(yielding, [1.0, 0.0])
        if abs(force @ side) > TIP * (force @ normal):
            force = normal + math.copysign(TIP, force @ side) * side
            force *= normal[0] / (normal @ yielding @ force)
        x, y = (x, y) + step * force
        theta += step * (turn @ force) / rho**2
        tip = tip + (step, 0.0)
    return theta


def torque_radius(turn):
    """The torque over force for which the theory turns the square so far."""
    low, high = 0.002, 0.2
    for _ in range(40):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if abs(quasi_static_turn(TORQUE_PUSH, middle)) > abs(turn) else (low, middle)
    return middle


# ---- the engines, as the tables have them ---------------------------------------------------------------------------

GOOD_MUJOCO = {"options": 'cone="elliptic" impratio="10"', "joint": True, "dt": 0.001}


def jostle(engine, preset):
    return lambda push, heading: Jostle(push, heading, engine, preset)


def stepped(world, **settings):
    return lambda push, heading: world(push, heading, **settings)


ENGINES = {
    "planar": jostle("planar", "fine"),
    "prism": jostle("prism", "fine"),
    "rapier": jostle("rapier", "fine"),
    "Bullet": jostle("bullet", "reference"),
    "PyBullet hulls": stepped(PyBullet, hulls=True),
    "PyBullet": stepped(PyBullet),
    "MuJoCo": stepped(MuJoCo),
    "MuJoCo set": stepped(MuJoCo, **GOOD_MUJOCO),
    "Drake": stepped(Drake),
    "Drake feet": stepped(Drake, contact="feet", dt=0.00025),
    "Drake patch": stepped(Drake, contact="patch"),
}

# Nobody who judges pushes would leave these as they are: they are shown for what they do, and take no part in the
# middle.
DEFAULTS = ("MuJoCo", "Drake")

FINER = {
    "planar": {"fast": jostle("planar", "fast")},
    "prism": {"fast": jostle("prism", "fast")},
    "rapier": {"fast": jostle("rapier", "fast"), "balanced": jostle("rapier", "balanced")},
    "Bullet": {"fast": jostle("bullet", "fast")},
    "PyBullet hulls": {
        "1/480 s": stepped(PyBullet, hulls=True, dt=1 / 480),
        "1/960 s": stepped(PyBullet, hulls=True, dt=1 / 960),
        "500 sweeps, residual 0": stepped(PyBullet, hulls=True, iterations=500, residual=0),
    },
    "PyBullet": {
        "1/480 s": stepped(PyBullet, dt=1 / 480),
        "1/960 s": stepped(PyBullet, dt=1 / 960),
        "500 sweeps, residual 0": stepped(PyBullet, iterations=500, residual=0),
    },
    "MuJoCo": {
        "1 ms": stepped(MuJoCo, dt=0.001),
        "0.25 ms": stepped(MuJoCo, dt=0.00025),
        "1000 iterations, tolerance 0": stepped(MuJoCo, options='iterations="1000" tolerance="0"'),
    },
    "MuJoCo set": {
        "2 ms": stepped(MuJoCo, **{**GOOD_MUJOCO, "dt": 0.002}),
        "0.25 ms": stepped(MuJoCo, **{**GOOD_MUJOCO, "dt": 0.00025}),
        "1000 iterations, tolerance 0": stepped(
            MuJoCo, **{**GOOD_MUJOCO, "options": GOOD_MUJOCO["options"] + ' iterations="1000" tolerance="0"'}),
        "impratio 1": stepped(MuJoCo, **{**GOOD_MUJOCO, "options": 'cone="elliptic"'}),
        "pyramidal cone": stepped(MuJoCo, **{**GOOD_MUJOCO, "options": ""}),
        "mocap tip": stepped(MuJoCo, **{**GOOD_MUJOCO, "joint": False}),
    },
    "Drake": {"0.25 ms": stepped(Drake, dt=0.00025), "sap": stepped(Drake, approximation="sap")},
    "Drake feet": {
        "1 ms": stepped(Drake, contact="feet"),
        "0.1 ms": stepped(Drake, contact="feet", dt=0.0001),
        "sap": stepped(Drake, contact="feet", dt=0.00025, approximation="sap"),
    },
    "Drake patch": {
        "2 ms": stepped(Drake, contact="patch", dt=0.002),
        "0.5 ms": stepped(Drake, contact="patch", dt=0.0005),
        "1e5 Pa": stepped(Drake, contact="patch", modulus=1e5),
        "1e7 Pa": stepped(Drake, contact="patch", modulus=1e7),
        "sap": stepped(Drake, contact="patch", approximation="sap"),
    },
}


def versions(library):
    """What is installed, and the reason for what is not."""
    from importlib.metadata import PackageNotFoundError, version

    found, missing = {}, {}
    if library is None:
        missing["jostle"] = "no library was given"
    else:
        try:
            Jostle.load(library)
            found["jostle"] = Jostle.library.jostle_version().decode()
        except OSError as error:
            missing["jostle"] = str(error)
    for package in ("pybullet", "mujoco", "drake"):
        try:
            __import__(package if package != "drake" else "pydrake")
            found[package] = version(package)
        except (ImportError, PackageNotFoundError) as error:
            missing[package] = str(error)
    if "pybullet" in found:
        import pybullet

        pybullet.connect(pybullet.DIRECT)
    return found, missing


def package_of(engine):
    name = engine.split()[0].lower()
    return name if name in ("pybullet", "mujoco", "drake") else "jostle"


def run(make, push, degrees):
    """Changes of all bodies, or the reason why there are none."""
    heading = math.radians(degrees)
    try:
        poses = make(push, heading).push(push, heading)
    except RuntimeError as error:
        return str(error)
    return [change(turned(start, heading), end, heading) for (_, start), end in zip(push.bodies, poses)]


def distance(body, a, b):
    """Millimetres between two changes of a body: of place, and of heading times the radius of gyration."""
    return 1000 * (math.hypot(a[0] - b[0], a[1] - b[1]) + body.gyration * abs(math.remainder(a[2] - b[2], math.tau)))


# ---- the tables -----------------------------------------------------------------------------------------------------

def table(heads, rows):
    print("| " + " | ".join(heads) + " |")
    print("|" + "---|" * len(heads))
    for cells in rows:
        print("| " + " | ".join(cells) + " |")
    print(flush=True)


def tenths(value):
    """With one digit, and no minus before a zero."""
    return f"{round(value, 1) + 0.0:.1f}"


def lines_of(pushes):
    """A line for every body of every push: push, index of the body, label."""
    for push in pushes:
        for i, (body, _) in enumerate(push.bodies):
            label = push.name if len(push.bodies) == 1 else f"{push.name}: {i + 1}, {body.name}"
            yield push, i, label


def print_pushes(engines, results):
    """Places and turns, the spread and who is farthest from the median of all."""
    for title, cell in (("Along and across the push, mm", lambda c: f"{tenths(1000 * c[0])}, {tenths(1000 * c[1])}"),
                        ("Turn, degrees", lambda c: tenths(math.degrees(c[2])))):
        print(f"### {title}\n")
        rows = []
        for push, i, label in lines_of(PUSHES):
            got = [results[name][push.name] for name in engines]
            rows.append([label] + [cell(r[i]) if isinstance(r, list) else r for r in got])
        table(["push", *engines], rows)
    print("### Spread and outliers\n")
    rows = []
    far = {name: [] for name in engines}
    for push, i, label in lines_of(PUSHES):
        body = push.bodies[i][0]
        got = {name: results[name][push.name][i] for name in engines if isinstance(results[name][push.name], list)}
        set_ones = [c for name, c in got.items() if name not in DEFAULTS] or list(got.values())
        middle = [statistics.median(c[k] for c in set_ones) for k in range(3)]
        away = {name: distance(body, c, middle) for name, c in got.items()}
        for name, d in away.items():
            far[name].append((d, push.name))
        order = sorted(away, key=away.get, reverse=True)
        rows.append([label, spread(set_ones), spread(got.values()), f"{statistics.median(away.values()):.1f}",
                     ", ".join(f"{name} {away[name]:.1f}" for name in order[:3])])
    table(["push", "spread without defaults: along, across, turn", "spread of all", "median from the middle, mm",
           "farthest from the middle, mm"], rows)
    print("### How far each is from the middle, mm\n")
    rows = [[name, f"{statistics.median(d for d, _ in found):.1f}", "{:.1f} ({})".format(*max(found))]
            for name, found in far.items() if found]
    table(["engine", "median", "greatest"], rows)


def spread(changes):
    along, across, turn = (max(values) - min(values) for values in zip(*changes))
    return f"{1000 * along:.1f} mm, {1000 * across:.1f} mm, {math.degrees(turn):.1f}°"


DIFFERENCE = ["median, mm", "greatest, mm", "greatest turn, degrees"]
SHIFTED = "the tip 0.1 mm to the left"


def difference(results, others):
    """How far the changes of all pushes lie apart: the cells of DIFFERENCE."""
    away, turns = [], []
    for push in PUSHES:
        a, b = results[push.name], others[push.name]
        if isinstance(a, list) and isinstance(b, list):
            away += [(distance(body, one, other), push.name) for (body, _), one, other in zip(push.bodies, a, b)]
            turns += [abs(math.degrees(one[2] - other[2])) for one, other in zip(a, b)]
    worst, where = max(away)
    return f"{statistics.median(d for d, _ in away):.2f}", f"{worst:.1f} ({where})", f"{max(turns):.1f}"


def print_headings(engines, results):
    rows = []
    for name in engines:
        for degrees in HEADINGS[1:]:
            found = {push.name: run(ENGINES[name], push, degrees) for push in PUSHES}
            rows.append([name, f"{degrees}°", *difference(results[name], found)])
    table(["engine", "heading", *DIFFERENCE], rows)


def print_torque(engines):
    """Torque over force of the ground's friction on a square, in radii of gyration."""
    gyration = SQUARE.gyration
    rows = []
    for name in engines:
        result = run(ENGINES[name], TORQUE_PUSH, 0)
        if not isinstance(result, list):
            rows.append([name, result, "", "", "", ""])
            continue
        turn = result[0][2]
        cells = [name, f"{abs(math.degrees(turn)):.1f}", f"{torque_radius(turn) / gyration:.2f}"]
        if package_of(name) == "jostle":
            cells += ["", "", ""]
        else:
            world = lambda: ENGINES[name](TORQUE_PUSH, 0.0)
            slide = world().free(np.array([0.5, 0, 0]))
            slant = world().free(np.array([0.5, 0.5, 0]) / math.sqrt(2))
            spin = world().free(np.array([0, 0, 20.0]))
            force, torque = MASS * slide, SQUARE.inertia[2] * spin
            cells += [f"{slide / GRAVITY:.3f}", f"{slant / GRAVITY:.3f}", f"{torque / force / gyration:.2f}"]
        rows.append(cells)
    theories = ("theory: uniform pressure", 0.3826 * 2 * S), ("theory: pressure at the corners", math.sqrt(2) * S)
    for name, rho in theories:
        turn = quasi_static_turn(TORQUE_PUSH, rho)
        rows.append([name, f"{abs(math.degrees(turn)):.1f}", f"{rho / gyration:.2f}", f"{GROUND:.3f}", f"{GROUND:.3f}",
                     f"{rho / gyration:.2f}"])
    table(["engine", "turn, degrees", "torque over force by the push", "friction sliding along x", "at 45°",
           "torque over force spinning"], rows)


def print_finer(engines, results):
    rows = []
    for name in engines:
        others = {SHIFTED: ENGINES[name], **FINER.get(name, {})}
        for label, make in others.items():
            found = {push.name: run(make, push.shifted() if label == SHIFTED else push, 0) for push in PUSHES}
            rows.append([name, label, *difference(results[name], found)])
    table(["engine", "changed to", *DIFFERENCE], rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("library", nargs="?", help="jostle's shared library")
    parser.add_argument("--only", help="names of engines, with commas between [default: all that are installed]")
    parser.add_argument("--part", default="pushes,headings,torque,finer", help="which tables [default: all]")
    args = parser.parse_args()

    found, missing = versions(args.library)
    print("Versions: " + ", ".join(f"{name} {version}" for name, version in found.items()) + "\n")
    for package, reason in missing.items():
        print(f"Left out: {package} ({reason})\n")
    wanted = args.only.split(",") if args.only else list(ENGINES)
    if unknown := set(wanted) - set(ENGINES):
        parser.error(f"no engine is named {', '.join(sorted(unknown))}; known: {', '.join(ENGINES)}")
    engines = [name for name in wanted if package_of(name) in found]
    if not engines:
        parser.exit(1, "none of these engines is installed\n")
    parts = args.part.split(",")
    results, seconds = {}, {}
    if {"pushes", "headings", "finer"} & set(parts):
        for name in engines:
            begin = time.thread_time()
            results[name] = {push.name: run(ENGINES[name], push, 0) for push in PUSHES}
            seconds[name] = (time.thread_time() - begin) / len(PUSHES)
    for part, title, show in (
        ("pushes", "Twelve pushes", lambda: print_pushes(engines, results)),
        ("torque", "Torque over force", lambda: print_torque(engines)),
        ("headings", "The same at other headings", lambda: print_headings(engines, results)),
        ("finer", "Other steps and settings", lambda: print_finer(engines, results)),
    ):
        if part in parts:
            print(f"## {title}\n")
            show()
    if seconds:
        print("Seconds of the processor a push: " + ", ".join(f"{name} {s:.2f}" for name, s in seconds.items()))


if __name__ == "__main__":
    main()
