"""The figure of docs/performance.md: time per element step over the size of the mesh.

python docs/figures/performance.py benchmarks/results/DATE-sizes.json   draws performance.png beside this file

The file is what `estar bench --sizes --json` prints. Needs matplotlib.
"""

import json
import pathlib
import sys

import matplotlib.pyplot as plt

report = json.loads(pathlib.Path(sys.argv[1]).read_text())
problems = report["problems"]
hexes = [problem["hexes"] for problem in problems]

figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
for position, threads in enumerate(report["threads"]):
    runs = [problem["rows"][0]["runs"][position] for problem in problems]
    times = [run["nanoseconds"] for run in runs]
    spread = [run["spread"] * run["nanoseconds"] for run in runs]
    label = "1 thread" if threads == 1 else f"{threads} threads"
    measured = axes.errorbar(hexes, times, yerr=spread, marker="o", capsize=3, label=label)
    floor = [run["roofline_fraction"] * run["nanoseconds"] for run in runs]
    axes.plot(hexes, floor, linestyle=":", color=measured.lines[0].get_color(), label=f"roofline, {label}")
axes.set(xscale="log", xlabel="hexes", ylabel="ns per element step", ylim=(0, None))
axes.set_title(f"{problems[0]['rows'][0]['element']}, {problems[0]['rows'][0]['material']}, {problems[0]['lanes']}")
figure.legend(loc="outside lower center", ncols=4)
axes.grid(alpha=0.3)
figure.savefig(pathlib.Path(__file__).with_name("performance.png"), dpi=150)
