"""MuJoCo: flex, three-dimensional, St Venant–Kirchhoff tetrahedra; and its interpolated flex of quadratic cells.

Its flex gives all nodes the same mass. The masses of bodies can be changed after compilation, and are: a quarter of each
tetrahedron to each corner. So the exact solutions are those of everyone else; the first peak then agrees to the last digit.
"""

import mujoco

import beam

STVK = "st-venant-kirchhoff"
BOTH = ["peak", "rest"]

EXPLICIT = "integrator Euler (semi-implicit), f64, contact off, masses of the volumes"
RK4 = "integrator RK4, f64, contact off, masses of the volumes"
DISCRETE = "integrator discrete (backward Euler, one linearised solve), CG, {} iterations, tolerance {:g}, f64, contact off, masses of the volumes"
MIDPOINT = "discrete for half a step, then positions and velocities reflected by our script: implicit midpoint, CG, {} iterations, tolerance {:g}, f64, contact off, masses of the volumes"
QUADRATIC = "{} quadratic cells along the beam ({} nodes) instead of tetrahedra, f64, contact off; errors are against the exact beam; {}"


def tetrahedra(method, mesh, steps, measures, iterations=100, tolerance=1e-8, **more):
    """Runs of the flex of tetrahedra."""
    describe = {"explicit": EXPLICIT, "rk4": RK4, "implicit": DISCRETE, "midpoint": MIDPOINT}[method]
    names = {
        "explicit": "explicit",
        "rk4": "RK4",
        "implicit": f"implicit ({iterations} iterations, {tolerance:g})",
        "midpoint": f"implicit, reflected ({iterations} iterations, {tolerance:g})",
    }
    return beam.plan(
        names[method], mesh, steps, measures, describe.format(iterations, tolerance), STVK,
        method=method, iterations=iterations, tolerance=tolerance, **more,
    )


def cells(method, count, steps, measures, describe):
    """Runs of the interpolated flex."""
    describe = QUADRATIC.format(count, 9 * (2 * count + 1), describe)
    return beam.plan(
        f"{count} quadratic cells, {method}", "own", steps, measures, describe, "beam",
        method=method, cells=count, iterations=100, tolerance=1e-8,
    )


RUNS = [
    *tetrahedra("explicit", "S", [0.1, 0.2, 0.3, 0.35], ["peak"]),
    *tetrahedra("rk4", "S", [0.4], ["peak"]),
    *tetrahedra("implicit", "S", [1, 2, 5, 10], ["peak"]),
    *tetrahedra("implicit", "S", [20, 50], BOTH),
    *tetrahedra("implicit", "S", [100, 200, 500, 1000], ["rest"]),
    *tetrahedra("implicit", "S", [500], ["rest"], 50),
    *tetrahedra("implicit", "S", [200, 500, 1000], ["rest"], 1000),
    *tetrahedra("midpoint", "S", [2, 3, 4, 5, 10], ["peak"], 100, 1e-2),
    *tetrahedra("midpoint", "S", [4, 10], ["peak"], 1000),
    *tetrahedra("explicit", "M", [0.05, 0.1, 0.15], ["peak"]),
    *tetrahedra("implicit", "M", [1, 2, 5, 10], ["peak"]),
    *tetrahedra("implicit", "M", [20, 50], BOTH, 300),
    *tetrahedra("implicit", "M", [100, 200, 500, 1000], ["rest"], 300),
    *tetrahedra("implicit", "M", [500], ["rest"], 150),
    *tetrahedra("implicit", "M", [200, 500, 1000], ["rest"], 3000, 1e-2),
    *tetrahedra("midpoint", "M", [2, 4, 5, 10], ["peak"], 100, 1e-2),
    *tetrahedra("midpoint", "M", [4], ["peak"], 50, 1e-2),
    *tetrahedra("midpoint", "M", [4, 10], ["peak"], 1000, 1e-2),
    *tetrahedra("explicit", "L", [0.08], ["peak"]),
    *tetrahedra("explicit", "L", [0.05], ["peak"], slow="takes half a minute, and 0.08 ms are exact enough"),
    *tetrahedra("implicit", "L", [5, 10], ["peak"]),
    *tetrahedra("midpoint", "L", [4], ["peak"], 300, 1e-2),
    *tetrahedra("implicit", "L", [100, 200, 500], ["rest"], 3000, 1e-2),
    *tetrahedra("implicit", "L", [200, 500], ["rest"], 600),
    *tetrahedra("midpoint", "L", [4], ["peak"], 100, 1e-2),
    *cells("explicit", 3, [0.1, 0.4], ["peak"], "integrator Euler (semi-implicit)"),
    *cells("implicit", 3, [1, 2, 5, 10], ["peak"], "integrator discrete"),
    *cells("implicit", 3, [50, 100, 200, 500], ["rest"], "integrator discrete"),
    *cells("midpoint", 3, [2, 5, 10, 20], ["peak"], "discrete for half a step, then reflected by our script"),
    *cells("midpoint", 2, [5, 10], ["peak"], "discrete for half a step, then reflected by our script"),
]


