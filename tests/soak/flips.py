#!/usr/bin/python3
"""Damages the files of killed runs, a bit or a cut at a time, and has each go on in place: is another motion ever
accepted, or does a program ever end otherwise than by 0 or by one error?

usage: flips.py [--flips 1000] [--cuts 300] [--seed 1]

A flip changes one bit of restart.h5, results.h5, gauges.csv or energy.csv; a cut ends one of them at a random byte.
Good ends are: refused with a message, exit code 1; or the run ends, and the state in its restart.h5 is that of the
straight run to the bit. What is printed: how many of each file were refused, went on from the restart file before,
ended right, or ended right with rows and fields in which the damage is still seen; the exit code is 1 if any ended
otherwise.
UDAR names the program, UDAR_KILL_AT_RESIZE the library that kills it, as for the tests.
"""

import argparse
import collections
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
import common  # noqa: E402
import same_run  # noqa: E402

OPTIONS = common.case(initial_height=0.05, gauge_position="0,5,10", ts_max_time=0.15, output_interval=1e-3,
                      output_field_interval=5e-3, restart_interval=0.01, ts_type="impact", support_width=0.9,
                      contact_restitution=0.7)
FILES = ("restart.h5", "results.h5", "gauges.csv", "energy.csv")


def udar(folder, options, **environment):
    line = common.command(options)
    return subprocess.run(line, cwd=folder, env={**common.environment_of(line), **environment}, check=False,
                          capture_output=True, text=True, timeout=60)


def damage(path, chance, cut):
    data = bytearray(path.read_bytes())
    if cut:
        path.write_bytes(data[:chance.randrange(len(data))])
    else:
        data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
        path.write_bytes(data)


def verdict(done, folder, straight):
    if done.returncode == 1 and len([line for line in done.stderr.splitlines() if "udar: error:" in line]) == 1:
        return "refused"
    if done.returncode != 0:
        return f"ended with {done.returncode}"
    results = ("results.h5", "gauges.csv", "energy.csv", "results.vtkhdf", "results.xdmf")
    if same_run.differences(straight, folder, but=results):
        return "another motion"
    try:
        whole = not same_run.differences(straight, folder)
    except (OSError, RuntimeError):  # of h5py
        whole = False
    return ("ended right" + (", from the file before" if "from the restart file before" in done.stdout else "") +
            ("" if whole else ", with the damage in the rows before"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--flips", type=int, default=1000)
    parser.add_argument("--cuts", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    chance = random.Random(asked.seed)
    counts = collections.Counter()
    with tempfile.TemporaryDirectory() as name:
        base = pathlib.Path(name)
        options = OPTIONS | {"output_directory": "run"}
        for folder, environment in (("straight", {}),
                                    ("work", {"LD_PRELOAD": os.environ["UDAR_KILL_AT_RESIZE"],
                                                "KILL_AT_RESIZE": "7"})):
            (base / folder).mkdir()
            udar(base / folder, options, **environment)
        (base / "work").rename(base / "killed")  # and goes on where it began
        left = {path.name for path in (base / "killed" / "run").iterdir()}
        if "restart.previous.h5" not in left or "summary.json" in left:
            sys.exit("the run was to be killed after its second restart file and before its end")
        for number in range(asked.flips + asked.cuts):
            cut = number >= asked.flips
            file = chance.choice(FILES)
            folder = base / "work"
            shutil.copytree(base / "killed", folder)
            damage(folder / "run" / file, chance, cut)
            try:
                found = verdict(udar(folder, {"continue": "run"}), folder / "run", base / "straight" / "run")
            except subprocess.TimeoutExpired:
                found = "hangs"
            counts[f"{'cut' if cut else 'flip'} of {file}: {found}"] += 1
            shutil.rmtree(folder)
    print("\n".join(f"{count:5d}  {what}" for what, count in sorted(counts.items())))
    good = ("refused", "right", "before")
    sys.exit(0 if all(what.endswith(good) for what in counts) else 1)


if __name__ == "__main__":
    main()
