#!/usr/bin/python3
"""A run of very many steps with rows and restart files all the while: does its memory stay flat, does its energy?

usage: steps.py [--steps 1000000] [--type impact]

The paper's beam bounces on pads, in steps of at most 1e-5 s; every 20th of the steps shows memory and energy drift.
UDAR names the program, as for the tests.
"""

import argparse
import pathlib
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
import common  # noqa: E402

STEP = 1e-5  # [s]


def resident(pid):
    """[MB]"""
    for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return float(line.split()[1]) / 1024
    return float("nan")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=1000000)
    parser.add_argument("--type", default="impact")
    asked = parser.parse_args()
    end = asked.steps * STEP
    options = common.case(
        ts_type=asked.type, ts_max_time=end, ts_adapt_dt_max=STEP, ts_dt=STEP, ts_max_steps=2 * asked.steps,
        support_width=0.9, filter_frequency=100, output_interval=end / 2000, output_field_interval=end / 200,
        restart_interval=end / 40, restart_wall_minutes=0.05, output_directory="run")
    with tempfile.TemporaryDirectory() as folder:
        begin = time.monotonic()
        process = common.start(common.command(options), cwd=folder)
        energy = pathlib.Path(folder) / "run" / "energy.csv"
        shown = 0
        seen = []
        while process.poll() is None:
            time.sleep(0.2)
            try:
                rows = energy.read_text().splitlines()[1:]
                last = [float(word) for word in rows[-1].split(",")]
                memory = resident(process.pid)
            except (OSError, IndexError, ValueError):
                continue
            if last[0] >= shown * end / 20:
                print(f"t = {last[0]:8.3f} s  {memory:7.1f} MB  drift {last[-1]:9.1e}", flush=True)
                seen.append(memory)
                shown = int(20 * last[0] / end) + 1
        out, err = process.communicate()
        print(out.splitlines()[-1] if out else err)
        print(f"{time.monotonic() - begin:.1f} s, memory between a tenth of the run and its end: "
              f"{min(seen[2:]):.1f} to {max(seen[2:]):.1f} MB")
        sys.exit(process.returncode)


if __name__ == "__main__":
    main()
