"""Static sags of cantilever.md and tube sags of two-tubes.md, made again with scikit-fem: another code, no line of ours.

    python3 -m venv VENV && VENV/bin/pip install scikit-fem==12.0.2 numpy scipy
    VENV/bin/python tests/data/reference/cantilever.py            # the coarse meshes; exit status 1 if a recorded digit differs
    VENV/bin/python tests/data/reference/cantilever.py --all      # the fine ones and quadratic hexahedra too: much longer

Newton's method on the equilibrium of large deformation: linear tetrahedra on the meshes beside this file, quadratic hexahedra on
refinements of one cell column (16 x 4 x 4 cells at refinement 2, each next one halves the cells). SI units.
"""

import json
import pathlib
import sys

import numpy
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementHex2, ElementTetP1, ElementVector, LinearForm, MeshHex, MeshTet
from skfem import condense
from skfem.helpers import ddot, grad, identity, transpose

HERE = pathlib.Path(__file__).parent
YOUNG, DENSITY, GRAVITY = 1e5, 1000.0, 9.81


def mul(a, b):
    return numpy.einsum("ij...,jk...->ik...", a, b)


def lame(nu):
    return YOUNG / (2 * (1 + nu)), YOUNG * nu / ((1 + nu) * (1 - 2 * nu))


def inverse(f):
    return numpy.moveaxis(numpy.linalg.inv(numpy.moveaxis(f, (0, 1), (-2, -1))), (-2, -1), (0, 1))


def determinant(f):
    return numpy.linalg.det(numpy.moveaxis(f, (0, 1), (-2, -1)))


def trace(a):
    return numpy.einsum("ii...->...", a)


def st_venant_kirchhoff(mu, lam):
    """First Piola-Kirchhoff stress and its derivative along dF, of energy mu E:E + lam/2 tr(E)^2."""

    def stress(f):
        e = 0.5 * (mul(transpose(f), f) - identity(f))
        return mul(f, 2 * mu * e + lam * trace(e) * identity(f))

    def tangent(f, df):
        e = 0.5 * (mul(transpose(f), f) - identity(f))
        de = 0.5 * (mul(transpose(df), f) + mul(transpose(f), df))
        s = 2 * mu * e + lam * trace(e) * identity(f)
        ds = 2 * mu * de + lam * trace(de) * identity(f)
        return mul(df, s) + mul(f, ds)

    return stress, tangent


def neo_hookean(mu, lam):
    """The same of mu/2 (tr C - 3) - mu ln J + lam/2 ln^2 J."""

    def stress(f):
        g = transpose(inverse(f))
        return mu * (f - g) + lam * numpy.log(determinant(f)) * g

    def tangent(f, df):
        i = inverse(f)
        g = transpose(i)
        dg = -mul(mul(g, transpose(df)), g)
        log = numpy.log(determinant(f))
        return mu * (df - dg) + lam * (trace(mul(i, df)) * g + log * dg)

    return stress, tangent


def numerically(stress):
    """A stress with its derivative along dF by central differences: Newton's method needs it to converge, not for where it ends."""

    def tangent(f, df):
        step = 1e-6 / max(numpy.abs(df).max(), 1e-300)
        return (stress(f + step * df) - stress(f - step * df)) / (2 * step)

    return stress, tangent


def rotation(f):
    """R of the polar decomposition F = R S of a matrix that inverts nothing."""
    u, _, vt = numpy.linalg.svd(numpy.moveaxis(f, (0, 1), (-2, -1)))
    return numpy.moveaxis(u @ vt, (-2, -1), (0, 1))


def corotational(mu, lam):
    def stress(f):
        r = rotation(f)
        return 2 * mu * (f - r) + lam * (trace(mul(transpose(r), f)) - 3) * r

    return numerically(stress)


def stable_neo_hookean(mu, lam):
    """Smith et al. 2018, with the logarithm, and their constants that agree with linear elasticity."""
    mu, lam = 4 * mu / 3, lam + 5 * mu / 6
    alpha = 1 + mu / lam - mu / (4 * lam)

    def stress(f):
        j = determinant(f)
        squares = numpy.einsum("ij...,ij...->...", f, f)
        return mu * (1 - 1 / (squares + 1)) * f + lam * (j - alpha) * j * transpose(inverse(f))

    return numerically(stress)


def equilibrium(basis, law, clamped, steps, equal_masses=False):
    """Displacements under gravity along -z, put on in equal steps. With `equal_masses` every node weighs the same."""
    stress, tangent = law

    @BilinearForm
    def stiffness(u, v, w):
        f = grad(w["u"]) + identity(grad(u))
        return ddot(tangent(f, grad(u)), grad(v))

    @LinearForm
    def inner(v, w):
        f = grad(w["u"]) + identity(grad(v))
        return ddot(stress(f), grad(v))

    @LinearForm
    def weight(v, w):
        return -DENSITY * GRAVITY * v[2]

    load = weight.assemble(basis)
    if equal_masses:
        falling = basis.nodal_dofs[2]
        whole = load[falling].sum()
        load[falling] = whole / len(falling)
    size = numpy.linalg.norm(load)
    u = basis.zeros()
    for step in range(1, steps + 1):
        for _ in range(30):
            at = basis.interpolate(u)
            residual = load * (step / steps) - inner.assemble(basis, u=at)
            residual[clamped] = 0
            if numpy.linalg.norm(residual) < 1e-10 * size:
                break
            matrix, right, zero, free = condense(stiffness.assemble(basis, u=at), residual, D=clamped)
            zero[free] = splu(matrix.tocsc()).solve(right)
            u = u + zero
        else:
            sys.exit(f"no equilibrium at step {step} of {steps}")
    return u


