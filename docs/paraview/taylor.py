"""The Taylor bar in ParaView: the quarter mirrored to half of the rod, coloured by plastic strain, at its last frame.

In ParaView: File > Load State, choose this file. It opens meshes/taylor/taylor/results.pvd or taylor/taylor/results.pvd,
whichever there is where ParaView was started or above this file; ESTAR_RESULTS=/path/to/results.pvd names another.
Without a window: pvbatch docs/paraview/taylor.py RESULTS.pvd PICTURE.png
"""

import os
import pathlib
import sys

from paraview import simple


def results():
    """The results.pvd that is meant."""
    named = sys.argv[1] if len(sys.argv) > 1 and sys.argv[1].endswith(".pvd") else os.environ.get("ESTAR_RESULTS")
    if named:
        return named
    folders = [pathlib.Path.cwd()]
    if "__file__" in globals():
        folders += pathlib.Path(__file__).resolve().parents
    for folder in folders:
        for place in ["meshes/taylor/taylor", "taylor/taylor", "taylor", "."]:
            if (folder / place / "results.pvd").is_file():
                return str(folder / place / "results.pvd")
    raise FileNotFoundError("no results.pvd: run `estar run meshes/taylor/taylor.toml`, or set ESTAR_RESULTS to the file's path")


# 1. the frames, and the time of the last one
frames = simple.PVDReader(registrationName="results", FileName=results())
scene = simple.GetAnimationScene()
scene.UpdateAnimationUsingDataTimeSteps()
scene.GoToLast()

# 2. the quarter and its mirror image in the plane x = 0: the cut y = 0 faces the eye
mirrored = simple.Reflect(registrationName="mirrored in x = 0", Input=frames)
mirrored.Plane = "X"
mirrored.Center = 0.0

# 3. one value a node, so that colours run smoothly
smooth = simple.CellDatatoPointData(registrationName="at nodes", Input=mirrored)

# 4. surface with edges, coloured by the equivalent plastic strain from 0 to 2
view = simple.GetActiveViewOrCreate("RenderView")
view.UseColorPaletteForBackground = 0
view.Background = [1.0, 1.0, 1.0]
shown = simple.Show(smooth, view)
shown.Representation = "Surface With Edges"
shown.Ambient = 0.3
shown.EdgeColor = [0.25, 0.25, 0.25]
simple.ColorBy(shown, ("POINTS", "equivalent_plastic_strain"))
colours = simple.GetColorTransferFunction("equivalent_plastic_strain")
colours.ApplyPreset("Oranges", True)
colours.InvertTransferFunction()  # light where there is none
colours.RescaleTransferFunction(0.0, 2.0)
bar = simple.GetScalarBar(colours, view)
bar.Title = "equivalent plastic strain"
bar.ComponentTitle = ""
bar.TitleFontSize, bar.LabelFontSize = 16, 16
bar.TitleColor = bar.LabelColor = [0.0, 0.0, 0.0]
bar.ScalarBarLength = 0.5
shown.SetScalarBarVisibility(view, True)

# 5. the time in a corner
time = simple.AnnotateTimeFilter(registrationName="time", Input=frames)
time.Format = "t = {time:.1e} s"
label = simple.Show(time, view)
label.FontSize, label.Color = 16, [0.0, 0.0, 0.0]

# 6. from the front and a little above, z upwards
view.CameraPosition = [0.03, -0.09, 0.045]
view.CameraFocalPoint = [0.0, 0.0, 0.0105]
view.CameraViewUp = [0.0, 0.0, 1.0]
view.CameraParallelProjection = 1
view.CameraParallelScale = 0.0135

pictures = [argument for argument in sys.argv[1:] if argument.endswith(".png")]
if pictures:
    view.ViewSize = [1000, 1000]
simple.Render(view)
if pictures:
    simple.SaveScreenshot(pictures[0], view, ImageResolution=[1000, 1000])
    print(f"wrote {pictures[0]}")
