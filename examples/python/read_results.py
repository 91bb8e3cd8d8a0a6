"""Reads the results of a run: python examples/python/read_results.py RESULTS [PICTURE.png]

RESULTS is the directory that `estar run` wrote. meshio reads a frame into arrays of numpy, pyvista all frames with their
times; what both say is compared. With a second argument a picture of the last frame is drawn.

Needs: pip install meshio pyvista
"""

import csv
import json
import pathlib
import sys

import meshio
import numpy
import pyvista

results = pathlib.Path(sys.argv[1])

# summary.json: what was run, and where it ended
summary = json.loads((results / "summary.json").read_text())
print(f"{summary['title']}: {summary['status']} at t = {summary['time']:.4e} s after {summary['steps']} steps")

# history.csv: a row every so often
with open(results / "history.csv", newline="") as file:
    rows = list(csv.DictReader(file))
print(f"history.csv: {len(rows)} rows, largest energy error {max(abs(float(row['energy_error'])) for row in rows):.1e}")

# one frame with meshio: points are where the nodes are now
last = sorted((results / "fields").glob("frame_*.vtu"))[-1]
frame = meshio.read(last)
displacement = frame.point_data["displacement"]
reference = frame.points - displacement
for block, strains in zip(frame.cells, frame.cell_data["equivalent_plastic_strain"]):
    print(f"meshio: {last.name}, {len(frame.points)} nodes, {len(block.data)} cells of {block.type}, "
          f"largest equivalent plastic strain {strains.max():.4f}")
print(f"meshio: largest displacement {numpy.linalg.norm(displacement, axis=1).max():.4e} m, "
      f"length along z {numpy.ptp(reference[:, 2]):.4e} m, now {numpy.ptp(frame.points[:, 2]):.4e} m")

# the stress of a cell, in the order XX YY ZZ XY YZ XZ, as a matrix; its von Mises stress again from that
xx, yy, zz, xy, yz, xz = numpy.concatenate(frame.cell_data["cauchy_stress"]).T
stress = numpy.moveaxis(numpy.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), 2, 0)
deviator = stress - numpy.trace(stress, axis1=1, axis2=2)[:, None, None] / 3 * numpy.eye(3)
mises = numpy.sqrt(1.5 * numpy.sum(deviator**2, axis=(1, 2)))
print(f"meshio: von Mises stress from {mises.min() / 1e6:.1f} to {mises.max() / 1e6:.1f} MPa")

# all frames with pyvista, by way of results.pvd
reader = pyvista.get_reader(results / "results.pvd")
print(f"pyvista: {len(reader.time_values)} frames to t = {reader.time_values[-1]:.4e} s")
reader.set_active_time_value(reader.time_values[-1])
grid = reader.read()[0]
print(f"pyvista: fields of nodes {', '.join(grid.point_data)}; of cells {', '.join(grid.cell_data)}")
assert numpy.array_equal(grid.points, frame.points)
assert numpy.allclose(mises, grid["von_mises_stress"], rtol=1e-9)

if len(sys.argv) > 2:
    pyvista.OFF_SCREEN = True
    plotter = pyvista.Plotter(window_size=(900, 900))
    smooth = grid.cell_data_to_point_data()
    plotter.add_mesh(smooth, scalars="equivalent_plastic_strain", cmap="YlOrRd", show_edges=True, ambient=0.3,
                     scalar_bar_args={"vertical": True, "position_x": 0.82, "position_y": 0.3})
    plotter.view_vector((-1.0, -1.0, 0.6), viewup=(0.0, 0.0, 1.0))  # at the cut faces of a quarter
    plotter.screenshot(sys.argv[2])
    print(f"wrote {sys.argv[2]}")
