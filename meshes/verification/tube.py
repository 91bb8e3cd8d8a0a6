"""A quarter of a thick-walled tube in plane strain, and the deck that widens its bore: no more than the standard library is needed.

python meshes/verification/tube.py writes tube.inp and tube.toml beside itself.
"""

import math
from pathlib import Path

INNER, OUTER, THICKNESS = 10.0, 20.0, 1.0  # mm
RADIAL, ANGULAR = 12, 12
WIDENING = 0.2  # mm


def node(radial, angular, layer):
    return 1 + radial + (RADIAL + 1) * (angular + (ANGULAR + 1) * layer)


def direction(angular):
    angle = 0.5 * math.pi * angular / ANGULAR
    # exact where a plane of symmetry holds the node
    return [0.0 if angular == ANGULAR else math.cos(angle), math.sin(angle)]


def mesh():
    lines = ["** a quarter of a tube, in mm: python meshes/verification/tube.py", "*NODE"]
    for layer in range(2):
        for angular in range(ANGULAR + 1):
            for radial in range(RADIAL + 1):
                radius = INNER * (OUTER / INNER) ** (radial / RADIAL)
                x, y = (radius * c for c in direction(angular))
                lines.append(f"{node(radial, angular, layer)}, {x:.12g}, {y:.12g}, {THICKNESS * layer:g}")
    lines.append("*ELEMENT, TYPE=C3D8, ELSET=tube")
    for angular in range(ANGULAR):
        for radial in range(RADIAL):
            corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
            nodes = [node(radial + r, angular + a, layer) for layer in range(2) for r, a in corners]
            lines.append(", ".join(str(n) for n in [1 + radial + RADIAL * angular, *nodes]))

    def group(name, members):
        lines.append(f"*NSET, NSET={name}")
        lines.extend(", ".join(str(n) for n in members[k : k + 12]) for k in range(0, len(members), 12))

    for angular in range(ANGULAR + 1):
        group(f"bore_{angular}", [node(0, angular, layer) for layer in range(2)])
    group("bore", [node(0, angular, layer) for angular in range(ANGULAR) for layer in range(2)])
    group("symmetry_y", [node(r, 0, layer) for r in range(RADIAL + 1) for layer in range(2)])
    group("symmetry_x", [node(r, ANGULAR, layer) for r in range(RADIAL + 1) for layer in range(2)])
    group("outside", [node(RADIAL, a, layer) for a in range(ANGULAR + 1) for layer in range(2)])
    return "\n".join(lines) + "\n"


def prescribed():
    lines = []
    for angular in range(ANGULAR + 1):
        for axis, component in zip("xy", direction(angular)):
            if component != 0.0:
                curve = f'[[0.0, 0.0], ["10 ms", "{WIDENING * component:.12g} mm"]]'
                lines.append(
                    f'    {{ group = "bore_{angular}", direction = "{axis}", quantity = "displacement", curve = {curve} }},'
                )
    return "\n".join(lines)


DECK = """# A thick-walled tube in plane strain, b/a = 2, whose bore is widened until all of it flows: the pressure rises as Lamé's to first
# yield and ends at the limit load p = 2/√3 σ_y ln(b/a). Its bore is moved, not pressed, so that the tube does not run away.
# The sum of the forces along x on the bore of a quarter is p a h, with the thickness h.
# Made by tube.py, with tube.inp.

title = "Thick-walled tube to its limit load"

prescribed = [
{prescribed}
]

[mesh]
file = "tube.inp"
scale = 1e-3                   # the file is in mm

[material.steel]
theory = "e-star"
density = "7850 kg/m^3"
young_modulus = "200 GPa"
poisson_ratio = 0.3
hardening = {{ law = "perfect", yield_stress = "200 MPa" }}

[[part]]
group = "tube"
material = "steel"
element = "hex8-b-bar"

[[fix]]
group = "symmetry_x"
directions = ["x"]

[[fix]]
group = "symmetry_y"
directions = ["y"]

[[fix]]                        # plane strain
group = "tube"
directions = ["z"]

[time]
end = "10 ms"
quasi_static = {{}}

[output]
frames = 1

[[probe]]                      # a p h of the quarter
name = "force"
kind = "reaction"
group = "bore"
direction = "x"

[[probe]]
name = "widening"
kind = "node"
label = 1
field = "displacement"
component = "x"

[[probe]]
name = "outer_widening"
kind = "node"
label = {outer}
field = "displacement"
component = "x"
"""

if __name__ == "__main__":
    folder = Path(__file__).parent
    (folder / "tube.inp").write_text(mesh())
    (folder / "tube.toml").write_text(DECK.format(prescribed=prescribed(), outer=node(RADIAL, 0, 0)))
