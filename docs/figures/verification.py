"""The runs and figures of docs/verification.md.

python docs/figures/verification.py run RUNS    makes the runs, one after the other, in the directory RUNS (hours on one core)
python docs/figures/verification.py draw RUNS   draws the figures beside this file, from history.csv and the last frames
python docs/figures/verification.py table RUNS  prints the numbers of the tables

From the root of the repository, after cargo build --release. Needs gmsh (run), matplotlib and pyvista (draw).
"""

import csv
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
ESTAR = ROOT / "target" / "release" / "estar"
COOK = [2, 4, 8, 16, 32]
PULL_TIMES = ["1.4", "4.2", "12.6"]  # ms
GRADED = [1, 2, 3, 4]  # cylinder: 2k x 2k core, 2k rings, 20k cells along z


def quoted(value):
    return f'"{value}"'


def runs(meshes):
    """Name, deck and overrides of every run, cheap ones first."""
    taylor, wall = "meshes/taylor/taylor.toml", "meshes/taylor/taylor-wall.toml"
    yield "taylor", taylor, {}
    yield "taylor-wall", wall, {}
    yield "taylor-hex8", taylor, {"part.0.element": quoted("hex8")}
    yield "taylor-total", taylor, {"material.copper.update": quoted("total")}
    for n in COOK:
        for element in ["hex8-f-bar", "hex8"]:
            mesh = quoted(meshes / f"cook{n}.msh")
            yield f"cook-{n}-{element}", "meshes/cook/cook.toml", {"mesh.file": mesh, "part.0.element": quoted(element)}
    for name, n, ramp, end in [("slow", 8, 10, 11), ("slow20", 8, 20, 22), ("slow40", 8, 40, 44), ("slow", 16, 10, 11), ("slow", 32, 10, 11)]:
        yield f"cook-{n}-{name}", "meshes/cook/cook.toml", {
            "mesh.file": quoted(meshes / f"cook{n}.msh"),
            "traction.0.curve": f'[[0.0, 0.0], ["{ramp} ms", "312.5 MPa"]]',
            "time.end": quoted(f"{end} ms"),
        }
    for name, scale in [("neck405", 1e-3), ("neck960", 1.0), ("neck3240", 1e-3)]:
        for time in PULL_TIMES:
            yield f"{name}-{time}", "meshes/necking/necking.toml", {
                "mesh.file": quoted(meshes / f"{name}.msh"),
                "mesh.scale": scale,
                "time.end": quoted(f"{time} ms"),
                "prescribed.0.curve": f'[[0.0, 0.0], ["{time} ms", "7 mm"]]',
                "expect": "[]",
            }
    for deck, prefix, steps in [(taylor, "taylor", GRADED), (wall, "wall", [2])]:
        for k in steps:
            yield f"{prefix}-k{k}", deck, {"mesh.file": quoted(meshes / f"cyl{k}.msh"), "mesh.scale": 1.0}
    # the whole rod has no symmetry planes: the first `fix` is the wall, and there is no other
    yield "taylor-full", taylor, {
        "mesh.file": quoted(meshes / "taylor_full.msh"),
        "fix": '[{ group = "foot", directions = ["z"] }]',
    }


def make_meshes(meshes):
    meshes.mkdir(parents=True, exist_ok=True)

    def python(script, *arguments):
        subprocess.run([sys.executable, ROOT / "meshes" / script, *arguments], check=True)

    def estar(shape, name, core, rings, axial):
        cells = ["--core-cells", core, "--rings", rings, "--axial-cells", axial, "--grading", 4]
        subprocess.run([ESTAR, "mesh", shape, *map(str, cells), "--output", meshes / name, "--force"], check=True)

    for n in COOK:
        python("cook/cook.py", "--elements", str(n), "--output", str(meshes / f"cook{n}.msh"))
    python("necking/necking.py", "--output", str(meshes / "neck405.msh"))
    estar("necking-bar", "neck960.msh", 4, 4, 20)
    python("necking/necking.py", "--refine", "2", "--output", str(meshes / "neck3240.msh"))
    python("taylor/taylor.py", "--full", "--output", str(meshes / "taylor_full.msh"))
    for k in GRADED:
        estar("cylinder", f"cyl{k}.msh", 2 * k, 2 * k, 20 * k)


