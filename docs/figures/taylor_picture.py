"""The picture of the Taylor bar in the README: python docs/figures/taylor_picture.py RESULTS

RESULTS is the output directory of a run of meshes/taylor/taylor.toml (any mesh of the quarter). Needs pyvista.
The quarter is mirrored to three quarters of the rod, so that the cut shows the inside, under what the rod was.
"""

import pathlib
import sys

import numpy
import pyvista
from matplotlib.colors import LinearSegmentedColormap
from PIL import Image, ImageChops

FIELD = "equivalent plastic strain"
COLOURS = LinearSegmentedColormap.from_list(
    "copper rod", ["#dde6ee", "#f6d9a6", "#f0a355", "#dd5f32", "#a8202f", "#5a0f3c"], N=512
)
TOP = 2.0  # of the colours: only the middle of the foot is above it


def mirrored(grid, signs):
    """The grid with x and y multiplied by `signs`."""
    copy = grid.copy()
    copy.points = grid.points * numpy.array([*signs, 1.0])
    return copy


frames = sorted(pathlib.Path(sys.argv[1], "fields").glob("*.vtu"))
quarter = pyvista.read(frames[-1])
quarter.points = 1e3 * quarter.points
# a colour per node makes the bands smooth; the mesh lines show the elements
smooth = quarter.cell_data_to_point_data()
smooth.rename_array("equivalent_plastic_strain", FIELD)
largest = float(quarter["equivalent_plastic_strain"].max())

pyvista.OFF_SCREEN = True
plotter = pyvista.Plotter(window_size=(1400, 1320), lighting="none")
plotter.set_background("white")
plotter.enable_anti_aliasing("ssaa")

# the quadrant that faces the eye is left out
length = float(quarter.points[:, 2].max())
for signs in [(-1, 1), (-1, -1), (1, -1)]:
    body = mirrored(smooth, signs).extract_surface(algorithm="dataset_surface")
    body = body.compute_normals(split_vertices=True, feature_angle=35, auto_orient_normals=True)
    shown = plotter.add_mesh(
        body, scalars=FIELD, cmap=COLOURS, clim=(0, TOP), ambient=0.52, diffuse=0.62, specular=0.06, specular_power=12,
        show_edges=True, edge_color="#241a2b", edge_opacity=0.45, line_width=1.2, show_scalar_bar=False,
    )

# what it was
ghost = pyvista.Cylinder(
    center=(0, 0, (32.4 + length) / 2), direction=(0, 0, 1), radius=3.2, height=32.4 - length, resolution=160, capping=False
)
plotter.add_mesh(ghost, color="#9fb4c8", opacity=0.16, lighting=False)
angle = numpy.linspace(0, 2 * numpy.pi, 241)
ring = pyvista.lines_from_points(numpy.c_[3.2 * numpy.cos(angle), 3.2 * numpy.sin(angle), numpy.full_like(angle, 32.4)])
plotter.add_mesh(ring, color="#7890a8", line_width=2.5, lighting=False)

wall = pyvista.Disc(center=(0, 0, -0.05), inner=0, outer=10, normal=(0, 0, 1), c_res=200)
plotter.add_mesh(wall, color="#e6ebf0", lighting=False)

for position, strength in [((70, 10, 60), 0.75), ((10, 70, 50), 0.45), ((40, 40, -5), 0.25)]:
    plotter.add_light(pyvista.Light(position=position, focal_point=(0, 0, 8), intensity=strength))

plotter.add_scalar_bar(
    title="Equivalent\nplastic strain\n", mapper=shown.mapper, vertical=True, position_x=0.76, position_y=0.42,
    width=0.05, height=0.36, color="#222222", title_font_size=27, label_font_size=25, n_labels=5, fmt="%.1f",
    font_family="arial",
)
plotter.camera.position = (60, 60, 42)
plotter.camera.focal_point = (0, 0, 14.4)
plotter.camera.up = (0, 0, 1)
plotter.camera.parallel_projection = True
plotter.camera.parallel_scale = 19.5

target = pathlib.Path(__file__).with_name("taylor.png")
image = Image.fromarray(plotter.screenshot(return_img=True)).convert("RGB")
left, top, right, bottom = ImageChops.difference(image, Image.new("RGB", image.size, "white")).getbbox()
image = image.crop((left - 30, top - 30, right + 30, bottom + 30))
image = image.resize((image.width * 940 // image.height, 940), Image.Resampling.LANCZOS)
image.save(target, optimize=True)
print(target, target.stat().st_size // 1024, f"kB; largest equivalent plastic strain {largest:.2f}")
