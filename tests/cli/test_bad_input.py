#!/usr/bin/env python3
# ranks: 1; size: long
"""Every mistake ends the run with one line that says what is wrong, on any number of ranks, and harms no file."""

import concurrent.futures
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

from common import UdarTest, case, digest, run

LAUNCHES = (0, 2)  # without mpiexec, and on two ranks
LONGEST_LINE = 400
WORKERS = 4

HARMONIC = {"load_law": "harmonic", "load_amplitude": 1e3, "load_frequency": 5}
RANDOM = {"load_law": "random", "load_density": 10, "load_band": "1,20", "load_period": 10}

# name: (changed options, what the message must contain)
REFUSED = {
    "unknown_option": ({"beam_elemnts": 20}, ["-beam_elemnts", "-beam_elements"]),
    "unknown_option_outside_the_groups": ({"suport_width": 1}, ["-suport_width", "-support_width"]),
    "unknown_option_without_a_group": ({"grvity": 9.81}, ["-grvity", "-gravity"]),
    "unknown_option_of_the_integrator": ({"ts_typ": "impact"}, ["-ts_typ", "-ts_type"]),
    "unknown_damping_option": ({"damping_mas": 1}, ["-damping_mas", "-damping_mass"]),
    "unknown_ground_option": ({"ground_profil": "hills.csv"}, ["-ground_profil", "-ground_profile"]),
    "unknown_contact_option": ({"contact_resitution": 0.5}, ["-contact_resitution", "-contact_restitution"]),
    "rotary_inertia_of_a_beam": ({"rotary_inertia": ""}, ["-rotary_inertia", "-structure_type network"]),
    "compression_beyond_gzip": ({"output_compression": 10}, ["-output_compression", "10", "9"]),
    "merged_without_a_window": ({"output_contacts": "merged"}, ["-output_contact_window", "> 0", "[s]"]),
    "window_without_merging": ({"output_contact_window": 0.1}, ["-output_contact_window", "-output_contacts"]),
    "window_of_no_time": (
        {"output_contacts": "both", "output_contact_window": 0}, ["-output_contact_window", "0", "> 0", "[s]"],
    ),
    "lists_of_another_kind": ({"output_contacts": "some"}, ["-output_contacts", "some", "merged"]),
    "unknown_field": ({"output_fields": "moment,froce"}, ["-output_fields", "'froce'", "mass_velocity", "moment"]),
    "region_of_three_numbers": ({"output_region": "1,2,3"}, ["-output_region", "3", "2, 4 or 6", "[m]"]),
    "region_from_right_to_left": ({"output_region": "5,2"}, ["-output_region", "below", "[m]"]),
    "region_beside_the_beam": ({"output_region": "11,12"}, ["-output_region", "no element"]),
    "members_of_a_beam": ({"output_members": "mast"}, ["-output_members", "network"]),
    "no_stride": ({"output_stride": 0}, ["-output_stride", "0", ">= 1"]),
    "negative_length": ({"beam_length": -10}, ["-beam_length", "-10", "> 0", "[m]"]),
    "two_heights": ({"initial_height": "1,2"}, ["-initial_height", "one value", "2"]),
    "two_radii_one_beam": ({"beam_radius": "0.1,0.2"}, ["-beam_radius", "2", "-beam_length"]),
    "length_without_value": ({"beam_length": True}, ["-beam_length", "> 0", "[m]"]),
    "part_of_another_section": ({"beam_inner_radius": 0.05}, ["-beam_inner_radius", "-beam_section"]),
    "yield_without_fibre": (
        {"beam_bending_stiffness": 1e6, "beam_yield_stress": 2e8},
        ["-beam_yield_stress", "-beam_outer_fibre", "[m]"],
    ),
    "negative_yield_moment": ({"beam_yield_moment": -1}, ["-beam_yield_moment", "-1", "> 0", "[N m]"]),
    "shape_factor_without_stress": ({"beam_shape_factor": 1.5}, ["-beam_shape_factor", "-beam_yield_stress", "[Pa]"]),
    "two_yield_moments": (
        {"beam_shape_factor": 1.5, "beam_yield_stress": 2e8, "beam_yield_moment": 1e4},
        ["-beam_yield_moment", "-beam_shape_factor", "exclude"],
    ),
    "hinge_without_yield_moment": (
        {"beam_hinge_position": 5}, ["-beam_hinge_position", "-beam_yield_moment", "[N m]"],
    ),
    "hinge_at_a_free_end": (
        {"beam_yield_moment": 1e4, "beam_hinge_position": 0}, ["-beam_hinge_position", "0", "free or pinned end"],
    ),
    "hinge_beyond_the_beam": (
        {"beam_yield_moment": 1e4, "beam_hinge_position": 11}, ["-beam_hinge_position", "11 m", "place on the beam"],
    ),
    "two_hinges_at_a_node": (
        {"beam_yield_moment": 1e4, "beam_hinge_position": "5,5.1"}, ["-beam_hinge_position", "one hinge at a node"],
    ),
    "negative_hinge_position": (
        {"beam_yield_moment": 1e4, "beam_hinge_position": -1}, ["-beam_hinge_position", "-1", ">= 0", "[m]"],
    ),
    "hardening_without_hinge": (
        {"beam_yield_moment": 1e4, "beam_hinge_hardening": 1e5}, ["-beam_hinge_hardening", "-beam_hinge_position"],
    ),
    "negative_hinge_hardening": (
        {"beam_yield_moment": 1e4, "beam_hinge_position": 5, "beam_hinge_hardening": -1},
        ["-beam_hinge_hardening", "-1", ">= 0", "[N m/rad]"],
    ),
    "hardening_of_another_kind": (
        {"beam_yield_moment": 1e4, "beam_hinge_position": 5, "beam_yield_hardening": 0.1},
        ["-beam_yield_hardening", "-beam_hinge_hardening"],
    ),
    "hardening_to_full_stiffness": (
        {"beam_yield_moment": 1e4, "beam_yield_hardening": 1}, ["-beam_yield_hardening", "1", "< 1"],
    ),
    "yielding_everywhere_filtered": ({"beam_yield_moment": 1e4}, ["-beam_hinge_position", "8", "[m]"]),
    "nine_hinges_filtered": (
        {"beam_yield_moment": 1e4, "beam_hinge_position": "1,2,3,4,5,6,7,8,9"}, ["-beam_hinge_position", "8", "[m]"],
    ),
    "too_many_hinges": (
        {"beam_yield_moment": 1e4, "beam_elements": 2100, "filter_frequency": "none", "ts_dt": 1e-3},
        ["-beam_hinge_position", "2000"],
    ),
    "yielding_on_many_points": (
        {"beam_yield_moment": 1e4, "beam_elements": 200, "support_position": None, "floor": True,
         "filter_frequency": "none", "ts_dt": 1e-3},
        ["-beam_yield_moment", "-contact_line_dense_max"],
    ),
    "yielding_by_impact": (
        {"beam_yield_moment": 1e4, "beam_hinge_position": 5, "ts_type": "impact"}, ["-ts_type", "impact", "chebyshev"],
    ),
    "yielding_on_a_held_line": (
        {"beam_yield_moment": 1e4, "beam_hinge_position": 5, "contact_surface": "line"},
        ["-contact_surface", "line", "mass"],
    ),
    "yielding_hermite": (
        {"beam_yield_moment": 1e4, "beam_hinge_position": 5, "beam_formulation": "hermite"},
        ["-beam_formulation", "hermite", "mixed"],
    ),
    "yielding_with_corrected_modes": (
        {"beam_yield_moment": 1e4, "beam_hinge_position": 5, "filter_correct_modes": 2},
        ["-beam_yield_moment", "-filter_correct_modes"],
    ),
    "nan_radius": ({"beam_radius": "nan"}, ["-beam_radius", "nan", "> 0", "[m]"]),
    "infinite_young_modulus": ({"beam_young_modulus": "inf"}, ["-beam_young_modulus", "inf", "[Pa]"]),
    "zero_elements": ({"beam_elements": 0}, ["-beam_elements", "0"]),
    "negative_elements": ({"beam_elements": -5}, ["-beam_elements", "-5"]),
    "half_an_element": ({"beam_elements": 2.5}, ["-beam_elements", "2.5", "whole"]),
    "elements_beyond_the_index_range": (
        {"beam_elements": 1100000000, "structure_memory": "inf"},
        ["-beam_elements", "1100000000", "at most 1073741822", "32 bits"],
    ),
    "too_many_elements": ({"beam_elements": 99999999999}, ["-beam_elements", "99999999999"]),
    "zero_density": ({"beam_density": 0}, ["-beam_density", "0", "> 0", "[kg/m^3]"]),
    "wrong_section": ({"beam_section": "hexagon"}, ["-beam_section", "hexagon", "circle"]),
    "wrong_theory": ({"beam_theory": "newton"}, ["-beam_theory", "newton", "timoshenko"]),
    "wrong_end": ({"beam_left_end": "glued"}, ["-beam_left_end", "glued", "clamped"]),
    "wrong_formulation": ({"beam_formulation": "cubic"}, ["-beam_formulation", "cubic", "mixed"]),
    "gap_in_one_segment": ({"beam_gap": 0.5}, ["-beam_gap", "-beam_length", "two segments"]),
    "three_gaps_two_joints": (
        {"beam_length": "3,4,3", "beam_gap": "1,1,1"},
        ["-beam_gap", "3 values", "1 or 2", "joint", "-beam_length"],
    ),
    "negative_gap": ({"beam_length": "5,5", "beam_gap": -0.5}, ["-beam_gap", "-0.5", ">= 0", "[m]"]),
    "line_support_off_the_beam": (
        {"beam_line_support_position": "2,12"},
        ["-beam_line_support_position", "12", "from 0 to 10", "[m]"],
    ),
    "line_support_before_the_beam": (
        {"beam_line_support_position": "-1,2"},
        ["-beam_line_support_position", "-1", ">= 0", "[m]"],
    ),
    "negative_line_support_stiffness": (
        {"beam_line_support_position": 2, "beam_line_support_stiffness": -5},
        ["-beam_line_support_stiffness", "-5", ">= 0", "[N/m]"],
    ),
    "three_stiffnesses_two_line_supports": (
        {"beam_line_support_position": "2,8", "beam_line_support_stiffness": "1,1,1"},
        ["-beam_line_support_stiffness", "3", "2", "-beam_line_support_position"],
    ),
    "stiffness_without_line_support": (
        {"beam_line_support_stiffness": 1e5},
        ["-beam_line_support_stiffness", "-beam_line_support_position"],
    ),
    "point_mass_off_the_beam": (
        {"beam_point_mass": 5, "beam_point_mass_position": 11},
        ["-beam_point_mass_position", "11", "from 0 to 10", "[m]"],
    ),
    "three_lanes": ({"filter_pc_chain_lanes": 3}, ["-filter_pc_chain_lanes", "3", "1, 4 or 8"]),
    "chain_with_tension": ({"filter_pc_type": "chain", "beam_tension": 1e5}, ["-filter_pc_type", "chain", "tension"]),
    "zero_filter_frequency": ({"filter_frequency": 0}, ["-filter_frequency", "0", "> 0", "[rad/s]"]),
    "missing_filter_frequency": ({"filter_frequency": None}, ["-filter_frequency", "[rad/s]"]),
    "filter_frequency_is_a_word": ({"filter_frequency": "abc"}, ["-filter_frequency", "abc", "[rad/s]"]),
    "filter_frequency_with_unit": ({"filter_frequency": "100Hz"}, ["-filter_frequency", "100Hz", "[rad/s]"]),
    "filter_frequency_is_almost_auto": ({"filter_frequency": "automatic"}, ["-filter_frequency", "automatic", "auto"]),
    "modes_and_band": (
        {"filter_frequency": "auto", "filter_modes": 2, "filter_band": 100},
        ["-filter_modes", "-filter_band", "exclude"],
    ),
    "accuracy_zero": (
        {"filter_frequency": "auto", "filter_accuracy": 0},
        ["-filter_accuracy", "0 ", "> 0 and <= 0.5"],
    ),
    "accuracy_one": ({"filter_frequency": "auto", "filter_accuracy": 1}, ["-filter_accuracy", "1", "<= 0.5"]),
    "accuracy_without_auto": ({"filter_accuracy": 0.01}, ["-filter_accuracy", "-filter_frequency auto"]),
    "band_without_auto": ({"filter_band": 50}, ["-filter_band", "-filter_frequency auto"]),
    "no_modes": ({"filter_frequency": "auto", "filter_modes": 0}, ["-filter_modes", "0", ">= 1"]),
    "more_modes_than_the_beam_has": (
        {"filter_frequency": "auto", "filter_modes": 20},
        ["-filter_modes", "20", "at most 19"],
    ),
    "corrects_more_modes_than_the_beam_has": (
        {"filter_correct_modes": 20},
        ["-filter_correct_modes", "20", "at most 19"],
    ),
    "corrects_a_mode_beyond_the_last": ({"filter_correct_mode": "1,21"}, ["-filter_correct_mode:", "21", "at most 19"]),
    "corrects_mode_zero": ({"filter_correct_mode": 0}, ["-filter_correct_mode", "0", ">= 1"]),
    "corrects_one_of_two_equal_modes": (
        {"beam_length": "10,10", "beam_gap": 1, "filter_correct_mode": 1, "support_position": None},
        ["-filter_correct_mode", "1", "2", "same frequency", "both or none"],
    ),
    "corrects_under_many_contact_points": (
        {"filter_correct_modes": 1, "contact_surface": "line", "contact_line_dense_max": 0},
        ["-filter_correct_modes", "more than 0 contact points", "-contact_surface mass"],
    ),
    "corrects_under_a_whole_floor": (
        {"filter_correct_modes": 1, "contact_surface": "line", "floor": True, "support_position": None},
        ["-filter_correct_modes", "too close", "-support_stiffness"],
    ),
    "corrects_modes_of_modes": (
        {"filter_correct_modes": 1, "filter_frequency": None, "contact_surface": "line"},
        ["-filter_correct_modes", "-ts_type modal"],
    ),
    "corrects_without_filter": (
        {"filter_correct_modes": 1, "filter_frequency": "none", "ts_dt": 1e-3},
        ["-filter_correct_modes", "-filter_frequency none"],
    ),
    "gauge_off_the_beam": ({"gauge_position": "5,12"}, ["-gauge_position", "12", "10", "[m]"]),
    "support_off_the_beam": ({"support_position": "2,-1"}, ["-support_position", "-1", "10", "[m]"]),
    "load_off_the_beam": ({"load_position": 11, "load_table": "table.csv"}, ["-load_position", "11", "10", "[m]"]),
    "restitution_above_one": ({"contact_restitution": 1.5}, ["-contact_restitution", "1.5", "from 0 to 1"]),
    "restitution_negative": ({"contact_restitution": -0.1}, ["-contact_restitution", "-0.1", "from 0 to 1"]),
    "negative_tolerance": ({"contact_tolerance": -1e-9}, ["-contact_tolerance", "[m]"]),
    "support_in_the_beam": ({"support_height": "0,1.5"}, ["-support_height", "1.5", "[m]"]),
    "ceiling_in_the_beam": ({"support_side": "above,below"}, ["support", "overlap"]),
    "wrong_side": ({"support_side": "left"}, ["-support_side", "left", "below"]),
    "floor_in_the_beam": ({"floor": True, "floor_height": 2}, ["-floor_height", "2", "[m]"]),
    "ground_and_floor": (
        {"ground_profile": "table.csv", "floor": True},
        ["-ground_profile", "table.csv", "-floor", "[m]"],
    ),
    "ground_in_the_beam": ({"ground_profile": "hill.csv"}, ["-ground_profile", "1.5", "overlaps", "[m]"]),
    "ground_profile_goes_back": ({"ground_profile": "back.csv"}, ["-ground_profile", "back.csv", "ascending", "[m]"]),
    "ragged_ground_profile": ({"ground_profile": "ragged.csv"}, ["-ground_profile", "ragged.csv", "line 3"]),
    "zero_yield_speed": ({"support_yield_speed": 0}, ["-support_yield_speed", "0", "> 0", "[m/s]"]),
    "three_yield_speeds_two_supports": ({"support_yield_speed": "1,1,1"}, ["-support_yield_speed", "3", "2"]),
    "supports_nearer_than_the_mesh": (
        {"support_position": "2,3.1", "support_width": 1},
        ["-beam_elements", "20", "at least 200", "2.5", "2.6"],
    ),
    "motion_goes_back": ({"support_motion": "back.csv"}, ["-support_motion", "back.csv", "ascending", "[s]"]),
    "motion_of_one_row": ({"support_motion": "still.csv"}, ["-support_motion", "two rows"]),
    "motion_stops_dead": (
        {"support_motion": "dead.csv"},
        ["-support_motion", "10 m/s", "0.01 s", "last row", "-ts_max_time"],
    ),
    "three_motions_two_supports": ({"support_motion": "table.csv,none,none"}, ["-support_motion", "3", "2"]),
    "motion_by_chebyshev": (
        {"support_motion": "motion.csv", "ts_type": "chebyshev"},
        ["-ts_type", "chebyshev", "-support_motion", "impact, rk", "cubic"],
    ),
    "spring_by_chebyshev": (
        {"support_stiffness": 1e6, "ts_type": "chebyshev"},
        ["-ts_type", "chebyshev", "-support_stiffness", "impact, rk", "matrix"],
    ),
    "damper_under_the_line": (
        {"support_stiffness": 1e6, "support_damping": 10, "contact_surface": "line"},
        ["-support_damping", "massless line", "expected 0", "-contact_surface line", "[N s/m]"],
    ),
    "restitution_by_modal": (
        {"contact_restitution": 0.5, "ts_type": "modal", "filter_frequency": None},
        ["-contact_restitution", "0.5", "-ts_type modal", "expected 1"],
    ),
    "damping_of_modes_by_impact": (
        {"damping_ratio": 0.01, "ts_type": "impact"},
        ["-damping_ratio", "damping of each mode", "-ts_type impact"],
    ),
    "damping_ratio_of_one": (
        {"damping_ratio": "0.01,1", "ts_type": "modal", "filter_frequency": None},
        ["-damping_ratio", "1", "below 1"],
    ),
    "long_retardation": (
        {"modal_retardation": 7, "ts_type": "modal", "filter_frequency": None},
        ["-modal_retardation", "7", "0 to 1"],
    ),
    "yield_speed_under_the_line": (
        {"support_yield_speed": 0.5, "contact_surface": "line"},
        ["-support_yield_speed", "-contact_surface line"],
    ),
    "motion_under_the_line_by_chebyshev": (
        {"support_motion": "motion.csv", "contact_surface": "line", "ts_type": "chebyshev"},
        ["-ts_type", "chebyshev", "-support_motion", "impact, rk", "cubics"],
    ),
    "many_points_of_the_line_by_chebyshev": (
        {"support_width": "1,3", "contact_surface": "line", "ts_type": "chebyshev"},
        ["-ts_type", "chebyshev", "more than 8 contact points", "impact, rk"],
    ),
    "motion_over_the_floor": (
        {"support_motion": "motion.csv", "floor": True},
        ["-support_position", "no other support"],
    ),
    "negative_damping": ({"damping_mass": -1}, ["-damping_mass", "-1", ">= 0", "[1/s]"]),
    "infinite_damping": ({"damping_stiffness": "inf"}, ["-damping_stiffness", "inf", ">= 0", "[s]"]),
    "damping_by_chebyshev": (
        {"damping_mass": 1, "ts_type": "chebyshev"},
        ["-ts_type", "chebyshev", "-damping_mass", "impact, rk"],
    ),
    "damping_under_line_contact": (
        {"damping_stiffness": 1e-3, "contact_surface": "line"},
        ["-damping_stiffness", "-contact_surface line", "expected 0", "[s]"],
    ),
    "zero_stiffness": ({"support_stiffness": 0}, ["-support_stiffness", "0", "> 0", "[N/m]"]),
    "spring_with_restitution": (
        {"support_stiffness": 1e6, "contact_restitution": 0.5},
        ["-contact_restitution", "0.5", "-support_stiffness"],
    ),
    "spring_with_yield_speed": (
        {"support_stiffness": 1e6, "support_yield_speed": 0.5},
        ["-support_yield_speed", "0.5", "-support_stiffness"],
    ),
    "striker_without_mass": ({"striker_position": 5}, ["-striker_mass", "-striker_position", "[kg]"]),
    "mass_without_striker": ({"striker_mass": 5}, ["-striker_mass", "nothing", "-striker_position"]),
    "striker_without_weight": ({"striker_position": 5, "striker_mass": 0}, ["-striker_mass", "0", "> 0", "[kg]"]),
    "striker_in_space_of_a_beam": (
        {"striker_place": "5,0,0", "striker_mass": 1},
        ["-striker_place", "-striker_junction", "-striker_position", "[m]"],
    ),
    "striker_at_a_junction_of_a_beam": (
        {"striker_junction": "middle", "striker_mass": 1},
        ["-striker_place", "-striker_junction", "-striker_position", "[m]"],
    ),
    "striker_faster_than_light": (
        {"striker_position": 5, "striker_mass": 1, "striker_velocity": -1e9},
        ["-striker_velocity", "1e+09", "speed of light", "m/s"],
    ),
    "striker_from_the_stars": (
        {"striker_position": 5, "striker_mass": 1, "striker_gap": 1e12},
        ["-striker_gap", "1e+12", "[m]"],
    ),
    "table_of_a_striker_that_does_not_exist": (
        {"striker_position": 5, "striker_mass": 1, "striker_law": "table", "striker_unloading_stiffness": 1e9,
         "striker_table": "no_such_file.csv"},
        ["-striker_table", "no_such_file.csv"],
    ),
    "law_of_a_striker_by_runge_kutta": (
        {"striker_position": 5, "striker_mass": 1, "striker_law": "hertz", "striker_stiffness": 1e8, "ts_type": "rk"},
        ["rk", "-striker_law", "impact"],
    ),
    "load_over_a_gap_beside_a_striker": (
        {"beam_length": "5,5", "beam_gap": 0.5, "beam_elements": 10, "load_position": 5, "load_width": 3,
         "load_table": "table.csv", "striker_position": 5, "striker_mass": 1},
        ["-load_width", "without gaps"],
    ),
    "two_masses_three_strikers": (
        {"striker_position": "4,5,6", "striker_mass": "1,2"},
        ["-striker_mass", "2", "3", "-striker_position"],
    ),
    "striker_off_the_beam": (
        {"striker_position": 11, "striker_mass": 1},
        ["-striker_position", "11", "from 0 to 10", "[m]"],
    ),
    "striker_over_a_support": (
        {"striker_position": 2, "striker_mass": 1},
        ["-striker_position", "no support", "x = 2"],
    ),
    "striker_over_a_floor": (
        {"floor": "true", "striker_position": 5, "striker_mass": 1},
        ["-striker_position", "floor"],
    ),
    "two_strikers_at_a_node": (
        {"striker_position": "5,5.01", "striker_mass": 1},
        ["-striker_position", "5.01", "a node of its own"],
    ),
    "striker_on_a_held_end": (
        {"beam_left_end": "clamped", "striker_position": 0, "striker_mass": 1},
        ["-striker_position", "this one is held"],
    ),
    "striker_in_the_beam": (
        {"striker_position": 5, "striker_mass": 1, "striker_gap": -1},
        ["-striker_gap", "-1", ">= 0"],
    ),
    "striker_beside_the_beam": (
        {"striker_position": 5, "striker_mass": 1, "striker_side": "left"},
        ["-striker_side", "left", "above", "below"],
    ),
    "striker_that_gains": (
        {"striker_position": 5, "striker_mass": 1, "striker_restitution": 1.1},
        ["-striker_restitution", "1.1", "from 0 to 1"],
    ),
    "striker_that_never_yields": (
        {"striker_position": 5, "striker_mass": 1, "striker_yield_speed": 0},
        ["-striker_yield_speed", "0", "> 0", "[m/s]"],
    ),
    "restitution_and_law_of_a_striker": (
        {"striker_position": 5, "striker_mass": 1, "striker_law": "hertz", "striker_stiffness": 1e8,
         "striker_restitution": 0.5},
        ["-striker_restitution", "0.5", "-striker_law", "1"],
    ),
    "law_of_a_striker_without_stiffness": (
        {"striker_position": 5, "striker_mass": 1, "striker_law": "hertz"},
        ["-striker_stiffness", "0", "> 0", "[N/m^n]"],
    ),
    "exponent_of_no_striker": (
        {"striker_position": 5, "striker_mass": 1, "striker_exponent": 1.5},
        ["-striker_exponent", "-striker_law hunt_crossley", "striker"],
    ),
    "striker_table_is_missing": (
        {"striker_position": 5, "striker_mass": 1, "striker_law": "table", "striker_unloading_stiffness": 1e9},
        ["-striker_table", "-striker_law", "compression"],
    ),
    "striker_by_modes": (
        {"striker_position": 5, "striker_mass": 1, "ts_type": "modal", "filter_frequency": None},
        ["-striker_position"],
    ),
    "striker_on_a_held_line": (
        {"striker_position": 5, "striker_mass": 1, "contact_surface": "line"},
        ["-contact_surface", "line", "-striker_position", "mass"],
    ),
    "striker_and_exact_modes": (
        {"striker_position": 5, "striker_mass": 1, "filter_correct_modes": 1},
        ["-filter_correct_modes", "-striker_position"],
    ),
    "unknown_contact_law": ({"contact_law": "hooke"}, ["-contact_law", "hooke", "hertz", "hunt_crossley", "table"]),
    "three_laws_two_supports": ({"contact_law": "hertz,hertz,none"}, ["-contact_law", "3", "2"]),
    "hertz_without_stiffness": ({"contact_law": "hertz"}, ["-contact_stiffness", "0", "> 0", "[N/m^n]"]),
    "negative_contact_stiffness": (
        {"contact_law": "hertz", "contact_stiffness": -1},
        ["-contact_stiffness", "-1", "> 0", "[N/m^n]"],
    ),
    "stiffness_of_no_law": ({"contact_stiffness": 1e6}, ["-contact_stiffness", "-contact_law", "hertz"]),
    "contact_exponent": (
        {"contact_law": "hunt_crossley", "contact_stiffness": 1e6, "contact_exponent": 0.5},
        ["-contact_exponent", "0.5", "from 1 to 3"],
    ),
    "exponent_of_hertz": (
        {"contact_law": "hertz", "contact_stiffness": 1e6, "contact_exponent": 2},
        ["-contact_exponent", "-contact_law hunt_crossley"],
    ),
    "contact_damping": (
        {"contact_law": "hunt_crossley", "contact_stiffness": 1e6, "contact_damping": -0.1},
        ["-contact_damping", "-0.1", ">= 0", "[s/m]"],
    ),
    "bilinear_without_unloading": (
        {"contact_law": "bilinear", "contact_stiffness": 1e6},
        ["-contact_unloading_stiffness", "0", "no less than any slope", "[N/m]"],
    ),
    "unloads_softer_than_it_loads": (
        {"contact_law": "bilinear", "contact_stiffness": 1e6, "contact_unloading_stiffness": 5e5},
        ["-contact_unloading_stiffness", "500000", "no less than any slope", "[N/m]"],
    ),
    "crush_without_plateau": (
        {"contact_law": "crush", "contact_stiffness": 1e6},
        ["-contact_plateau_force", "0", "> 0", "[N]"],
    ),
    "crush_that_bottoms_out_at_once": (
        {
            "contact_law": "crush",
            "contact_stiffness": 1e6,
            "contact_plateau_force": 1e4,
            "contact_bottoming_compression": 0.01,
        },
        ["-contact_bottoming_compression", "0.01", "above", "[m]"],
    ),
    "crush_that_hardens_beyond_its_own": (
        {
            "contact_law": "crush",
            "contact_stiffness": 1e6,
            "contact_plateau_force": 1e4,
            "contact_bottoming_compression": 0.1,
            "contact_bottoming_stiffness": 1e7,
        },
        ["-contact_bottoming_stiffness", "1e+07", "to the elastic stiffness", "[N/m]"],
    ),
    "bottoming_of_no_crush": (
        {"contact_law": "hertz", "contact_stiffness": 1e6, "contact_bottoming_stiffness": 1e5},
        ["-contact_bottoming_stiffness", "-contact_law crush"],
    ),
    "table_without_a_file": (
        {"contact_law": "table", "contact_unloading_stiffness": 1e6},
        ["-contact_table", "-contact_law table", "[m]", "[N]"],
    ),
    "contact_table_goes_back": (
        {"contact_law": "table", "contact_unloading_stiffness": 1e6, "contact_table": "back.csv"},
        ["-contact_table", "back.csv", "ascending", "[m]"],
    ),
    "contact_table_begins_with_a_force": (
        {"contact_law": "table", "contact_unloading_stiffness": 1e6, "contact_table": "hill.csv"},
        ["-contact_table", "first is 0", "[N]"],
    ),
    "table_of_no_law": ({"contact_table": "table.csv"}, ["-contact_table", "-contact_law table"]),
    "negative_preload": (
        {"contact_law": "hertz", "contact_stiffness": 1e6, "contact_preload": -5},
        ["-contact_preload", "-5", ">= 0", "[N]"],
    ),
    "preload_beyond_the_plateau": (
        {"contact_law": "crush", "contact_stiffness": 1e6, "contact_plateau_force": 1e4, "contact_preload": 2e4},
        ["-contact_preload", "20000", "reaches", "[N]"],
    ),
    "preload_of_no_law": ({"contact_preload": 10}, ["-contact_preload", "-contact_law"]),
    "law_with_a_spring": (
        {"contact_law": "hertz", "contact_stiffness": 1e6, "support_stiffness": 1e6},
        ["-support_stiffness", "1e+06", "-contact_law hertz", "inf", "[N/m]"],
    ),
    "law_with_restitution": (
        {"contact_law": "hertz", "contact_stiffness": 1e6, "contact_restitution": 0.5},
        ["-contact_restitution", "0.5", "-contact_law"],
    ),
    "law_over_a_floor": (
        {"contact_law": "hertz", "contact_stiffness": 1e6, "floor": True, "support_side": "above", "support_height": 5},
        ["-support_position", "rigid support", "-contact_law"],
    ),
    "law_by_rk": (
        {"contact_law": "hertz", "contact_stiffness": 1e6, "ts_type": "rk"},
        ["-ts_type", "rk", "-contact_law", "expected impact"],
    ),
    "law_under_the_line": (
        {"contact_law": "hertz", "contact_stiffness": 1e6, "contact_surface": "line"},
        ["-contact_law", "-contact_surface line", "expected none"],
    ),
    "damper_without_spring": ({"support_damping": 10}, ["-support_damping", "10", "-support_stiffness", "[N s/m]"]),
    "wrong_weighting": ({"support_weighting": "equal"}, ["-support_weighting", "equal", "tributary"]),
    "three_heights_two_supports": ({"support_height": "0,0,0"}, ["-support_height", "3", "2"]),
    "three_widths_two_supports": ({"support_width": "1,1,1"}, ["-support_width", "3", "2"]),
    "three_sides_two_supports": ({"support_side": "below,below,below"}, ["-support_side", "3", "2"]),
    "three_restitutions_two_supports": ({"contact_restitution": "1,1,1"}, ["-contact_restitution", "3", "2"]),
    "two_tables_one_load": ({"load_position": 5, "load_table": "table.csv,table.csv"}, ["-load_table", "2", "1"]),
    "table_without_load": ({"load_table": "table.csv"}, ["-load_table", "nothing to apply to", "-load_position"]),
    "load_without_table": ({"load_position": 5}, ["-load_table"]),
    "width_without_load": ({"load_width": 1}, ["-load_width", "without -load_position"]),
    "width_off_the_beam": (
        {"load_position": 9, "load_table": "table.csv", "load_width": 3},
        ["-load_position", "-load_width", "10.5", "10", "[m]"],
    ),
    "negative_width_of_a_load": (
        {"load_position": 5, "load_table": "table.csv", "load_width": -1},
        ["-load_width", "-1", ">= 0", "[m]"],
    ),
    "breadth_without_load": ({"load_breadth": 1}, ["-load_breadth", "without -load_position"]),
    "breadth_without_width": (
        {"load_position": 5, "load_table": "table.csv", "load_breadth": 2},
        ["-load_breadth", "-load_width", "[m]"],
    ),
    "place_of_two_numbers": ({"load_place": "1,2", "load_table": "table.csv"}, ["-load_place", "2 values", "three"]),
    "load_at_a_junction_of_a_beam": (
        {"load_junction": "knee", "load_table": "table.csv"},
        ["-load_junction", "'knee'", "-structure_type network"],
    ),
    "load_across_a_beam": (
        {"load_position": 5, "load_table": "table.csv", "load_direction": "0,0,1"},
        ["-load_direction", "in space", "0,1,0"],
    ),
    "load_in_no_direction": (
        {"load_position": 5, "load_table": "table.csv", "load_direction": "0,0,0"},
        ["-load_direction", "0,0,0", "not 0"],
    ),
    "load_in_two_directions": (
        {"load_position": 5, "load_table": "table.csv", "load_direction": "0,1"},
        ["-load_direction", "2 values", "3"],
    ),
    "load_of_another_law": (
        {"load_position": 5, "load_law": "sawtooth"},
        ["-load_law", "sawtooth", "table, harmonic, random, friedlander"],
    ),
    "law_without_load": ({"load_law": "harmonic"}, ["-load_law", "-load_position"]),
    "amplitude_of_a_table": (
        {"load_position": 5, "load_table": "table.csv", "load_amplitude": 3},
        ["-load_amplitude", "-load_law harmonic or friedlander"],
    ),
    "table_of_a_law": (
        {"load_position": 5, "load_table": "table.csv", **HARMONIC},
        ["-load_table", "-load_law table"],
    ),
    "start_before_zero": ({"load_position": 5, **HARMONIC, "load_start": -1}, ["-load_start", "-1", ">= 0", "[s]"]),
    "end_before_the_start": (
        {"load_position": 5, **HARMONIC, "load_start": 2, "load_until": 1},
        ["-load_until", "1", "-load_start", "[s]"],
    ),
    "harmonic_without_amplitude": (
        {"load_position": 5, **HARMONIC, "load_amplitude": None},
        ["-load_amplitude", "needed", "harmonic"],
    ),
    "harmonic_without_frequency": (
        {"load_position": 5, **HARMONIC, "load_frequency": None},
        ["-load_frequency", "needed", "harmonic"],
    ),
    "negative_frequency": ({"load_position": 5, **HARMONIC, "load_frequency": -3}, ["-load_frequency", "-3", "[Hz]"]),
    "phase_that_is_none": ({"load_position": 5, **HARMONIC, "load_phase": "nan"}, ["-load_phase", "nan", "[rad]"]),
    "sweep_without_end": ({"load_position": 5, **HARMONIC, "load_last_frequency": 9}, ["-load_until", "inf", "[s]"]),
    "accuracy_of_nothing": ({"load_position": 5, **HARMONIC, "load_accuracy": 0}, ["-load_accuracy", "0", "1e-09"]),
    "rows_without_end": (
        {"load_position": 5, **HARMONIC, "load_frequency": 1e7, "load_accuracy": 1e-6},
        ["-load_law", "rows", "GB", "1e+07", "-load_until", "-load_accuracy"],
    ),
    "pulse_without_duration": (
        {"load_position": 5, "load_law": "friedlander", "load_amplitude": 1},
        ["-load_duration", "needed", "friedlander"],
    ),
    "pulse_that_grows": (
        {"load_position": 5, "load_law": "friedlander", "load_amplitude": 1, "load_duration": 1, "load_decay": -1},
        ["-load_decay", "-1", ">= 0"],
    ),
    "random_without_period": (
        {"load_position": 5, **RANDOM, "load_period": None},
        ["-load_period", "needed", "random"],
    ),
    "random_without_spectrum": (
        {"load_position": 5, **RANDOM, "load_density": None, "load_band": None},
        ["-load_density", "-load_spectrum", "[N^2/Hz]"],
    ),
    "band_of_one_number": ({"load_position": 5, **RANDOM, "load_band": 3}, ["-load_band", "two numbers", "[Hz]"]),
    "spectrum_that_goes_back": (
        {"load_position": 5, **RANDOM, "load_density": None, "load_band": None, "load_spectrum": "back.csv"},
        ["-load_spectrum", "back.csv", "ascending", "[Hz]"],
    ),
    "spectrum_below_zero": (
        {"load_position": 5, **RANDOM, "load_density": None, "load_band": None, "load_spectrum": "below.csv"},
        ["-load_spectrum", "[N^2/Hz]"],
    ),
    "band_between_lines": (
        {"load_position": 5, **RANDOM, "load_band": "0.1,0.2", "load_period": 1},
        ["-load_period", "1", "[s]"],
    ),
    "negative_seed": ({"load_position": 5, **RANDOM, "load_seed": -1}, ["-load_seed", "-1", ">= 0"]),
    "pivot_of_two_numbers": ({"initial_pivot": "1,2", "initial_angular_velocity": 1}, ["-initial_pivot", "2 values"]),
    "pivot_of_no_rotation": ({"initial_pivot": 1}, ["-initial_pivot", "without -initial_angular_velocity"]),
    "pivot_away_from_the_hinge": (
        {"initial_pivot": 5, "initial_angular_velocity": 1, "beam_left_end": "pinned"},
        ["-initial_pivot", "5 m/s", "held"],
    ),
    "pivot_in_a_clamp": (
        {"initial_pivot": 0, "initial_angular_velocity": 1, "beam_left_end": "clamped"},
        ["-initial_pivot", "held against that rotation"],
    ),
    "axles_without_speed": ({"load_axles": "table.csv"}, ["-load_axles_speed", "1", "-load_axles"]),
    "axles_that_stand": ({"load_axles": "table.csv", "load_axles_speed": 0}, ["-load_axles_speed", "0", "[m/s]"]),
    "axles_before_the_first": (
        {"load_axles": "ahead.csv", "load_axles_speed": 10},
        ["-load_axles", "ahead.csv", "-2", ">= 0", "[m]"],
    ),
    "axle_of_negative_mass": (
        {"load_axles": "light.csv", "load_axles_speed": 10},
        ["-load_axles", "light.csv", "mass of -3", ">= 0", "[kg]"],
    ),
    "axle_on_a_spring_that_pushes": (
        {"load_axles": "limp.csv", "load_axles_speed": 10},
        ["-load_axles", "limp.csv", "stiffness of -1", ">= 0", "[N/m]"],
    ),
    "axles_of_five_columns": (
        {"load_axles": "wide.csv", "load_axles_speed": 10},
        ["-load_axles", "wide.csv", "5 column", "stiffness [N/m]"],
    ),
    "masses_by_chebyshev": (
        {"load_axles": "heavy.csv", "load_axles_speed": 10, "ts_type": "chebyshev"},
        ["chebyshev", "masses that travel", "-load_axles", "rk"],
    ),
    "masses_without_filter": (
        {"load_axles": "heavy.csv", "load_axles_speed": 10, "filter_frequency": "none", "ts_type": "moreau",
         "ts_dt": 1e-3, "support_position": None},
        ["masses that travel", "-load_axles", "-filter_frequency"],
    ),
    "masses_and_damping": (
        {"load_axles": "heavy.csv", "load_axles_speed": 10, "damping_mass": 1},
        ["-load_axles", "masses are not allowed with damping", "-damping_mass"],
    ),
    "masses_on_a_held_line": (
        {"load_axles": "heavy.csv", "load_axles_speed": 10, "contact_surface": "line", "contact_restitution": 1},
        ["-load_axles", "masses are not allowed with contact on the line", "-contact_surface"],
    ),
    "masses_and_corrected_modes": (
        {"load_axles": "heavy.csv", "load_axles_speed": 10, "filter_correct_modes": 1},
        ["-load_axles", "masses are not allowed with corrected modes"],
    ),
    "masses_and_an_end_that_moves": (
        {"load_axles": "heavy.csv", "load_axles_speed": 10, "beam_left_end": "pinned", "base_motion": "table.csv",
         "base_motion_kind": "displacement", "base_motion_place": "left"},
        ["-load_axles", "masses are not allowed with a place that holds"],
    ),
    "speed_without_axles": ({"load_axles_start": 1}, ["-load_axles_start", "without -load_axles"]),
    "axles_over_a_gap": (
        {"load_axles": "table.csv", "load_axles_speed": 10, "beam_length": "5,5", "beam_gap": 0.1},
        ["-load_axles", "without gaps"],
    ),
    "too_many_axles": (
        {"load_axles": "table.csv", "load_axles_speed": 10, "beam_elements": 600000},
        ["-load_axles", "2 axles", "600001 nodes", "1e+06"],
    ),
    "base_motion_of_no_kind": (
        {"base_motion": "table.csv"},
        ["-base_motion_kind", "displacement, velocity or acceleration"],
    ),
    "base_motion_of_another_kind": (
        {"base_motion": "table.csv", "base_motion_kind": "jerk"},
        ["-base_motion_kind", "jerk", "velocity"],
    ),
    "kind_without_base_motion": ({"base_motion_kind": "velocity"}, ["-base_motion_kind", "without -base_motion"]),
    "two_kinds_one_base_motion": (
        {"base_motion": "table.csv", "base_motion_kind": "velocity,velocity"},
        ["-base_motion_kind", "2", "1", "-base_motion"],
    ),
    "base_motion_goes_back": (
        {"base_motion": "back.csv", "base_motion_kind": "acceleration"},
        ["-base_motion", "back.csv", "ascending", "[s]"],
    ),
    "base_motion_of_one_row": (
        {"base_motion": "still.csv", "base_motion_kind": "displacement"},
        ["-base_motion", "two rows", "[s]"],
    ),
    "base_motion_of_three_columns": (
        {"base_motion": "dead.csv", "base_motion_kind": "velocity"},
        ["-base_motion", "dead.csv", "3 column(s)", "expected 2", "velocity [m/s]"],
    ),
    "base_motion_that_jumps": (
        {"base_motion": "thrice.csv", "base_motion_kind": "velocity"},
        ["-base_motion", "thrice.csv", "strictly ascending", "[s]"],
    ),
    "base_motion_faster_than_light": (
        {"base_motion": "absurd.csv", "base_motion_kind": "velocity"},
        ["-base_motion", "1e+30 m/s", "speed of light"],
    ),
    "base_motion_without_size": (
        {"base_motion": "table.csv", "base_motion_kind": "velocity", "base_motion_scale": 0},
        ["-base_motion_scale", "0", "[-]"],
    ),
    "base_motion_across_a_beam": (
        {"base_motion": "table.csv", "base_motion_kind": "velocity", "base_motion_direction": "1,0,0"},
        ["-base_motion_direction", "beam", "along y"],
    ),
    "base_motion_in_the_plane": (
        {"base_motion": "table.csv", "base_motion_kind": "velocity", "base_motion_direction": "1,0"},
        ["-base_motion_direction", "2", "3", "x,y,z"],
    ),
    "base_motion_of_a_place_that_is_none": (
        {"base_motion": "table.csv", "base_motion_kind": "velocity", "base_motion_place": "middle"},
        ["-base_motion_place", "middle", "base, left, right or line_support_0"],
    ),
    "base_motion_of_a_free_end": (
        {"base_motion": "table.csv", "base_motion_kind": "velocity", "base_motion_place": "left"},
        ["-base_motion_place", "left", "nothing holds"],
    ),
    "base_motion_of_no_line_support": (
        {"base_motion": "table.csv", "base_motion_kind": "velocity", "base_motion_place": "line_support_1",
         "beam_line_support_position": 5},
        ["-base_motion_place", "line_support_1", "line supports given, 1"],
    ),
    "base_motion_of_a_node_held_twice": (
        {"base_motion": "table.csv", "base_motion_kind": "velocity", "base_motion_place": "left",
         "beam_line_support_position": 0, "beam_left_end": "pinned"},
        ["-base_motion_place", "left", "another support"],
    ),
    "two_base_motions_of_one_place": (
        {"base_motion": "table.csv,table.csv", "base_motion_kind": "velocity", "base_motion_place": "left",
         "beam_left_end": "pinned"},
        ["-base_motion_place", "two motions of one place"],
    ),
    "base_motion_of_two_places_one_record": (
        {"base_motion": "table.csv", "base_motion_kind": "velocity", "base_motion_place": "left,right"},
        ["-base_motion_place", "2", "1", "-base_motion"],
    ),
    "base_motion_of_a_place_by_modes": (
        {"base_motion": "table.csv", "base_motion_kind": "velocity", "base_motion_place": "left",
         "beam_left_end": "pinned", "ts_type": "modal", "filter_frequency": None},
        ["-base_motion_place", "-ts_type modal", "spring"],
    ),
    "base_motion_of_a_place_and_corrected_modes": (
        {"base_motion": "table.csv", "base_motion_kind": "velocity", "base_motion_place": "left",
         "beam_left_end": "pinned", "filter_correct_modes": 1},
        ["-base_motion_place", "-filter_correct_modes", "spring"],
    ),
    "base_motion_of_a_place_and_contact_on_the_line": (
        {"base_motion": "table.csv", "base_motion_kind": "velocity", "base_motion_place": "left",
         "beam_left_end": "pinned", "contact_surface": "line"},
        ["-base_motion_place", "-contact_surface", "spring"],
    ),
    "base_motion_without_accuracy": (
        {"base_motion": "table.csv", "base_motion_kind": "velocity", "base_motion_accuracy": 0},
        ["-base_motion_accuracy", "0", "> 0"],
    ),
    "base_motion_of_too_many_rows": (
        {"base_motion": "table.csv", "base_motion_kind": "velocity", "base_motion_place": "left",
         "beam_left_end": "pinned", "base_motion_accuracy": 1e-15},
        ["-base_motion_accuracy", "1e-15", "rows", "1e+06"],
    ),
    "base_motion_in_no_direction": (
        {"base_motion": "table.csv", "base_motion_kind": "velocity", "base_motion_direction": "0,0,0"},
        ["-base_motion_direction", "0", "three numbers"],
    ),
    "missing_load_table": ({"load_position": 5, "load_table": "absent.csv"}, ["-load_table", "absent.csv", "No such"]),
    "malformed_load_table": (
        {"load_position": 5, "load_table": "words.csv"},
        ["-load_table", "words.csv", "heavy", "line 3"],
    ),
    "ragged_load_table": ({"load_position": 5, "load_table": "ragged.csv"}, ["-load_table", "ragged.csv", "line 3"]),
    "load_table_goes_back": ({"load_position": 5, "load_table": "back.csv"}, ["-load_table", "back.csv", "ascending"]),
    "load_of_three_columns": (
        {"load_position": 5, "load_table": "swinging.csv"},
        ["-load_table", "swinging.csv", "line 1", "3 column(s)", "expected 2", "time [s]", "force [N]"],
    ),
    "load_with_three_rows_of_a_time": (
        {"load_position": 5, "load_table": "thrice.csv"},
        ["-load_table", "thrice.csv", "at most two", "[s]"],
    ),
    "motion_beyond_its_heights": (
        {"support_motion": "swinging.csv"},
        ["-support_motion", "-1e+15 m/s", "row 3", "0.005 m"],
    ),
    "motion_faster_than_light": (
        {"support_motion": "drop.csv"},
        ["-support_motion", "rows 4 and 5", "speed of light", "m/s"],
    ),
    "shape_of_another_planet": (
        {"initial_shape": "spike.csv", "initial_height": 0.05, "ts_type": "rk"},
        ["-initial_shape", "6.48868e+13", "at most 10000", "[m]"],
    ),
    "shape_faster_than_light": (
        {"initial_shape": "shot.csv", "initial_height": 0.05, "ts_type": "rk"},
        ["-initial_shape", "1.84461e+14", "speed of light", "m/s"],
    ),
    **{
        f"tao_type_{name}": (
            {"contact_surface": "line", "contact_line_dense_max": 0, "contact_tao_type": name},
            ["-contact_tao_type", f"'{name}'", "expected bqpip"],
        )
        for name in ("lmvm", "pdipm")
    },
    "empty_load_table": ({"load_position": 5, "load_table": "empty.csv"}, ["-load_table", "empty.csv"]),
    "missing_shape": ({"initial_shape": "absent.csv"}, ["-initial_shape", "absent.csv", "No such file"]),
    "malformed_shape": ({"initial_shape": "words.csv"}, ["-initial_shape", "words.csv", "heavy"]),
    "restart_wall_minutes": ({"restart_wall_minutes": -1}, ["-restart_wall_minutes", "-1", ">= 0", "[min]"]),
    "wall_limit": ({"wall_limit": "soon"}, ["-wall_limit", "soon", ">= 0", "[s]"]),
    "missing_restart_file": ({"restart_file": "absent.h5"}, ["-restart_file", "absent.h5"]),
    "restart_file_is_text": ({"restart_file": "table.csv"}, ["-restart_file", "table.csv"]),
    "restart_file_of_another_mesh": (
        {"restart_file": "done/restart.h5", "beam_elements": 24},
        ["-restart_file", "done/restart.h5", "beam elements: 20 there, 24 here"],
    ),
    "missing_yaml": ({"options_file": "absent.yaml"}, ["absent.yaml"]),
    "yaml_is_a_folder": ({"options_file": "folder.yaml"}, ["folder.yaml"]),
    "malformed_yaml": ({"options_file": "malformed.yaml"}, ["malformed.yaml", "line 2 column 13"]),
    "unknown_key_in_yaml": (
        {"options_file": "unknown.yaml"},
        ["-beam_lenght", "unknown.yaml line 2", "-beam_length"],
    ),
    "wrong_value_in_yaml": (
        {"options_file": "wrong.yaml", "beam_density": None},
        ["-beam_density", "-1", "[kg/m^3]", "wrong.yaml line 1"],
    ),
    "object_without_position": (
        {"options_file": "placeless.yaml", "support_position": None},
        ["-support_position", "every entry needs a value", "placeless.yaml line 1"],
    ),
    "force_window_below_half_a_filter_period": (
        {"output_force_window": 0.03},
        ["-output_force_window", "0.03", ">= pi / -filter_frequency = 0.0314159", "[s]"],
    ),
    "height_beyond_all_digits": (
        {"initial_height": 1e308, "contact_surface": "line"},
        ["-initial_height", "1e+308 m", "at most 4.5036e+10 [m]"],
    ),
    "load_beyond_all_digits": (
        {"load_position": 5, "load_table": "absurd.csv"},
        ["-load_table", "at most 4.5036e+10 [m]"],
    ),
    "load_whose_energy_overflows": (
        {"load_position": 5, "load_table": "overflow.csv", "ts_type": "rk"},
        ["-load_table", "at most 4.5036e+10 [m]"],
    ),
    "lengths_that_overflow": ({"beam_length": "1e308,1e308", "support_position": None}, ["-beam_length", "finite"]),
    "tolerance_below_rounding": ({"ts_rtol": 1e-300}, ["-ts_rtol", "1e-300", ">= 2.22"]),
    "hops_without_length": (
        {"contact_tolerance": 1e-300, "contact_restitution": 0.5},
        ["-contact_tolerance", "1e-300", ">= ", "[m]", "digits of the time"],
    ),
    "rows_without_number": ({"output_interval": 1e-300}, ["-output_interval", "1e-300", "[s]"]),
    "rows_beyond_belief": (
        {"output_interval": 1e-9},
        ["-output_interval", "1e-09", "2e+07 rows", "GB", "[s]", "-output_allow_large"],
    ),
    "fields_beyond_belief": (
        {"output_field_interval": 1e-6, "beam_elements": 20000},
        ["-output_field_interval", "1e-06", "GB", "-output_allow_large"],
    ),
    "elements_beyond_memory": (
        {"beam_elements": 1000000000},
        ["-beam_elements", "1000000000", "at least 460 GB of memory", "the machines have", "-structure_memory"],
    ),
    "elements_beyond_the_memory_allowed": (
        {"beam_elements": 3000000, "structure_memory": 1e9},
        ["-beam_elements", "3000000", "at least 1.38 GB", "-structure_memory allows 1 GB"],
    ),
    "window_beyond_the_memory_allowed": (
        {"output_force_window": 1, "output_interval": 1e-6, "structure_memory": 1e6},
        ["-output_force_window", "GB of memory", "-structure_memory allows 0.001 GB"],
    ),
    "case_file_without_end": ({"options_file": "/dev/zero"}, ["-options_file", "/dev/zero", "longer than 16 MiB"]),
    "negative_memory": ({"structure_memory": -1}, ["-structure_memory", "-1", ">= 0", "[B]"]),
    "negative_interval": ({"output_interval": -0.01}, ["-output_interval", "-0.01", "[s]"]),
    "text_for_time": ({"ts_max_time": "soon"}, ["-ts_max_time", "soon"]),
    "negative_time": ({"ts_max_time": -1}, ["-ts_max_time", "-1", "[s]"]),
    "krylov_method_without_prefix": ({"ksp_type": "gmres"}, ["-ksp_type", "did you mean -filter_ksp_type"]),
    "preconditioner_without_prefix": ({"pc_type": "lu"}, ["-pc_type", "did you mean -filter_pc_type"]),
    "matrix_without_prefix": ({"mat_type": "aij"}, ["-mat_type", "did you mean -filter_mat_type"]),
    "nonlinear_solver": ({"snes_type": "newtonls"}, ["-snes_type", "-filter_ksp_", "-contact_tao_"]),
    "implicit_theta": ({"ts_type": "theta"}, ["-ts_type", "theta", "explicit"]),
    "implicit_beuler": ({"ts_type": "beuler"}, ["-ts_type", "beuler", "explicit"]),
    "unknown_integrator": ({"ts_type": "chebishev"}, ["-ts_type", "chebishev", "nearest is chebyshev", "impact"]),
    "unknown_runge_kutta": ({"ts_rk_type": "5pd"}, ["-ts_rk_type", "5pd", "nearest is 5dp", "8vr"]),
    "unknown_step_control": ({"ts_adapt_type": "basik"}, ["-ts_adapt_type", "basik", "nearest is basic", "none"]),
    "unknown_preconditioner": ({"filter_pc_type": "chan"}, ["-filter_pc_type", "chan", "nearest is chain"]),
    "unknown_nested_preconditioner": (
        {"filter_pc_type": "asm", "filter_sub_pc_type": "luu"},
        ["-filter_sub_pc_type", "luu", "nearest is lu,"],
    ),
    "unknown_solver": ({"filter_ksp_type": "gmress"}, ["-filter_ksp_type", "gmress", "nearest is gmres,"]),
    "unknown_summary": ({"udar_summary": "yaml"}, ["-udar_summary", "yaml", "text", "json", "none"]),
    "negative_monitor": ({"output_monitor": -1}, ["-output_monitor", "-1", ">= 0", "[s]"]),
    "unknown_guard": ({"udar_guard": "halt"}, ["-udar_guard", "halt", "warn", "stop"]),
    "unknown_optimiser": ({"contact_tao_type": "blmvn"}, ["-contact_tao_type", "nearest is blmvm,"]),
    "unknown_matrix": ({"filter_mat_type": "aji"}, ["-filter_mat_type", "aji", "nearest is aij,"]),
    "unknown_package": (
        {"filter_pc_type": "lu", "filter_pc_factor_mat_solver_type": "mups"},
        ["-filter_pc_factor_mat_solver_type", "mups", "petsc"],
    ),
}