def run_all(directory):
    make_meshes(directory / "meshes")
    for name, deck, overrides in runs(directory / "meshes"):
        summary = directory / name / "summary.json"
        if summary.exists() and json.loads(summary.read_text())["status"] == "finished":
            continue
        command = [ESTAR, "run", ROOT / deck, "--output", directory / name, "--quiet", "--force"]
        for key, value in overrides.items():
            command += ["--set", f"{key}={value}"]
        print(name, "exit status", subprocess.run(command, stdout=subprocess.DEVNULL).returncode, flush=True)


class Run:
    """A finished run: `run["time"]` is a column of history.csv."""

    def __init__(self, directory, name):
        self.directory = directory / name
        self.summary = json.loads((self.directory / "summary.json").read_text())
        with open(self.directory / "history.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.columns = {key: [float(row[key]) for row in rows] for key in rows[0]}

    def __getitem__(self, column):
        return self.columns[column]

    def mm(self, column):
        return [1e3 * value for value in self[column]]

    def at(self, column, other, value):
        """Where the column `other` first reaches `value`, between rows by a straight line."""
        x, y = self[other], self[column]
        k = next(k for k in range(1, len(x)) if x[k - 1] < value <= x[k])
        return y[k - 1] + (value - x[k - 1]) / (x[k] - x[k - 1]) * (y[k] - y[k - 1])

    def last_frame(self):
        import pyvista

        return pyvista.read(sorted((self.directory / "fields").glob("*.vtu"))[-1])


# Published values, mm. Times in microseconds.
SIERRA = {  # composite tetrahedron, h = 0.19 mm: Carina.jl, benchmark/tet15-p1/taylor
    "time": [0, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 75, 80],
    "radius": [3.200, 4.522, 5.233, 5.773, 6.205, 6.552, 6.820, 7.015, 7.147, 7.218, 7.237, 7.236, 7.234, 7.234, 7.234,
               7.233, 7.233],
    "length": [32.400, 31.264, 30.139, 29.082, 28.065, 27.093, 26.189, 25.340, 24.562, 23.853, 23.221, 22.672, 22.213,
               21.850, 21.593, 21.449, 21.430],
}
Q1P0 = ([2, 4, 8, 16, 32], [2.130, 5.095, 6.314, 6.738, 6.884])  # Simo & Armero 1992
Q1E4 = ([2, 4, 8, 16, 32], [3.851, 6.450, 6.776, 6.930, 6.970])
Q4 = ([2, 5, 10, 15, 35], [0.359, 1.36, 2.89, 3.97, 5.80])  # Cesar de Sa
NECK = ([1, 2, 3, 4, 5, 6], [6.3, 6.1, 5.9, 5.3, 4.6, 3.7])  # Simo & Hughes 1998

INK, BLUE, RED, GREEN, GOLD, GREY = "#222222", "#1f5fa8", "#c0392b", "#2e8b57", "#d08a1a", "#9a9a9a"
SHADES = ["#9cc3e6", "#4d8fcc", "#1f5fa8", "#0b2f5c"]  # from coarse to fine


def style():
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    plt.rcParams.update({
        "font.size": 9, "axes.edgecolor": INK, "axes.labelcolor": INK, "axes.spines.top": False,
        "axes.spines.right": False, "axes.grid": True, "grid.color": "#e6e6e6", "grid.linewidth": 0.6,
        "lines.linewidth": 1.6, "legend.frameon": False, "legend.fontsize": 8, "axes.titlesize": 9.5,
        "axes.titlelocation": "left", "savefig.dpi": 150,
    })
    return plt


def save(figure, name):
    path = pathlib.Path(__file__).with_name(name)
    figure.tight_layout()
    figure.savefig(path)
    print(path, path.stat().st_size // 1024, "kB")


def outline(run):
    """r and z of the rod's meridian in the plane y = 0, mm: along the foot's outside, the side and the top."""
    import numpy

    grid = run.last_frame()
    first = grid.points - grid["displacement"]  # the frames hold current positions
    meridian = (abs(first[:, 1]) < 1e-9) & (numpy.hypot(first[:, 0], first[:, 1]) > 3.2e-3 - 1e-9)
    order = first[meridian][:, 2].argsort()
    points = grid.points[meridian][order]
    return 1e3 * points[:, 0], 1e3 * points[:, 2]


def draw_taylor(directory, plt):
    figure, axes = plt.subplots(1, 3, figsize=(10, 3.3), width_ratios=[1, 1, 1])
    for axis, probe, published, title in [
        (axes[0], "foot_radius", "radius", "foot radius, mm"), (axes[1], "length", "length", "length, mm"),
    ]:
        for k, shade in zip(GRADED, SHADES):
            run = Run(directory, f"taylor-k{k}")
            axis.plot([1e6 * t for t in run["time"]], run.mm(probe), color=shade, label=f"{run.summary['mesh']['hexes']:,} hexes")
        wall = Run(directory, "taylor-wall")
        axis.plot([1e6 * t for t in wall["time"]], wall.mm(probe), color=GOLD, ls="--", lw=1.2, label="wall that only pushes, 3,510")
        axis.plot(SIERRA["time"], SIERRA[published], "o", ms=4, mfc="none", color=RED, label="Sierra/SM, h = 0.19 mm")
        axis.set(xlabel="time, µs", title=title)
    axes[0].legend(loc="lower right")
    for probe, converged, colour, name in [("foot_radius", 7.22, BLUE, "R"), ("length", 21.42, GREEN, "L")]:
        sizes = [3.2 / (4 * k) for k in GRADED]
        values = [Run(directory, f"taylor-k{k}").mm(probe)[-1] for k in GRADED]
        axes[2].plot(sizes, [100 * (v / converged - 1) for v in values], "o-", color=colour, ms=4,
                     label=f"{name} against {converged} mm")
    axes[2].axhline(0, color=INK, lw=0.8)
    axes[2].set(xlabel="radial cell size, mm", title="deviation from the published value, %", xlim=(0, None))
    axes[2].legend()
    save(figure, "taylor_convergence.png")


def draw_locking(directory, plt):
    figure, axes = plt.subplots(1, 2, figsize=(8.6, 3.6), width_ratios=[1.35, 1])
    axis = axes[0]
    for element, colour in [("hex8-f-bar", BLUE), ("hex8", RED)]:
        tips = [Run(directory, f"cook-{n}-{element}").mm("tip_displacement")[-1] for n in COOK]
        axis.plot(COOK, tips, "o-", color=colour, ms=5, label=f"Estar {element}")
    axis.plot(*Q1P0, "x", color=BLUE, ms=8, mew=1.4, label="Q1P0, Simo & Armero")
    axis.plot(*Q1E4, "^:", color=GREY, ms=5, lw=1, mfc="none", label="Q1E4, Simo & Armero")
    axis.plot(*Q4, "+", color=RED, ms=8, mew=1.4, label="standard Q4, César de Sá")
    axis.set_xscale("log", base=2)
    axis.set_xticks(COOK, [str(n) for n in COOK])
    axis.set(xlabel="elements per side", title="Cook's membrane: tip displacement, mm", ylim=(0, 7.5))
    axis.legend(loc="lower right")
    axis = axes[1]
    for name, colour, label, side in [("taylor", BLUE, "hex8-f-bar", 1), ("taylor-hex8", RED, "hex8", -1)]:
        run = Run(directory, name)
        r, z = outline(run)
        radius, length = run.mm("foot_radius")[-1], run.mm("length")[-1]
        r, z = [0, *r, 0], [0, *z, length]
        axis.fill([side * x for x in r], z, color=colour, alpha=0.15, lw=0)
        axis.plot([side * x for x in r], z, color=colour)
        axis.text(side * 3.9, 17.5, f"{label}\nR {radius:.2f}\nL {length:.2f}", color=colour, fontsize=8,
                  ha="left" if side > 0 else "right")
    axis.plot([7.22, 0], [0, 21.42], "o", color=INK, ms=5, mfc="none", clip_on=False)
    axis.text(7.6, 0.7, "published\nR 7.22, L 21.42", color=INK, fontsize=8)
    axis.set(xlabel="r, mm", ylabel="z, mm", title="Taylor bar, 3,510 hexes", xlim=(-8, 13), ylim=(0, 23), aspect="equal")
    axis.grid(False)
    save(figure, "locking.png")


def draw_necking(directory, plt):
    figure, axes = plt.subplots(1, 3, figsize=(10.4, 3.5))
    for name, shade in [("neck405", GOLD), ("neck960", BLUE), ("neck3240", INK)]:
        for time, dashes in zip(PULL_TIMES, [":", "--", "-"]):
            if not (directory / f"{name}-{time}" / "summary.json").exists():
                continue
            run = Run(directory, f"{name}-{time}")
            label = f"{run.summary['mesh']['hexes']:,} hexes"
            u = run.mm("elongation")
            axes[0].plot(u, run.mm("neck_radius"), color=shade, ls=dashes, lw=1.3, label=label if dashes == "--" else None)
            axes[1].plot(u, run.mm("neck_radius"), color=shade, ls=dashes, lw=1.3)
            if dashes == "--":
                axes[2].plot(u, [4e-3 * abs(f) for f in run["quarter_force"]], color=shade, lw=1.3)
    for axis in axes[:2]:
        axis.errorbar(*NECK, yerr=0.1, fmt="o", color=RED, ms=4, mfc="none", lw=1, capsize=2, label="Simo & Hughes, ±0.1")
        axis.errorbar([7], [2.56], yerr=0.12, fmt="s", color=RED, ms=4, mfc="none", lw=1, capsize=2,
                      label="Simo, ±0.12")
    axes[0].set(xlabel="half elongation, mm", title="radius at the neck, mm")
    axes[0].plot([], [], color=GREY, ls="-", lw=1.3, label="in 12.6 ms")
    axes[0].plot([], [], color=GREY, ls="--", lw=1.3, label="in 4.2 ms")
    axes[0].plot([], [], color=GREY, ls=":", lw=1.3, label="in 1.4 ms")
    axes[0].legend(loc="lower left")
    axes[1].set(xlabel="half elongation, mm", title="the same, from 5 mm", xlim=(5, 7.15), ylim=(2.1, 4.9))
    axes[2].axhspan(76.89, 79.73, color=RED, alpha=0.12, lw=0, label="Considère: 76.9 to 79.7 kN")
    axes[2].set(xlabel="half elongation, mm", title="force on the whole bar in 4.2 ms, kN", ylim=(0, 90))
    axes[2].legend(loc="lower left")
    save(figure, "necking.png")


def table(directory):
    for name, *_ in runs(directory):
        if not (directory / name / "summary.json").exists():
            print(f"{name:20} not run")
            continue
        run = Run(directory, name)
        summary = run.summary
        probes = " ".join(f"{probe} {1e3 * value:.4f}" for probe, value in summary["probes"].items() if probe != "quarter_force")
        largest = max(abs(e) for e in run["energy_error"])
        print(f"{name:20} hexes {summary['mesh']['hexes']:6} steps {summary['steps']:7} mass {1e3 * summary['mesh']['mass']:.5f} g "
              f"T0 {run['kinetic_energy'][0]:.4f} J eps {summary['extremes']['max_equivalent_plastic_strain']:.3f} "
              f"error {100 * summary['energy_error']:+.4f} % (largest {100 * largest:.4f} %) {probes}")
        if name.startswith("neck"):
            row = [f"{1e3 * run.at('neck_radius', 'elongation', 1e-3 * u):.3f}" for u in range(1, 7)]
            late = [k / i for k, i, u in zip(run["kinetic_energy"], run["internal_energy"], run["elongation"]) if u > 0.5e-3]
            print(f"{'':20} radius at 1..6 mm: {' '.join(row)}; peak force {4e-3 * max(map(abs, run['quarter_force'])):.2f} kN;"
                  f" kinetic / internal energy past 0.5 mm: at most {100 * max(late):.3f} %")


if __name__ == "__main__":
    command, directory = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    if command == "run":
        run_all(directory)
    elif command == "table":
        table(directory)
    else:
        plt = style()
        draw_taylor(directory, plt)
        draw_locking(directory, plt)
        draw_necking(directory, plt)