def gmsh(name):
    """Nodes and tetrahedra of a Gmsh 2.2 file."""
    lines = (HERE / name).read_text().splitlines()
    at = lines.index("$Nodes") + 1
    rows = [line.split() for line in lines[at + 1 : at + 1 + int(lines[at])]]
    index = {row[0]: i for i, row in enumerate(rows)}
    nodes = numpy.array([[float(v) for v in row[1:4]] for row in rows])
    at = lines.index("$Elements") + 1
    rows = [line.split() for line in lines[at + 1 : at + 1 + int(lines[at])]]
    tets = [[index[v] for v in row[3 + int(row[2]) :]] for row in rows if row[1] == "4"]
    return MeshTet(nodes.T.copy(), numpy.array(tets).T.copy())


def sag(mesh, element, law, order, steps=2, equal_masses=False):
    """Mean fall of the nodes of the far end [m]; the other end is clamped. `order` of quadrature: 1 is exact for linear tetrahedra."""
    basis = Basis(mesh, ElementVector(element), intorder=order)
    low, high = mesh.p[0].min(), mesh.p[0].max()
    small = 1e-6 * (high - low)
    clamped = basis.get_dofs(lambda x: x[0] < low + small).all()
    u = equilibrium(basis, law, clamped, steps, equal_masses)
    end = numpy.flatnonzero(mesh.p[0] > high - small)
    return -u[basis.nodal_dofs[2, end]].mean()


def hexahedra(refinement):
    cells = 2**refinement
    line = numpy.linspace(0, 0.02, cells + 1)
    return MeshHex.init_tensor(numpy.linspace(0, 0.1, 4 * cells + 1), line, line)


def main():
    recorded = json.loads((HERE / "cantilever.json").read_text())["static"]
    svk, neo = st_venant_kirchhoff, neo_hookean
    of_svk, of_neo = recorded["linear_tetrahedra_stvk"], recorded["linear_tetrahedra_neo_hookean"]
    # What it is, recorded [mm], digits of the printed table, mesh, law, Poisson's ratio.
    coarse = [
        ("St Venant-Kirchhoff", 1e3 * of_svk["S"], 3, "cantilever-S.msh", svk, 0.3),
        ("neo-Hookean", 1e3 * of_neo["S"], 3, "cantilever-S.msh", neo, 0.3),
        ("neo-Hookean, nu 0.45", 17.886, 3, "cantilever-S.msh", neo, 0.45),
        ("neo-Hookean, nu 0.49", 8.386, 3, "cantilever-S.msh", neo, 0.49),
        ("corotational", 24.977, 3, "cantilever-S.msh", corotational, 0.3),
        ("stable neo-Hookean", 25.097, 3, "cantilever-S.msh", stable_neo_hookean, 0.3),
        ("St Venant-Kirchhoff", 4.0295, 4, "tube-9x13x1.msh", svk, 0.3),
        ("neo-Hookean", 4.0299, 4, "tube-9x13x1.msh", neo, 0.3),
    ]
    fine = [
        ("St Venant-Kirchhoff", 4.4613, 4, "tube-18x26x2.msh", svk, 0.3),
        ("neo-Hookean", 4.4632, 4, "tube-18x26x2.msh", neo, 0.3),
        ("St Venant-Kirchhoff", 1e3 * of_svk["M"], 3, "cantilever-M.msh", svk, 0.3),
        ("neo-Hookean", 1e3 * of_neo["M"], 3, "cantilever-M.msh", neo, 0.3),
        ("corotational", 32.021, 3, "cantilever-M.msh", corotational, 0.3),
        ("stable neo-Hookean", 32.108, 3, "cantilever-M.msh", stable_neo_hookean, 0.3),
        ("neo-Hookean, nu 0.45", 28.413, 3, "cantilever-M.msh", neo, 0.45),
        ("neo-Hookean, nu 0.49", 19.545, 3, "cantilever-M.msh", neo, 0.49),
    ]
    differing = 0

    def compare(what, value, digits, found):
        nonlocal differing
        same = round(found, digits) == round(value, digits)
        differing += not same
        print(f"{what}: recorded {value:.{digits}f} mm, found {found:.{digits + 2}f} mm{'' if same else '  DIFFERS'}", flush=True)

    everything = "--all" in sys.argv[1:]
    for what, value, digits, name, law, nu in coarse + (fine if everything else []):
        compare(f"{name}, {what}", value, digits, 1e3 * sag(gmsh(name), ElementTetP1(), law(*lame(nu)), 1))
    for name, value in (("cantilever-S.msh", 25.252), ("cantilever-M.msh", 32.263))[: 2 if everything else 1]:
        found = 1e3 * sag(gmsh(name), ElementTetP1(), svk(*lame(0.3)), 1, equal_masses=True)
        compare(f"{name}, St Venant-Kirchhoff, equal masses of all nodes", value, 3, found)
    quadratic = recorded["quadratic_hexahedra"]["stvk_refinement_2_3_4"]
    for refinement in (2, 3) if everything else ():
        found = 1e3 * sag(hexahedra(refinement), ElementHex2(), svk(*lame(0.3)), 4)
        compare(f"quadratic hexahedra, refinement {refinement}", 1e3 * quadratic[refinement - 2], 3, found)
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
