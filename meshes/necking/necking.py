"""An eighth of the necking bar: half its length of 53.334 mm, a quarter of its section. Lengths in mm.

The radius is 6.413 mm at the end and 0.982 of that at the mid-plane z = 0, linear between.

python necking.py            writes necking.msh
python necking.py --refine 2 as many cells again along every edge
"""

import argparse
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import gmsh
import hex_mesh

LENGTH, RADIUS, NECK = 53.334, 6.413, 0.982

arguments = argparse.ArgumentParser()
arguments.add_argument("--refine", type=int, default=1)
arguments.add_argument("--output")
options = arguments.parse_args()
n = options.refine


def radius(z):
    return RADIUS * (NECK + 2 * (1 - NECK) * z / LENGTH)


hex_mesh.start("necking")
hex_mesh.round_bar(RADIUS, LENGTH / 2, core=3 * n, rings=3 * n, axial=15 * n, ratio=4.0)
hex_mesh.name_volume("bar")
hex_mesh.name_where(2, "symmetry_x", lambda x, y, z: abs(x) < 1e-9)
hex_mesh.name_where(2, "symmetry_y", lambda x, y, z: abs(y) < 1e-9)
hex_mesh.name_where(2, "symmetry_z", lambda x, y, z: abs(z) < 1e-9)
hex_mesh.name_where(2, "grip", lambda x, y, z: abs(z - LENGTH / 2) < 1e-9)
hex_mesh.name_where(2, "side", lambda x, y, z: abs(math.hypot(x, y) - RADIUS) < 1e-9)
hex_mesh.name_where(1, "axis", lambda x, y, z: math.hypot(x, y) < 1e-9)
hex_mesh.name_node("neck", (RADIUS, 0, 0))
tags, positions, _ = gmsh.model.mesh.getNodes()
for k, tag in enumerate(tags):
    x, y, z = positions[3 * k : 3 * k + 3]
    factor = radius(z) / RADIUS
    gmsh.model.mesh.setNode(tag, [factor * x, factor * y, z], [])
hex_mesh.write(options.output or os.path.join(os.path.dirname(os.path.abspath(__file__)), "necking.msh"))
