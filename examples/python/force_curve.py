"""Force over elongation of a bar that is pulled: python examples/python/force_curve.py RESULTS [PICTURE.png]

RESULTS is the directory of a run with the probes `quarter_force`, `elongation` (of half of the bar) and `neck_radius`, as
`meshes/necking/necking.toml` and `meshes/necking/tensile.toml` have them. A picture needs matplotlib, the table nothing.
"""

import csv
import pathlib
import sys

with open(pathlib.Path(sys.argv[1], "history.csv"), newline="") as file:
    rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
elongations = [1e3 * row["elongation"] for row in rows]  # mm, of half of the bar
forces = [4e-3 * row["quarter_force"] for row in rows]  # kN, on the whole bar
radii = [1e3 * row["neck_radius"] for row in rows]  # mm

print("half elongation, mm   radius of the neck, mm   force, kN")
for millimetres in range(int(elongations[-1] + 1e-9) + 1):
    nearest = min(range(len(rows)), key=lambda k: abs(elongations[k] - millimetres))
    print(f"{elongations[nearest]:19.2f} {radii[nearest]:24.3f} {forces[nearest]:11.2f}")
largest = max(range(len(rows)), key=lambda k: forces[k])
print(f"largest force {forces[largest]:.2f} kN at {elongations[largest]:.2f} mm, radius {radii[largest]:.3f} mm")

if len(sys.argv) > 2:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6.4, 4.0))
    axes.plot(elongations, forces, color="#5a0f3c")
    axes.plot(elongations[largest], forces[largest], "o", mfc="white", color="#5a0f3c")
    axes.axhspan(76.89, 79.73, color="#f0a355", alpha=0.3, lw=0, label="Considère: thin end to thick end")
    axes.set(xlabel="elongation of half of the bar, mm", ylabel="force, kN", xlim=(0, None), ylim=(0, None))
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, loc="lower right")
    figure.tight_layout()
    figure.savefig(sys.argv[2], dpi=120)
    print(f"wrote {sys.argv[2]}")
