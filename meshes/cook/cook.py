"""Cook's membrane, one element and 1 mm thick. Lengths in mm.

python cook.py                 writes cook.msh with 8 elements on each side
python cook.py --elements 32   writes cook_32.msh
"""

import argparse
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import gmsh
import hex_mesh

CORNERS = [(0, 0), (48, 44), (48, 60), (0, 44)]
THICKNESS = 1.0

arguments = argparse.ArgumentParser()
arguments.add_argument("--elements", type=int, default=8)
arguments.add_argument("--output")
options = arguments.parse_args()
name = "cook" if options.elements == 8 else f"cook_{options.elements}"

hex_mesh.start(name)
geo = gmsh.model.geo
points = [geo.addPoint(x, y, 0) for x, y in CORNERS]
curves = [geo.addLine(points[k], points[(k + 1) % 4]) for k in range(4)]
for curve in curves:
    geo.mesh.setTransfiniteCurve(curve, options.elements + 1)
surface = geo.addPlaneSurface([geo.addCurveLoop(curves)])
geo.mesh.setTransfiniteSurface(surface)
geo.mesh.setRecombine(2, surface)
geo.extrude([(2, surface)], 0, 0, THICKNESS, [1], recombine=True)
geo.synchronize()
gmsh.model.mesh.generate(3)
hex_mesh.name_volume("membrane")
hex_mesh.name_where(2, "clamped", lambda x, y, z: abs(x) < 1e-9)
hex_mesh.name_where(2, "loaded", lambda x, y, z: abs(x - 48) < 1e-9)
hex_mesh.name_where(2, "back", lambda x, y, z: abs(z) < 1e-9)
hex_mesh.name_where(2, "front", lambda x, y, z: abs(z - THICKNESS) < 1e-9)
hex_mesh.name_node("tip", (48, 60, 0))
hex_mesh.write(options.output or os.path.join(os.path.dirname(os.path.abspath(__file__)), f"{name}.msh"))
