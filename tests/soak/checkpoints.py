#!/usr/bin/python3
"""What restart files cost: wall time of runs with some ten of them beside that of the same with the last alone.

usage: checkpoints.py [--repeats 5]

Examples 01 and 04, and a beam of a million elements that falls for a few steps, with and without in turn.
Prints least and median of both, seconds and bytes of one restart file. UDAR names the program, as for the tests.
"""

import argparse
import pathlib
import statistics
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
import common  # noqa: E402

EXAMPLES = common.ROOT / "examples"
CASES = {
    "example 01": {"options_file": EXAMPLES / "01-falling-beam/case.yaml", "filter_frequency": 100},
    "example 04": {"options_file": EXAMPLES / "04-pipeline/case.yaml"},
    "1e6 elements": common.case(beam_elements=1000000, ts_type="impact", support_width=1, ts_max_time=0.5,
                                ts_adapt_dt_max=0.02, output_interval=0.05, output_field_interval=0),
}


def seconds(options, folder):
    done = common.run(options | {"output_directory": folder, "output_overwrite": True}, timeout=600)
    if done.code != 0:
        sys.exit(f"{done}")
    return done.summary()["wall_seconds"]["total"], done.summary()["end_time"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=5)
    repeats = parser.parse_args().repeats
    print("case            without [s]: least median   with ten: least median   one file [s]   [MB]")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name) / "run"
        for case, options in CASES.items():
            options = options | {"restart_wall_minutes": 0}
            _, end = seconds(options, folder)
            without, with_ten = [], []
            for _ in range(repeats):
                without.append(seconds(options, folder)[0])
                with_ten.append(seconds(options | {"restart_interval": end / 10.5}, folder)[0])
            each = (statistics.median(with_ten) - statistics.median(without)) / 10
            size = (folder / "restart.h5").stat().st_size / 1e6
            print(f"{case:14s}  {min(without):18.3f} {statistics.median(without):7.3f}  {min(with_ten):15.3f} "
                  f"{statistics.median(with_ten):8.3f} {each:14.4f} {size:6.1f}",
                  flush=True)


if __name__ == "__main__":
    main()
