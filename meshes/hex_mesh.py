"""What the mesh scripts share: the O-grid of a round bar, groups by place, and writing.

Needs Gmsh's Python module: pip install gmsh
"""

import math

import gmsh


def start(name):
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    gmsh.model.add(name)


def write(path):
    """Writes binary format 4.1 and says what is in it."""
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.option.setNumber("Mesh.Binary", 1)
    gmsh.write(path)
    _, tags, _ = gmsh.model.mesh.getElements(3)
    hexes = [tag for block in tags for tag in block]
    quality = gmsh.model.mesh.getElementQualities(hexes, "minSJ")
    volume = sum(gmsh.model.mesh.getElementQualities(hexes, "volume"))
    nodes = set()
    for _, tag in gmsh.model.getEntities(3):
        nodes.update(gmsh.model.mesh.getNodes(3, tag, includeBoundary=True)[0])
    print(f"{path}: {len(hexes)} hexes, {len(nodes)} nodes, volume {volume:.6g}, "
          f"Gmsh's minSJ {min(quality):.4f} at least, {sum(quality) / len(quality):.4f} on average")
    gmsh.finalize()


def graded(cells, ratio):
    """The upper ends of cells that fill 0 to 1, the last `ratio` times as long as the first."""
    growth = ratio ** (1.0 / (cells - 1)) if cells > 1 else 1.0
    sizes = [growth ** k for k in range(cells)]
    return [sum(sizes[: k + 1]) / sum(sizes) for k in range(cells)]


def round_bar(radius, length, core, rings, axial, ratio=1.0, quarters=1):
    """A bar along z whose quarter section has `core` x `core` quads in its core and `rings` rings around it.

    Straight core sides would leave angles of 135 degrees in the rings. They are arcs, which leave the axes at right
    angles and meet at the diagonal in about 120 degrees.
    """
    geo = gmsh.model.geo
    half = 0.95 * radius * core / (core + rings)  # where the core crosses the axes
    diagonal = 0.9045 * half  # x and y of its corners
    centre = (half**2 - 2 * diagonal**2) / (2 * (half - diagonal))  # of the arc from the x axis to the corner

    def at(distance_x, distance_y, quarter):
        c, s = [(1, 0), (0, 1), (-1, 0), (0, -1)][quarter % 4]
        return geo.addPoint(c * distance_x - s * distance_y, s * distance_x + c * distance_y, 0)

    origin = geo.addPoint(0, 0, 0)
    axis_inner = [at(half, 0, q) for q in range(quarters + 1 if quarters < 4 else 4)]
    axis_outer = [at(radius, 0, q) for q in range(len(axis_inner))]
    to_core = [geo.addLine(origin, inner) for inner in axis_inner]
    to_side = [geo.addLine(inner, outer) for inner, outer in zip(axis_inner, axis_outer)]
    surfaces, sides = [], []
    for q in range(quarters):
        n = (q + 1) % len(axis_inner)
        corner = at(diagonal, diagonal, q)
        outer = at(radius * math.cos(math.pi / 4), radius * math.sin(math.pi / 4), q)
        first = geo.addCircleArc(axis_inner[q], at(centre, 0, q), corner)
        second = geo.addCircleArc(corner, at(0, centre, q), axis_inner[n])
        spoke = geo.addLine(corner, outer)
        rim_first = geo.addCircleArc(axis_outer[q], origin, outer)
        rim_second = geo.addCircleArc(outer, origin, axis_outer[n])
        for curve in (to_core[q], to_core[n], first, second, rim_first, rim_second):
            geo.mesh.setTransfiniteCurve(curve, core + 1)
        for curve in (to_side[q], to_side[n], spoke):
            geo.mesh.setTransfiniteCurve(curve, rings + 1)
        for loop in (
            [to_core[q], first, second, -to_core[n]],
            [to_side[q], rim_first, -spoke, -first],
            [spoke, rim_second, -to_side[n], -second],
        ):
            surface = geo.addPlaneSurface([geo.addCurveLoop(loop)])
            geo.mesh.setTransfiniteSurface(surface)
            geo.mesh.setRecombine(2, surface)
            surfaces.append(surface)
        sides += [rim_first, rim_second]
    geo.extrude([(2, s) for s in surfaces], 0, 0, length, [1] * axial, graded(axial, ratio), recombine=True)
    geo.synchronize()
    gmsh.model.mesh.generate(3)
    return {"rim": axis_outer[0]}


def name_volume(name):
    gmsh.model.addPhysicalGroup(3, [tag for _, tag in gmsh.model.getEntities(3)], name=name)


def name_where(dimension, name, test):
    """Names the surfaces or curves of which every node passes the test of its position."""
    found = []
    for _, tag in gmsh.model.getEntities(dimension):
        _, positions, _ = gmsh.model.mesh.getNodes(dimension, tag, includeBoundary=True)
        points = [positions[k : k + 3] for k in range(0, len(positions), 3)]
        if points and all(test(*point) for point in points):
            found.append(tag)
    assert found, f"nothing to call {name}"
    gmsh.model.addPhysicalGroup(dimension, found, name=name)


def name_node(name, position):
    """Names the point of the geometry at a position."""
    for _, tag in gmsh.model.getEntities(0):
        if math.dist(gmsh.model.getValue(0, tag, []), position) < 1e-9:
            gmsh.model.addPhysicalGroup(0, [tag], name=name)
            return
    raise AssertionError(f"no point at {position}")
