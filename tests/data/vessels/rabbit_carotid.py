#!/usr/bin/env python3
"""Sizes of the rabbit's carotid where it lies, from those of its open wall: the values of config/vessels/rabbit-carotid.toml that are derived.

The wall is that of Holzapfel, Gasser & Ogden (2000), section 5 and figure 14 there: incompressible, two layers, a gap of 160 degrees in the
open state, inner radius 1.43 mm there. For an axial stretch and no pressure, p = integral of (sigma_theta - sigma_r)/r dr = 0 gives the inner
radius. Python 3 alone, no packages. Licence: that of the project.
"""

import math

RADIUS, GAP = 1.43e-3, math.radians(160)
# Thickness [m], c [Pa], k1 [Pa], k2, angle of the fibres.
LAYERS = [(0.26e-3, 3000, 2363.2, 0.8393, math.radians(29)), (0.13e-3, 300, 562.0, 0.7112, math.radians(62))]
STEPS = 400


def place(radius, inner, axial):
    """Where a radius of the open wall comes to, as the volume stays."""
    closing = 2 * math.pi / (2 * math.pi - GAP)
    return math.sqrt(inner**2 + (radius**2 - RADIUS**2) / (closing * axial))


def pressure(inner, axial):
    closing = 2 * math.pi / (2 * math.pi - GAP)
    total, start = 0.0, RADIUS
    for thickness, c, k1, k2, angle in LAYERS:
        for step in range(STEPS):
            ends = [start + thickness * (step + side) / STEPS for side in (0, 1)]
            middle = sum(ends) / 2
            r = place(middle, inner, axial)
            around = closing * r / middle
            radial = 1 / (around * axial)
            strain = (around * math.cos(angle)) ** 2 + (axial * math.sin(angle)) ** 2 - 1
            difference = c * (around**2 - radial**2)
            if strain > 0:
                # Two families, each with 2 dpsi/dI4 = 2 k1 E exp(k2 E^2).
                difference += 4 * k1 * strain * math.exp(k2 * strain**2) * (around * math.cos(angle)) ** 2
            total += difference / r * (place(ends[1], inner, axial) - place(ends[0], inner, axial))
        start += thickness
    return total


def main():
    for axial in (1.0, 1.7):
        low, high = 0.1e-3, 2e-3
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (low, middle) if pressure(middle, axial) > 0 else (middle, high)
        radii = [place(RADIUS + more, low, axial) for more in (0, 0.26e-3, 0.39e-3)]
        sizes = [radii[0], radii[1] - radii[0], radii[2] - radii[1]]
        print(f"axial stretch {axial}: inner radius, media, adventitia:", ", ".join(f"{1e3 * s:.4f} mm" for s in sizes))


if __name__ == "__main__":
    main()