class Engine:
    """One body in MuJoCo."""

    version = mujoco.__version__

    def __init__(self, what, folder):
        settings = what["engine"]
        self.reflects = settings["method"] == "midpoint"
        integrator = {"explicit": "Euler", "rk4": "RK4"}.get(settings["method"], "discrete")
        step = what["step"] / 2 if self.reflects else what["step"]
        flex = self.own_cells(settings["cells"]) if what["mesh"] == "own" else self.tetrahedra(what, folder)
        self.model = mujoco.MjModel.from_xml_string(f"""
            <mujoco>
              <option integrator="{integrator}" timestep="{step}" solver="CG" iterations="{settings["iterations"]}"
                      tolerance="{settings["tolerance"]}" gravity="0 0 {-beam.GRAVITY}">
                <flag contact="disable"/>
              </option>
              <size memory="2G"/>
              <worldbody>
                <flexcomp name="beam" dim="3" mass="{beam.DENSITY * beam.SIZE[0] * beam.SIZE[1] * beam.SIZE[2]}" radius="1e-5" {flex}
                  <contact selfcollide="none" contype="0" conaffinity="0"/>
                  <elasticity young="{beam.YOUNG}" poisson="{beam.POISSON}"/>
                </flexcomp>
              </worldbody>
            </mujoco>""")
        self.data = mujoco.MjData(self.model)
        if what["mesh"] != "own":
            bodies = self.model.flex_vertbodyid
            for node, mass in enumerate(self.mesh.masses()):
                # A clamped node belongs to the world.
                if bodies[node] != 0:
                    self.model.body_mass[bodies[node]] = mass
            mujoco.mj_setConst(self.model, self.data)
        self.reset()
        x = self.data.flexvert_xpos[:, 0]
        self.end = x > x.max() - 1e-6 * beam.SIZE[0]
        self.start = self.data.flexvert_xpos[self.end, 2].mean()

    def tetrahedra(self, what, folder):
        self.mesh = beam.Mesh(folder / f"cantilever-{what['mesh']}.msh")
        points = " ".join(map(repr, self.mesh.nodes.ravel().tolist()))
        elements = " ".join(map(str, self.mesh.tets.ravel().tolist()))
        pins = " ".join(map(str, self.mesh.clamped.tolist()))
        return f'type="direct" point="{points}" element="{elements}"> <pin id="{pins}"/>'

    @staticmethod
    def own_cells(cells):
        # The grid of points is what is drawn; the freedoms are those of the cells.
        count = (16, 4, 4)
        spacing = " ".join(str(size / (n - 1)) for size, n in zip(beam.SIZE, count))
        return (
            f'type="grid" dof="quadratic" cellcount="{cells} 1 1" count="{" ".join(map(str, count))}" spacing="{spacing}">'
            '<pin gridrange="0 0 0 0 2 2"/>'
        )

    def reset(self):
        mujoco.mj_resetData(self.model, self.data)
        mujoco.mj_forward(self.model, self.data)

    def advance(self, steps):
        if not self.reflects:
            mujoco.mj_step(self.model, self.data, steps)
            return
        for _ in range(steps):
            positions, velocities = self.data.qpos.copy(), self.data.qvel.copy()
            mujoco.mj_step(self.model, self.data)
            self.data.qpos[:] = 2 * self.data.qpos - positions
            self.data.qvel[:] = 2 * self.data.qvel - velocities

    def sag(self):
        # Positions of nodes are those at the start of the last step otherwise.
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_flex(self.model, self.data)
        return self.start - self.data.flexvert_xpos[self.end, 2].mean()


if __name__ == "__main__":
    beam.main(Engine, RUNS)
