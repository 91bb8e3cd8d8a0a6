"""Reads a results directory with VTK's own readers, as ParaView does, and prints what it found as JSON."""

import json
import pathlib
import sys
import xml.etree.ElementTree as ElementTree

from vtk import vtkXMLUnstructuredGridReader
from vtk.util.numpy_support import vtk_to_numpy

HEXAHEDRON = 12


def read(path):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    if reader.GetErrorCode() != 0:
        sys.exit(f"VTK cannot read {path}: error {reader.GetErrorCode()}")
    return reader.GetOutput()


def arrays(data):
    return {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}


def summary(grid):
    points = vtk_to_numpy(grid.GetPoints().GetData())
    node, cell, field = arrays(grid.GetPointData()), arrays(grid.GetCellData()), arrays(grid.GetFieldData())
    stress = cell["cauchy_stress"]
    mean = stress[:, :3].mean(axis=1)
    deviator = stress.copy()
    deviator[:, :3] -= mean[:, None]
    # components in ParaView's order XX YY ZZ XY YZ XZ
    mises = (1.5 * ((deviator[:, :3] ** 2).sum(axis=1) + 2.0 * (deviator[:, 3:] ** 2).sum(axis=1))) ** 0.5
    return {
        "time": float(field["TimeValue"][0]),
        "points": len(points),
        "cells": grid.GetNumberOfCells(),
        "only_hexahedra": all(grid.GetCellType(i) == HEXAHEDRON for i in range(grid.GetNumberOfCells())),
        "node_fields": sorted(node),
        "cell_fields": sorted(cell),
        "length": float(points[:, 2].max() - points[:, 2].min()),
        "reference_length": float((points - node["displacement"])[:, 2].max()),
        "lowest_velocity": float(node["velocity"][:, 2].min()),
        "node_ids": sorted(int(i) for i in node["node_id"])[:2] + [len(set(node["node_id"].tolist()))],
        "element_ids": len(set(cell["element_id"].tolist())),
        "parts": sorted({int(p) for p in cell["part"]}),
        "largest_plastic_strain": float(cell["equivalent_plastic_strain"].max()),
        "pressure_error": float(abs(cell["pressure"] + mean).max()),
        "mises_error": float(abs(cell["von_mises_stress"] - mises).max()),
        "largest_mises": float(mises.max()),
    }


def main():
    directory = pathlib.Path(sys.argv[1])
    entries = ElementTree.parse(directory / "results.pvd").getroot().iter("DataSet")
    frames = [(float(entry.get("timestep")), directory / entry.get("file")) for entry in entries]
    print(json.dumps([{"listed_time": time, **summary(read(path))} for time, path in frames]))


main()
