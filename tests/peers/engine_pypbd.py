"""PositionBasedDynamics (pyPBD): XPBD with the St Venant–Kirchhoff energy of each tetrahedron as its constraint.

It leaves a constraint out when its gradients, squared, fall below 1e-6 in whatever unit is used, and its gravity is (0, −9.81, 0).
Both are met by other units: lengths in millimetres, times in 1/√1000 s, and the beam turned so that down is −y. In metres the same
beam falls as if it had no stiffness at all.
"""

import math
from importlib import metadata

import numpy
import pypbd

import beam

SCALE = 1000.0
DESCRIBE = "XPBD of the element energy, {} iterations per step, velocities of {} order, f64, lengths in mm, masses of the volumes"


def runs(mesh, steps, iterations, order=1, measures=("peak",), **more):
    """Runs with a number of iterations."""
    describe = DESCRIBE.format(iterations, {1: "first", 2: "second"}[order])
    name = "XPBD, 1 iteration" if iterations == 1 else f"XPBD, {iterations} iterations"
    return beam.plan(
        name, mesh, steps, list(measures), describe, "st-venant-kirchhoff", iterations=iterations, order=order, **more
    )


RUNS = [
    *runs("S", [0.05, 0.1, 0.14, 0.18, 0.2, 0.5, 1], 1),
    *runs("S", [0.5], 8),
    *runs("S", [1], 10),
    *runs("S", [2], 50),
    *runs("S", [5], 100),
    *runs("S", [0.2], 1, order=2),
    *runs("S", [20], 100, measures=["rest"]),
    *runs("S", [1], 10, measures=["rest"]),
    *runs("M", [0.025, 0.05, 0.1, 0.2], 1),
    *runs("M", [0.5], 10),
    *runs("M", [1], 10, measures=["rest"], slow="takes a minute; it does not come to rest on S either"),
    *runs("L", [0.05, 0.1], 1),
    *runs("L", [0.025], 1, slow="takes a minute"),
]


class Engine:
    """One body in pyPBD."""

    version = metadata.version("pypbd")

    def __init__(self, what, folder):
        self.mesh = beam.Mesh(folder / f"cantilever-{what['mesh']}.msh")
        x, y, z = self.mesh.nodes.T
        self.start = self.mesh.nodes[self.mesh.end, 2].mean()
        simulation = pypbd.Simulation.getCurrent()
        simulation.initDefault()
        self.model = simulation.getModel()
        tets = [int(node) for node in self.mesh.tets.ravel()]
        body = self.model.addTetModel(list(SCALE * numpy.stack([x, z, -y], axis=1)), tets)
        self.particles = self.model.getParticles()
        for node, mass in enumerate(self.mesh.masses()):
            self.particles.setMass(node, mass)
        # Without mass a particle stands still.
        for node in self.mesh.clamped:
            self.particles.setMass(int(node), 0.0)
        # kg/(m s²) in kg, millimetres and 1/√1000 s. 3 is XPBD of the element energy.
        young = beam.YOUNG / SCALE**2
        self.model.addSolidConstraints(body, 3, young, beam.POISSON, young, False, False)
        settings, names = what["engine"], pypbd.TimeStepController
        self.controller = simulation.getTimeStep()
        self.controller.setValueUInt(names.NUM_SUB_STEPS, 1)
        self.controller.setValueUInt(names.MAX_ITERATIONS, settings["iterations"])
        self.controller.setValueUInt(names.MAX_ITERATIONS_V, 0)
        if settings["order"] == 2:
            self.controller.setValueInt(names.VELOCITY_UPDATE_METHOD, names.ENUM_VUPDATE_SECOND_ORDER)
        pypbd.TimeManager.getCurrent().setTimeStepSize(what["step"] * math.sqrt(SCALE))

    def reset(self):
        self.model.reset()

    def advance(self, steps):
        for _ in range(steps):
            self.controller.step(self.model)

    def sag(self):
        heights = [self.particles.getPosition(int(node))[1] for node in self.mesh.end]
        return self.start - sum(heights) / len(heights) / SCALE


if __name__ == "__main__":
    beam.main(Engine, RUNS)
