"""The picture of the upset billet: python docs/figures/upset_picture.py STICKING COULOMB FRICTIONLESS

The arguments are output directories of runs of meshes/upset/upset.toml. Needs pyvista and matplotlib. Left: the quarter of
the sticking run mirrored to three quarters, between its platens. Right: force over stroke, with the closed form of
frictionless upsetting: F = A σ, A = V (1 − (1 − 2 ν) σ/E)/h, σ = 700 MPa + 300 MPa ε̄ᵖ, ε̄ᵖ = ln(30 mm/h) − σ/E.
"""

import csv
import io
import math
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import numpy
import pyvista
from matplotlib import pyplot
from matplotlib.colors import LinearSegmentedColormap

FIELD = "equivalent_plastic_strain"
COLOURS = LinearSegmentedColormap.from_list(
    "steel", ["#dde6ee", "#f6d9a6", "#f0a355", "#dd5f32", "#a8202f", "#5a0f3c"], N=512
)
HEIGHT, VOLUME = 30e-3, 2.346517e-6  # of the quarter's mesh
YOUNG, POISSON, YIELD, MODULUS = 200e9, 0.3, 700e6, 300e6


def picture(directory):
    frames = sorted(pathlib.Path(directory, "fields").glob("*.vtu"))
    quarter = pyvista.read(frames[-1])
    quarter.points = 1e3 * quarter.points
    smooth = quarter.cell_data_to_point_data()
    pyvista.OFF_SCREEN = True
    plotter = pyvista.Plotter(window_size=(1200, 900), lighting="none")
    plotter.set_background("white")
    plotter.enable_anti_aliasing("ssaa")
    for signs in [(-1, 1), (-1, -1), (1, -1)]:
        body = smooth.copy()
        body.points = smooth.points * numpy.array([*signs, 1.0])
        surface = body.extract_surface(algorithm="dataset_surface")
        surface = surface.compute_normals(split_vertices=True, feature_angle=35, auto_orient_normals=True)
        shown = plotter.add_mesh(
            surface, scalars=FIELD, cmap=COLOURS, clim=(0, 2), ambient=0.52, diffuse=0.62, specular=0.06,
            show_edges=True, edge_color="#241a2b", edge_opacity=0.4, line_width=1.0, show_scalar_bar=False,
        )
    low, high = quarter.points[:, 2].min(), quarter.points[:, 2].max()
    for z, opacity in [(low - 0.05, 1.0), (high + 0.05, 0.18)]:
        plate = pyvista.Disc(center=(0, 0, z), inner=0, outer=22, normal=(0, 0, 1), c_res=200)
        plotter.add_mesh(plate, color="#c9d4de", opacity=opacity, lighting=False)
    for position, strength in [((70, 10, 60), 0.75), ((10, 70, 50), 0.45), ((40, 40, -5), 0.25)]:
        plotter.add_light(pyvista.Light(position=position, focal_point=(0, 0, 15), intensity=strength))
    plotter.add_scalar_bar(
        title="Equivalent plastic strain\n", mapper=shown.mapper, position_x=0.3, position_y=0.03, width=0.4, height=0.06,
        color="#222222", title_font_size=24, label_font_size=22, n_labels=5, fmt="%.1f", font_family="arial",
    )
    plotter.camera.position = (60, 60, 45)
    plotter.camera.focal_point = (0, 0, 13.5)
    plotter.camera.up = (0, 0, 1)
    plotter.camera.parallel_projection = True
    plotter.camera.parallel_scale = 19
    return plotter.screenshot(return_img=True)


def force_over_stroke(directory):
    with open(pathlib.Path(directory, "history.csv")) as file:
        rows = list(csv.DictReader(file))
    stroke = [1e3 * (HEIGHT - float(row["height"])) for row in rows]
    return stroke, [4e-3 * float(row["force"]) for row in rows]


def closed_form(height):
    stress = YIELD
    for _ in range(50):
        stress = YIELD + MODULUS * (math.log(HEIGHT / height) - stress / YOUNG)
    return 4e-3 * stress * VOLUME * (1 - (1 - 2 * POISSON) * stress / YOUNG) / height


figure, (left, right) = pyplot.subplots(1, 2, figsize=(12, 4.6), width_ratios=[1.15, 1])
left.imshow(picture(sys.argv[1]))
left.axis("off")
for directory, name, colour in zip(sys.argv[1:], ["sticking", "μ = 0.1", "frictionless"], ["#5a0f3c", "#dd5f32", "#3f6f9f"]):
    right.plot(*force_over_stroke(directory), color=colour, label=name)
heights = numpy.linspace(12e-3, 29.7e-3, 60)
right.plot(1e3 * (HEIGHT - heights), [closed_form(h) for h in heights], "o", ms=3, mfc="none", color="#3f6f9f", label="closed form, frictionless")
right.set(xlabel="stroke, mm", ylabel="force on the whole billet, kN", xlim=(0, 18.5), ylim=(0, None))
right.legend(frameon=False)
right.spines[["top", "right"]].set_visible(False)
figure.tight_layout()
target = pathlib.Path(__file__).with_name("upset.png")
figure.savefig(target, dpi=110)
print(target, target.stat().st_size // 1024, "kB")
