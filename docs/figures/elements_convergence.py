"""The figure of convergence in docs/elements.md, and its table:

cargo test --release -p estar-solver --test elastic_accuracy -- --nocapture displacement > OUTPUT
python docs/figures/elements_convergence.py OUTPUT

Needs matplotlib.
"""

import math
import pathlib
import re
import sys

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot

NAMES = {
    ("Full", "Hex8"): "`hex8`",
    ("FBar", "Hex8"): "`hex8-f-bar`",
    ("BBar", "Hex8"): "`hex8-b-bar`",
    ("OnePoint(Physical)", "Hex8"): "`hex8-one-point`, `physical`",
    ("OnePoint(Stiffness { coefficient: 0.05 })", "Hex8"): "the same, `stiffness`",
    ("OnePoint(Viscous { coefficient: 0.1 })", "Hex8"): "the same, `viscous`",
    ("Tet10", "Tet10"): "`tet10`",
    ("Tet4", "Tet4"): "`tet4`",
    ("BBar", "Wedge6"): "wedges, `hex8-b-bar`",
    ("OnePoint(Physical)", "Wedge6"): "wedges, `hex8-one-point`",
}
found = {}
for line in open(sys.argv[1]):
    row = re.fullmatch(r"(.+),(\w+),(\d+),([\d.e+-]+),([\d.e+-]+)", line.strip())
    if row and (row[1], row[2]) in NAMES:
        found.setdefault((row[1], row[2]), []).append((int(row[3]), float(row[4]), float(row[5])))

print("| element | displacement, n = 4 | 8 | 16 | order | stress, n = 4 | 8 | 16 | order |")
print("|---|---|---|---|---|---|---|---|---|")
for key, name in NAMES.items():
    rows = found[key]
    cells = []
    for column in (1, 2):
        cells += [f"{100 * row[column]:.2f} %" for row in rows]
        cells.append(f"{math.log2(rows[-2][column] / rows[-1][column]):.2f}")
    print(f"| {name} | {' | '.join(cells)} |")

figure, axes = pyplot.subplots(1, 2, figsize=(12, 4.2), sharex=True)
for axis, column, title in zip(axes, (1, 2), ("displacement", "stress")):
    for key, name in NAMES.items():
        style = {"Hex8": "o-", "Wedge6": "s--"}.get(key[1], "^-.")
        sizes = [1 / row[0] for row in found[key]]
        axis.loglog(sizes, [row[column] for row in found[key]], style, ms=4, lw=1.3, label=name.replace("`", ""))
    for order, shade in ((1, "#bbbbbb"), (2, "#888888")):
        start = 0.9 * min(row[column] for rows in found.values() for row in rows)
        axis.loglog([1 / 16, 1 / 4], [start, start * 4**order], ":", color=shade, label=f"order {order}")
    axis.set(title=title, xlabel="size of the cubes over the side", ylabel="relative error, L₂")
    axis.set_xticks([1 / 4, 1 / 8, 1 / 16], ["1/4", "1/8", "1/16"])
    axis.minorticks_off()
    axis.spines[["top", "right"]].set_visible(False)
axes[1].legend(fontsize=8, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
figure.tight_layout()
target = pathlib.Path(__file__).with_name("elements_convergence.png")
figure.savefig(target, dpi=110)