# Only the first line solve can find these out.
FAILING = {
    "steps_without_length": (
        {"ts_type": "rk", "ts_dt": 1e-300, "ts_adapt_type": "none"},
        ["the time stands still", "-ts_dt"],
    ),
    "falls_through": (
        {"initial_height": 0.05, "filter_frequency": "none", "ts_dt": 0.5, "ts_max_time": 0.5, "output_interval": 0.5},
        ["fallen through a rigid support", "by 1.17625 m at x = 2 m", "-ts_dt"],
    ),
    "not_converged": (
        {"filter_ksp_type": "gmres", "filter_pc_type": "jacobi", "filter_ksp_max_it": 3},
        ["line solve", "DIVERGED_ITS"],
    ),
    "useless_preconditioner": (
        {"filter_ksp_type": "preonly", "filter_pc_type": "jacobi"},
        ["line solve", "filter_residual_tolerance"],
    ),
}

# Words of a command line after those of the case: what the message must contain.
WORDS = {
    ("-support_position", "2,", "8"): ["'8'", "-support_position", "without blanks: -support_position 2,8"],
    ("-support_position", "2", "8", "9"): ["'8'", "without blanks: -support_position 2,8,9"],
    ("-gravity", "1", "other.yaml"): ["'other.yaml'", "the case file comes first", "-options_file"],
    ("-gravity", "1", "beam_length=10"): ["'beam_length=10'", "-key value"],
    ("-gravity", "1", "\N{EN DASH}beam_length", "10"): ["beam_length'", "dash"],
    ("--beam_length", "10"): ["'--beam_length'", "one dash: -beam_length"],
    ("-beam_length=10",): ["'-beam_length=10'", "with a blank: -beam_length 10"],
    ("-options_file",): ["-options_file", "name of a case file"],
    ("-study_jobs", "3"): ["-study_jobs", "udar-study"],
    ("-bench_kind", "batch"): ["-bench_kind", "udar-bench"],
}

