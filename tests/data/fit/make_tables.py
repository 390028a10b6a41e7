#!/usr/bin/env python3
"""Tables of stretches and stresses that the tests of `microsim fit` must give the constants of back.

Independent of MicroSim: energies in principal stretches are written down from the publications, stresses are their derivatives by complex
steps (exact to rounding), and free sides are found by bisection. Python 3 alone, no packages.

    python3 make_tables.py

writes the CSV files beside it. Nothing in them was measured. Licence: that of the project.

Axis 1 is circumferential, axis 2 axial, axis 3 radial, which is free of stress; an empty stretch is a free side.
"""

import cmath
import math
import random
from pathlib import Path

STEP = 1e-30


def lame(young, poisson):
    """Shear modulus and Lame's first constant."""
    mu = young / (2 * (1 + poisson))
    return mu, young * poisson / ((1 + poisson) * (1 - 2 * poisson))


def neo_hookean(mu, lam, l):
    """Bonet & Wood (1997), eq. 6.27: mu/2 (I1 - 3) - mu ln J + lam/2 ln^2 J."""
    j = l[0] * l[1] * l[2]
    i1 = sum(x * x for x in l)
    return mu / 2 * (i1 - 3) - mu * cmath.log(j) + lam / 2 * cmath.log(j) ** 2


def mooney_rivlin(young, poisson, fraction):
    """Ciarlet & Geymonat (1982): c10 (I1 - 3) + c01 (I2 - 3) - 2 (c10 + 2 c01) ln J + kappa/2 (J - 1)^2, with E = 4 (1 + nu) (c10 + c01)
    and lam = kappa + 4 c01."""
    mu, lam = lame(young, poisson)
    c01 = fraction * mu / 2
    c10 = mu / 2 - c01

    def energy(l):
        a, b, c = (x * x for x in l)
        j = l[0] * l[1] * l[2]
        return (
            c10 * (a + b + c - 3)
            + c01 * (a * b + b * c + c * a - 3)
            - 2 * (c10 + 2 * c01) * cmath.log(j)
            + (lam - 4 * c01) / 2 * (j - 1) ** 2
        )

    return energy


def transversely_isotropic(young, poisson, ratio, angle):
    """Neo-Hookean matrix and m/8 (I4 - 1)^2 with m = (ratio - 1) E (Qiu & Pence 1997)."""
    mu, lam = lame(young, poisson)
    stiffness = (ratio - 1) * young

    def energy(l):
        i4 = (l[0] * math.cos(angle)) ** 2 + (l[1] * math.sin(angle)) ** 2
        return neo_hookean(mu, lam, l) + stiffness / 8 * (i4 - 1) ** 2

    return energy


def holzapfel(young, poisson, k1, k2, dispersion, angle):
    """Gasser, Ogden & Holzapfel (2006) with a neo-Hookean matrix: for each of two families at +-angle k1/(2 k2) (exp(k2 E^2) - 1) with
    E = dispersion (I1 - 3) + (1 - 3 dispersion) (I4 - 1) where E > 0. Both have the same I4, as there is no shear."""
    mu, lam = lame(young, poisson)

    def energy(l):
        i1 = sum(x * x for x in l)
        i4 = (l[0] * math.cos(angle)) ** 2 + (l[1] * math.sin(angle)) ** 2
        strain = dispersion * (i1 - 3) + (1 - 3 * dispersion) * (i4 - 1)
        fibres = 0
        if strain.real > 0:
            fibres = 2 * k1 / (2 * k2) * (cmath.exp(k2 * strain**2) - 1)
        return neo_hookean(mu, lam, l) + fibres

    return energy


def piola(energy, l, axis):
    """First Piola-Kirchhoff stress along an axis."""
    l = [complex(x, STEP if i == axis else 0) for i, x in enumerate(l)]
    return energy(l).imag / STEP


def root(function):
    """Where an increasing function of a stretch is zero."""
    low, high = 0.2, 3.0
    for _ in range(80):
        middle = (low + high) / 2
        if function(middle) > 0:
            high = middle
        else:
            low = middle
    return (low + high) / 2


def stretches(energy, first, second):
    """All three, of a specimen without stress along 3 and where a stretch is None."""

    def thickness(a, b):
        return root(lambda c: piola(energy, (a, b, c), 2))

    if second is None:
        second = root(lambda b: piola(energy, (first, b, thickness(first, b)), 1))
    if first is None:
        first = root(lambda a: piola(energy, (a, second, thickness(a, second)), 0))
    return first, second, thickness(first, second)


def cauchy(energy, l, axis):
    return piola(energy, l, axis) * l[axis] / (l[0] * l[1] * l[2])


def table(name, energy, stress, kind, text, largest, noise=None):
    """Strips along both axes and an equibiaxial test, 15 stretches each; with noise, stresses are rounded as an instrument gives them."""
    lines = [f"# {text}", "# Made by make_tables.py; nothing here was measured. Licence: that of the project."]
    lines.append(f"protocol,stretch_1,stretch_2,{kind}_1 [kPa],{kind}_2 [kPa]")
    generator = random.Random(2006)
    for protocol, along in [("circumferential", (1, 0)), ("axial", (0, 1)), ("equibiaxial", (1, 1))]:
        for step in range(1, 16):
            stretch = round(1 + step * (largest - 1) / 15, 6)
            given = [stretch if use else None for use in along]
            l = stretches(energy, *given)
            cells = []
            for axis in range(2):
                if not along[axis]:
                    cells.append("")
                    continue
                value = stress(energy, l, axis) / 1e3
                if noise is not None:
                    value = round(value + generator.gauss(0, noise), 3)
                cells.append(repr(value))
            names = [str(stretch) if use else "" for use in along]
            lines.append(",".join([protocol, *names, *cells]))
    Path(__file__).with_name(name).write_text("\n".join(lines) + "\n")


def main():
    degree = math.pi / 180
    table(
        "mooney-rivlin.csv", mooney_rivlin(60e3, 0.45, 0.3), piola, "piola",
        "Mooney-Rivlin: E = 60 kPa, nu = 0.45, c01_fraction = 0.3.", 1.5,
    )
    table(
        "transversely-isotropic.csv", transversely_isotropic(40e3, 0.49, 6, 0), cauchy, "cauchy",
        "Transversely isotropic: E = 40 kPa, nu = 0.49, fibre_ratio = 6, fibres along axis 1.", 1.3,
    )
    # Media of the rabbit's carotid (Holzapfel, Gasser & Ogden 2000): mu = 3.0 kPa, k1 = 2.3632 kPa, k2 = 0.8393, 29 deg; with some dispersion.
    media = holzapfel(8940, 0.49, 2363.2, 0.8393, 0.1, 29 * degree)
    constants = "E = 8.94 kPa, nu = 0.49, k1 = 2.3632 kPa, k2 = 0.8393, kappa = 0.1, fibres at +-29 deg"
    table("holzapfel.csv", media, cauchy, "cauchy", f"Holzapfel-Gasser-Ogden: {constants}.", 1.6)
    table(
        "holzapfel-noise.csv", media, cauchy, "cauchy",
        f"Holzapfel-Gasser-Ogden: {constants}, with noise of 0.3 kPa.", 1.6, noise=0.3,
    )


if __name__ == "__main__":
    main()
