"""Drake: deformable bodies, linear tetrahedra, corotational.

Its time step is built in: velocities from the forces at the end of the step, positions from the mean of old and new velocity.
Its mass matrix is not lumped; the first peak of the corotational beam on S tends to the same 47.6 mm. Its neo-Hookean law rests at
29.3 mm on S, where that of the reference rests at 25.1: left out.
"""

from importlib import metadata

import numpy
from pydrake.geometry import AddContactMaterial, GeometryInstance, Mesh, ProximityProperties
from pydrake.math import RigidTransform
from pydrake.multibody.fem import DeformableBodyConfig, MaterialModel
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    CoulombFriction,
    DiscreteContactApproximation,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

import beam

LINEAR = ("kLinearCorotated", "linear corotational: rotations of the last step, one linear solve (Cholesky), f64, no contact")
FULL = ("kCorotated", "corotational, Newton to convergence (Cholesky), f64, no contact")
BOTH = ["peak", "rest"]


def runs(mesh, steps, measures, material=LINEAR, **more):
    """Runs of a material."""
    name = {"kLinearCorotated": "linear corotational", "kCorotated": "corotational"}[material[0]]
    return beam.plan(name, mesh, steps, measures, material[1], "corotational", material=material[0], **more)


RUNS = [
    *runs("S", [1, 2, 4, 5, 10], ["peak"]),
    *runs("S", [20, 50], BOTH),
    *runs("S", [100, 200, 500], ["rest"]),
    *runs("S", [2, 4, 10], ["peak"], FULL),
    *runs("S", [50, 200, 500], ["rest"], FULL),
    *runs("M", [4, 5, 10], ["peak"]),
    *runs("M", [20], ["peak"]),
    *runs("M", [50, 100, 200], ["rest"]),
    *runs("M", [2], ["peak"], slow="takes half a minute, and 4 ms are exact enough"),
    *runs("M", [10], ["peak"], FULL, slow="takes a minute"),
    *runs("L", [200], ["rest"], cap=600.0),
    *runs("L", [4, 5, 10, 20], ["peak"], slow="takes two minutes and more, 5 s to 8 s for each step"),
    *runs("L", [100], ["rest"], slow="takes two minutes and more, 5 s to 8 s for each step", cap=600.0),
]


class Engine:
    """One body in Drake."""

    version = metadata.version("drake")

    def __init__(self, what, folder):
        self.mesh = beam.Mesh(folder / f"cantilever-{what['mesh']}.msh")
        path = folder / f"cantilever-{what['mesh']}.vtk"
        self.write_vtk(path)
        self.step = what["step"]
        builder = DiagramBuilder()
        self.plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=self.step)
        # Bodies that deform need one of the convex approximations, whether or not they touch anything.
        self.plant.set_discrete_contact_approximation(DiscreteContactApproximation.kLagged)
        config = DeformableBodyConfig()
        config.set_youngs_modulus(beam.YOUNG)
        config.set_poissons_ratio(beam.POISSON)
        config.set_mass_density(beam.DENSITY)
        config.set_material_model(getattr(MaterialModel, what["engine"]["material"]))
        geometry = GeometryInstance(RigidTransform(), Mesh(str(path), 1.0), "beam")
        proximity = ProximityProperties()
        AddContactMaterial(0.0, None, CoulombFriction(0, 0), proximity)
        geometry.set_proximity_properties(proximity)
        self.bodies = self.plant.mutable_deformable_model()
        self.body = self.bodies.RegisterDeformableBody(geometry, config, 1.0)
        clamp = numpy.array([1e-5 * beam.SIZE[0], 0.0, 0.0])
        self.bodies.SetWallBoundaryCondition(self.body, clamp, numpy.array([1.0, 0.0, 0.0]))
        self.plant.Finalize()
        self.diagram = builder.Build()
        self.start = self.mesh.nodes[self.mesh.end, 2].mean()

    def write_vtk(self, path):
        nodes, tets = self.mesh.nodes, self.mesh.tets
        with open(path, "w") as file:
            file.write("# vtk DataFile Version 3.0\nbeam\nASCII\nDATASET UNSTRUCTURED_GRID\n")
            file.write(f"POINTS {len(nodes)} double\n")
            file.writelines(f"{x!r} {y!r} {z!r}\n" for x, y, z in nodes.tolist())
            file.write(f"CELLS {len(tets)} {5 * len(tets)}\n")
            file.writelines("4 {} {} {} {}\n".format(*tet) for tet in tets.tolist())
            file.write(f"CELL_TYPES {len(tets)}\n" + "10\n" * len(tets))

    def reset(self):
        self.simulator = Simulator(self.diagram)
        self.simulator.Initialize()
        self.context = self.plant.GetMyContextFromRoot(self.simulator.get_context())
        self.steps = 0

    def advance(self, steps):
        self.steps += steps
        self.simulator.AdvanceTo(self.steps * self.step)

    def sag(self):
        return self.start - self.bodies.GetPositions(self.context, self.body)[2, self.mesh.end].mean()


if __name__ == "__main__":
    beam.main(Engine, RUNS)