# What a YAML file must not hold: what the message must contain besides the file's name.
YAML = {
    "beam_length: 10\nbeam:\n  length: 12\n": ["line 3 column 3", "beam_length", "again, after line 1"],
    "support_position: [[2, 8], 5]\n": ["line 1 column 20", "list within the list", "support_position: [2, 8]"],
    "support: [{position: 2}, 8]\n": ["line 1 column 26", "support: [{position: 2}, {position: 8}]"],
    "support_position: []\n": ["line 1", "empty list", "leave the key out"],
    "- beam_length: 10\n": ["line 1 column 1", "beam_length: 10"],
    "beam_length 10\n": ["line 1 column 1", "beam_length: 10"],
    "beam:\n\tlength: 10\n": ["line 2"],
    "-beam_length: 10\n": ["line 1 column 1", "-beam_length", "without dash"],
    "beam_length: 10\n---\nbeam_length: 12\n": ["several YAML documents"],
    "beam_length: 10\nbeam_left_end: fr\xe9e\n": ["line 2", "UTF-8"],
}

FILES = {
    "table.csv": "time,force\n0,0\n1,10\n",
    "below.csv": "1,10\n2,-10\n",
    "ahead.csv": "0,-1000\n-2,-1000\n",
    "light.csv": "0,-1000,-3\n",
    "limp.csv": "0,-1000,3,-1\n",
    "wide.csv": "0,-1000,3,1,5\n",
    "heavy.csv": "0,0,300\n",
    "absurd.csv": "0,0\n0.02,1e30\n0.1,0\n",
    "overflow.csv": "0,0\n0.02,1e160\n0.1,0\n",
    "hill.csv": "x,height\n0,0\n2,2\n4,1.5\n5,0\n",
    "motion.csv": "time,height\n0,0\n1,0.1\n2,0\n",
    "still.csv": "time,height\n0,0\n",
    "dead.csv": "time,height,velocity\n0,0,10\n0.01,0.1,10\n",
    "words.csv": "time,force\n0,0\n1,heavy\n",
    "ragged.csv": "time,force\n0,0\n1\n",
    "back.csv": "time,force\n0,0\n1,10\n0.5,20\n",
    "empty.csv": "",
    "thrice.csv": "0,0\n1,10\n1,20\n1,30\n",
    "swinging.csv": "0,0,0\n0.02,0.001,0.05\n0.05,-0.002,-1e15\n0.1,0.003,0\n0.2,0,0\n",
    "drop.csv": "0,0\n0.02,0.001\n0.05,-0.002\n0.1,0.003\n0.1000000000001,0\n0.14,0\n",
    "spike.csv": "0,0\n2.5,0.01\n5,-64886798321540.64\n7.5,0.01\n10,0\n",
    "shot.csv": "0,0,0.1\n2.5,0.01,-0.2\n7.5,0.02,-0.2\n10,0,184461147559898.47\n",
    "malformed.yaml": "beam_length: [10, 20\nbeam_density: }\n",
    "unknown.yaml": "gravity: 9.81\nbeam_lenght: 10\n",
    "placeless.yaml": "support: [{position: 2, width: 1}, {width: 1}]\n",
    "wrong.yaml": "beam_density: -1\n",
}


