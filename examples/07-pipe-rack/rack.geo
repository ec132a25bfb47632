// Four steel portals, 6 m apart, joined by two rails, carry three pipes. Lengths in m; y is up.
// gmsh rack.geo -1 -o rack.msh
SetFactory("Built-in");
bay = 6; height = 5; width = 4; overhang = 1;

// Points of portal f: 1 and 7 feet, 2 and 6 knees, 3 to 5 where the pipes lie.
posts[] = {}; beams[] = {}; rails[] = {}; pipe_300[] = {}; pipe_200[] = {}; pipe_100[] = {}; feet[] = {};
For f In {0:3}
  n = 100 * (f + 1); x = f * bay;
  Point(n + 1) = {x, 0, 0};
  Point(n + 2) = {x, height, 0};
  Point(n + 3) = {x, height, 1};
  Point(n + 4) = {x, height, 2};
  Point(n + 5) = {x, height, 3};
  Point(n + 6) = {x, height, width};
  Point(n + 7) = {x, 0, width};
  For i In {1:6}
    Line(n + i) = {n + i, n + i + 1};
  EndFor
  Transfinite Curve {n + 1, n + 6} = 11;
  Transfinite Curve {n + 2 : n + 5} = 3;
  posts[] += {n + 1, n + 6};
  beams[] += {n + 2 : n + 5};
  feet[] += {n + 1, n + 7};
EndFor

// From portal to portal; the pipe in the middle has a valve in its second bay.
Point(1) = {1.5 * bay, height, 2};
For f In {0:2}
  n = 100 * (f + 1);
  Line(n + 12) = {n + 2, n + 102};
  Line(n + 13) = {n + 3, n + 103};
  Line(n + 15) = {n + 5, n + 105};
  Line(n + 16) = {n + 6, n + 106};
  Transfinite Curve {n + 12, n + 13, n + 15, n + 16} = 13;
  rails[] += {n + 12, n + 16};
  pipe_300[] += {n + 13};
  pipe_100[] += {n + 15};
  If (f == 1)
    Line(n + 14) = {n + 4, 1};
    Line(n + 24) = {1, n + 104};
    Transfinite Curve {n + 14, n + 24} = 7;
    pipe_200[] += {n + 14, n + 24};
  Else
    Line(n + 14) = {n + 4, n + 104};
    Transfinite Curve {n + 14} = 13;
    pipe_200[] += {n + 14};
  EndIf
EndFor

// The pipes go on beyond the first and the last portal.
For i In {3:5}
  Point(10 + i) = {-overhang, height, i - 2};
  Point(20 + i) = {3 * bay + overhang, height, i - 2};
  Line(10 + i) = {10 + i, 100 + i};
  Line(20 + i) = {400 + i, 20 + i};
  Transfinite Curve {10 + i, 20 + i} = 3;
EndFor
pipe_300[] += {13, 23};
pipe_200[] += {14, 24};
pipe_100[] += {15, 25};

Physical Curve("posts") = posts[];
Physical Curve("beams") = beams[];
Physical Curve("rails") = rails[];
Physical Curve("pipe 300") = pipe_300[];
Physical Curve("pipe 200") = pipe_200[];
Physical Curve("pipe 100") = pipe_100[];
Physical Point("feet") = feet[];
Physical Point("valve") = {1};
