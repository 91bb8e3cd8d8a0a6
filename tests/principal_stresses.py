"""Evaluates an expression of ParaView's Python Calculator on the cells of a frame, with the functions of VTK that it has there, and
prints how far the three numbers of each cell are from having the invariants of its stress: pressure, von Mises stress, determinant."""

import json
import sys

import numpy
from vtk import vtkXMLUnstructuredGridReader
from vtk.numpy_interface import algorithms, dataset_adapter

path, expression = sys.argv[1:]
reader = vtkXMLUnstructuredGridReader()
reader.SetFileName(path)
reader.Update()
cells = dataset_adapter.WrapDataObject(reader.GetOutput()).CellData
names = {name: cells[name] for name in cells.keys()}
functions = {name: getattr(algorithms, name) for name in dir(algorithms) if not name.startswith("_")}
first, second, third = numpy.asarray(eval(expression, {**functions, "numpy": numpy, **names})).T
xx, yy, zz, xy, yz, xz = numpy.asarray(names["cauchy_stress"]).T
determinant = xx * (yy * zz - yz**2) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
mises = numpy.sqrt(0.5 * ((first - second) ** 2 + (second - third) ** 2 + (third - first) ** 2))
print(
    json.dumps(
        {
            "cells": len(first),
            "falling": bool(((first >= second) & (second >= third)).all()),
            "largest": float(abs(first).max()),
            "pressure_error": float(abs((first + second + third) / 3.0 + names["pressure"]).max()),
            "determinant_error": float(abs(first * second * third - determinant).max()),
            "mises_error": float(abs(mises - names["von_mises_stress"]).max()),
        }
    )
)
