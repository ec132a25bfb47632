"""Colours of pictures and reports, and how the parts of the energy are drawn."""

# Okabe and Ito's palette: told apart with any kind of colour vision.
BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK = (
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
SERIES = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, BLACK)

ENERGY_LINES = (
    ("kinetic", "kinetic", BLUE, "-"),
    ("line_strain", "strain of the line", VERMILLION, "-"),
    ("fictitious_springs", "fictitious springs", GREEN, "-"),
    ("load_potential", "potential of the load", ORANGE, "-"),
    ("lost_in_impacts", "lost in impacts", PURPLE, "-"),
    ("load_work", "brought in by changing loads", SKY, "-"),
    ("support_springs", "springs of the supports", GREEN, ":"),
    ("support_work", "brought in by moving supports", SKY, ":"),
    ("base_work", "brought in by the moving base", SKY, "--"),
    ("lost_in_dampers", "lost in dampers", PURPLE, ":"),
    ("radiated", "radiated into modes left out", ORANGE, ":"),
    ("lost_in_hinges", "lost in plastic hinges", VERMILLION, ":"),
    ("total", "total", BLACK, "--"),
)
# Shown where there is any.
SELDOM = ("load_work", "support_springs", "support_work", "base_work", "lost_in_dampers", "radiated",
          "lost_in_hinges")
