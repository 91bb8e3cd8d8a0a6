"""The Taylor bar: a cylinder of 32.4 mm and radius 3.2 mm that stands on z = 0. Lengths in mm.

python taylor.py            writes taylor.msh, the quarter x, y >= 0
python taylor.py --full     writes taylor_full.msh, all of it
python taylor.py --refine 2 as many cells again along every edge
"""

import argparse
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import hex_mesh

LENGTH, RADIUS = 32.4, 3.2

arguments = argparse.ArgumentParser()
arguments.add_argument("--full", action="store_true")
arguments.add_argument("--refine", type=int, default=1)
arguments.add_argument("--output")
options = arguments.parse_args()
name = "taylor_full" if options.full else "taylor"
n = options.refine

hex_mesh.start(name)
hex_mesh.round_bar(RADIUS, LENGTH, core=5 * n, rings=4 * n, axial=54 * n, quarters=4 if options.full else 1)
hex_mesh.name_volume("bar")
if not options.full:
    hex_mesh.name_where(2, "symmetry_x", lambda x, y, z: abs(x) < 1e-9)
    hex_mesh.name_where(2, "symmetry_y", lambda x, y, z: abs(y) < 1e-9)
hex_mesh.name_where(2, "foot", lambda x, y, z: abs(z) < 1e-9)
hex_mesh.name_where(2, "top", lambda x, y, z: abs(z - LENGTH) < 1e-9)
hex_mesh.name_where(2, "side", lambda x, y, z: abs(math.hypot(x, y) - RADIUS) < 1e-9)
hex_mesh.name_where(1, "axis", lambda x, y, z: math.hypot(x, y) < 1e-9)
hex_mesh.write(options.output or os.path.join(os.path.dirname(os.path.abspath(__file__)), f"{name}.msh"))