def launches(name):
    """What fails later always runs on two ranks, too, of what is refused every third: they take the same way out."""
    return LAUNCHES if name in FAILING or list(REFUSED).index(name) % 3 == 0 else (0,)


class BadInput(UdarTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="udar-test-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        for name, text in FILES.items():
            (cls.folder / name).write_text(text)
        (cls.folder / "folder.yaml").mkdir()
        cls.done = cls.folder / "done"
        finished = run(case(ts_max_time=0.02, output_directory=cls.done), cwd=cls.folder)
        if finished.code != 0:
            raise RuntimeError(str(finished))
        cls.before = digest(cls.done)
        # All tables at once: a failing run under mpiexec spends most of its time waiting for mpiexec to end it.
        workers = concurrent.futures.ThreadPoolExecutor(WORKERS)
        cls.addClassCleanup(workers.shutdown, cancel_futures=True)
        cls.runs = {
            (name, ranks): workers.submit(cls.launch, name, changes, ranks)
            for name, (changes, _) in {**REFUSED, **FAILING}.items()
            for ranks in launches(name)
        }

    @classmethod
    def launch(cls, name, changes, ranks):
        """Runs one case in a folder of its own, which already holds a finished run that may be overwritten."""
        place = cls.folder / f"{name}-{ranks}"
        shutil.copytree(cls.done, place)
        return run(
            case(**{"ts_max_time": 0.02, "output_directory": place, "output_overwrite": True, **changes}),
            ranks,
            cwd=cls.folder,
            timeout=120,
        )

    def refuse(self, options, wanted, ranks):
        """Runs a case that must fail, and checks how it fails."""
        self.check(run(options, ranks, cwd=self.folder, timeout=120), wanted, ranks)

    def check(self, result, wanted, ranks):
        """How a run must fail."""
        self.assertNotEqual(result.code, 0, f"accepted{result}")
        self.assertLess(result.code, 128, f"killed by a signal{result}")
        self.assertGreater(result.code, 0, f"killed by a signal{result}")
        self.assertEqual(len(result.errors), 1, f"exactly one line starts with 'udar: error:'{result}")
        for text in wanted:
            self.assertIn(text, result.errors[0], result)
        self.assertLess(len(result.errors[0]), LONGEST_LINE, result)
        self.assertNotIn("PETSC ERROR", result.err + result.out, result)
        self.assertNotIn("HDF5-DIAG", result.err + result.out, result)
        if not ranks:
            others = [line for line in result.err.splitlines() if line and not line.startswith("udar: ")]
            self.assertEqual(others, [], f"lines beside the message{result}")

    def check_table(self, name, wanted, keeps_old_run):
        for ranks in launches(name):
            with self.subTest(ranks=ranks):
                self.check(self.runs[name, ranks].result(), wanted, ranks)
                if keeps_old_run:
                    place = self.folder / f"{name}-{ranks}"
                    self.assertEqual(digest(place), self.before, "the finished run was touched")

    def test_the_unchanged_case_is_accepted(self):
        for ranks in LAUNCHES:
            self.run_case(case(ts_max_time=0.02), ranks, name=f"good{ranks}")

    def test_words_that_belong_to_no_option(self):
        for words, wanted in WORDS.items():
            with self.subTest(words=words):
                self.check(run(case(), 0, words, cwd=self.folder), wanted, 0)
        for name, text, wanted in (
            ("PETSC_OPTIONS", "-support_position 2, 8", ["'8'", "in PETSC_OPTIONS", "-support_position 2,8"]),
            ("PETSC_OPTIONS", "-options_file unknown.yaml", ["-beam_lenght", "unknown.yaml line 2"]),
            ("PETSC_OPTIONS_YAML", "beam_lenght: 10", ["-beam_lenght", "-beam_length"]),
        ):
            with self.subTest(variable=name, text=text):
                self.check(run(case(), 0, cwd=self.folder, environment={name: text}), wanted, 0)

    def test_what_yaml_must_not_hold(self):
        path = self.scratch / "case.yaml"
        for text, wanted in YAML.items():
            with self.subTest(text=text):
                path.write_bytes(text.encode("latin-1"))
                self.check(run({"options_file": path}), [str(path), *wanted], 0)

    def test_existing_run_is_refused_unless_told(self):
        options = case(ts_max_time=0.02, output_directory="done")
        for ranks in LAUNCHES:
            self.refuse(options, ["-output_overwrite", "done"], ranks)
            self.assertEqual(digest(self.done), self.before, "the finished run was touched")
        again = self.scratch / "again"
        shutil.copytree(self.done, again)
        (again / "notes.txt").write_text("mine")
        self.run_case(case(ts_max_time=0.01, output_overwrite=True), name="again")
        self.assertEqual((again / "notes.txt").read_text(), "mine", "a file that is not the program's own")
        self.assertEqual(len((again / "gauges.csv").read_text().splitlines()), 3, "the new run replaced the old one")

    def test_output_directory_below_a_file(self):
        for path in ("/dev/null/x", "table.csv/x", "table.csv"):
            for ranks in LAUNCHES:
                self.refuse(case(output_directory=path), ["-output_directory", path], ranks)
        self.assertEqual((self.folder / "table.csv").read_text(), FILES["table.csv"])

    def test_every_rank_needs_two_nodes(self):
        changes = {"support_position": "0", "gauge_position": "0,10", "output_directory": "ranks"}
        for elements, ranks in ((1, 4), (2, 4), (4, 3)):
            wanted = ["-beam_elements", f"{elements} elements", f"{ranks} ranks", "two nodes"]
            self.refuse(case(beam_elements=elements, **changes), wanted, ranks)
        wanted = ["-beam_elements", "3 elements", "3 ranks", "two nodes"]
        self.refuse(case(beam_elements=1, beam_length="5,5", beam_gap=1, **changes), wanted, 3)
        self.assertFalse((self.folder / "ranks" / "gauges.csv").exists())
        self.run_case(case(beam_elements=4, ts_max_time=0.02), 2, name="enough")

    def mount(self, options):
        """A tmpfs of its own for one test; skips the test where this is not permitted."""
        place = self.scratch / "disk"
        place.mkdir()
        if shutil.which("mount") is None or os.geteuid() != 0:
            self.skipTest("only root can mount a small disk")
        line = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(place)]
        done = subprocess.run(line, capture_output=True, text=True)
        if done.returncode != 0:
            self.skipTest(f"mounting is not permitted: {done.stderr.strip()}")
        self.addCleanup(subprocess.run, ["umount", "-l", str(place)], check=True)
        return place

    def test_read_only_disk(self):
        place = self.mount("ro,size=1m")
        for ranks in LAUNCHES:
            for path in (place, place / "run"):
                self.refuse(case(output_directory=path), ["-output_directory", "Read-only"], ranks)

    def test_disk_full(self):
        # Room for nothing, for the text files but not for the fields, and for the first part of the fields.
        changes = {"output_interval": 1e-3, "output_field_interval": 1e-3, "beam_elements": 100, "ts_max_time": 0.4}
        place = self.mount("size=64k")
        for ranks in LAUNCHES:
            for size in ("4k", "64k", "512k"):
                with self.subTest(ranks=ranks, size=size):
                    subprocess.run(["mount", "-o", f"remount,size={size}", str(place)], check=True)
                    options = case(output_directory=place / "run", **changes)
                    self.refuse(options, ["-output_directory", "No space left"], ranks)
                    shutil.rmtree(place / "run", ignore_errors=True)

    def test_disk_full_at_restart_file(self):
        place = self.mount("size=200k")
        changes = {"output_interval": 0.1, "beam_elements": 4000, "ts_max_time": 0.02, "restart_interval": 0.005}
        for ranks in LAUNCHES:
            with self.subTest(ranks=ranks):
                self.refuse(case(output_directory=place / "run", **changes), ["No space left"], ranks)
                shutil.rmtree(place / "run", ignore_errors=True)


def add(name, wanted, keeps_old_run):
    setattr(BadInput, f"test_{name}", lambda self: self.check_table(name, wanted, keeps_old_run))


for entry, (_, message) in REFUSED.items():
    add(entry, message, True)
for entry, (_, message) in FAILING.items():
    add(entry, message, False)

if __name__ == "__main__":
    unittest.main()
