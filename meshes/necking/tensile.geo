// An eighth of a round bar that necks (Simo & Hughes 1998). Lengths in mm.
// gmsh -3 tensile.geo -o tensile.msh
SetFactory("OpenCASCADE");

radius = 6.413;          // at the grip
neck = 0.982 * radius;   // in the middle, z = 0
half = 26.667;           // half the length

// the profile in the plane y = 0, turned about the z axis by a quarter
Point(1) = {0, 0, 0};
Point(2) = {neck, 0, 0};
Point(3) = {radius, 0, half};
Point(4) = {0, 0, half};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
bar[] = Extrude {{0, 0, 1}, {0, 0, 0}, Pi / 2} { Surface{1}; };

// names: what the deck calls them
e = 1e-3;
big = 2 * half;
Physical Volume("bar") = {bar[1]};
Physical Surface("symmetry_x") = Surface In BoundingBox{-e, -e, -e, e, big, big};
Physical Surface("symmetry_y") = Surface In BoundingBox{-e, -e, -e, big, e, big};
Physical Surface("symmetry_z") = Surface In BoundingBox{-e, -e, -e, big, big, e};
Physical Surface("grip") = Surface In BoundingBox{-e, -e, half - e, big, big, half + e};
Physical Point("neck") = Point In BoundingBox{neck - e, -e, -e, neck + e, e, e};

// fine where it will neck: 1.2 mm, growing to 3 mm at the grip
Mesh.MeshSizeFromPoints = 0;
Mesh.MeshSizeExtendFromBoundary = 0;
Field[1] = MathEval;
Field[1].F = "1.2 + 1.8 * z / 26.667";
Background Field = 1;
Mesh.ElementOrder = 2;   // tets of ten nodes, their edges on the surface
Mesh.Optimize = 1;
Mesh.OptimizeThreshold = 0.5;
