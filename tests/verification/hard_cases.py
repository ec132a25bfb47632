"""What the comparisons of ranks and of restarts have in common: cases with every kind of support and motion."""

import pathlib

# The orbits of these cases amplify a difference up to their end by less than 1000 (data/README.md), and 1e-12 m is what
# solves in another order of the ranks may differ by.
TOLERANCE = 1e-9  # [m]

MOTION = pathlib.Path(__file__).resolve().parent / "data" / "support_motion.csv"
GIVING = {  # one support moves, one gives way, one does both
    "support_position": "2,8,5",
    "support_width": "1,1,0.5",
    "support_height": "0,0,-0.1",
    "support_motion": f"{MOTION},none,{MOTION}",
    "support_stiffness": "inf,1e6,1e5",
    "support_damping": "0,1e3,0",
    "initial_height": 0.6,
    "ts_rtol": 1e-10,
}
# Steps of 1e-10 are by rounding, and an impulse between their ends is by where these are.
MOVING_LINE = {**GIVING, "contact_surface": "line", "support_damping": 0, "ts_rtol": 1e-8}
CROSSED = {
    "load_axles": f"{MOTION.parent / 'axles.csv'},{MOTION.parent / 'axles.csv'}",
    "load_axles_speed": "25,-18",
    "load_axles_start": "0.02,0.31",
    "initial_height": 0.6,
}
# A record of accelerations, and a displacement in place of the supports' own motion.
SHAKEN = {
    "base_motion": f"{MOTION.parent / 'base_motion.csv'},{MOTION}",
    "base_motion_kind": "acceleration,displacement",
    "base_motion_scale": "9.81,1",
    "load_position": 3.3,
    "load_table": MOTION.parent / "base_motion.csv",
    "initial_height": 0.6,
}
FORMULAS = {  # a force of every law, one of them even over a length
    "load_position": "3.3,5,7",
    "load_law": "harmonic,friedlander,random",
    "load_start": "0.05,0.3,0.1",
    "load_until": "0.7,0.6,0.75",
    "load_amplitude": "3e3,-2e4,0",
    "load_frequency": 4,
    "load_last_frequency": 7,
    "load_phase": 0.3,
    "load_duration": 0.1,
    "load_decay": 1.2,
    "load_density": 2e6,
    "load_band": "1,12",
    "load_period": 5,
    "load_seed": 3,
    "load_width": "0,4,0",
    "load_breadth": "0,0.2,0",
    "load_accuracy": 0.05,
    "initial_height": 0.6,
}
LAWS = {  # one for each kind of memory, and one pressed from the start
    "support_position": "2,8,5",
    "support_width": "1,1,0.5",
    "support_height": "0,0,0.7",
    "support_side": "below,below,above",
    "contact_law": "crush,hunt_crossley,bilinear",
    "contact_stiffness": "4e6,2e7,1e5",
    "contact_damping": 0.4,
    "contact_plateau_force": 2e4,
    "contact_bottoming_compression": 0.03,
    "contact_bottoming_stiffness": 1e6,
    "contact_unloading_stiffness": 3e5,
    "contact_preload": "0,0,1e4",
    "initial_height": 0.7,
    "ts_rtol": 1e-10,
}
DAMPED = {"damping_mass": 0.5, "damping_stiffness": 2e-3}
LINE_CONTACT = {"contact_surface": "line", "support_width": "0,1"}
MODAL = {"filter_frequency": None, "ts_type": "modal", "modal_modes": 12, "modal_estimate": "no"}
MODAL_LOADED = {  # every way in which modes are pushed and damped
    **MODAL,
    "support_position": "2,8,5",
    "support_width": "1,1,0.5",
    "support_height": "0,0,-0.1",
    "support_motion": f"{MOTION},none,{MOTION}",
    "support_stiffness": "1e7,1e6,1e5",
    "support_damping": "0,1e3,1e2",
    "damping_ratio": "0.01,0.02",
    "modal_retardation": 0.05,
    "initial_height": 0.6,
}
CORRECTED = {"filter_frequency": "auto", "filter_accuracy": 0.1, "filter_correct_mode": "1,3"}  # the third above wf
CORRECTED_LINE = {**CORRECTED, "contact_surface": "line", "support_position": "2,8,8.5", "support_stiffness": 2e7}
