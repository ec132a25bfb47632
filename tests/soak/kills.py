#!/usr/bin/python3
"""Kills runs on two ranks at random times and has each go on in place until it ends: are its files those of a straight
run, to the bit?

usage: kills.py [--runs 200] [--first 0] [--seed 1] [--kinds chebyshev,impact,modal,network] [--signal KILL]

Of each run a rank, mpiexec or all of them are killed, at a time that is uniform over a straight run's and a tenth more;
what goes on may be killed again, up to four times. A run that was killed before it had a restart file is begun again.
With --signal INT, TERM, HUP or USR1 mpiexec gets that signal instead, as from a terminal or a batch system.
Each run has chances of its own: --first 100 --runs 100 makes the second half of --runs 200.
Prints a line for each run that differs, and counts at the end; the exit code is 1 if any differs.
UDAR names the program, as for the tests.
"""

import argparse
import collections
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
import common  # noqa: E402
import same_run  # noqa: E402

BEAM = {"filter_frequency": 400, "beam_elements": 200, "ts_max_time": 1.5, "output_interval": 5e-4,
        "output_field_interval": 5e-3, "restart_interval": 0.02}
KINDS = {
    "chebyshev": common.case(**BEAM, ts_type="chebyshev"),
    "impact": common.case(**BEAM, ts_type="impact", support_width=0.5),
    "modal": common.case(**(BEAM | {"output_interval": 2e-4}), ts_type="modal", contact_restitution=1,
                         contact_surface="line"),
    "network": {"structure_type": "network", "network_lattice": "3,3,3", "network_spacing": 0.5,
                "network_elements": 8, "network_section": "tube", "network_section_radius": 0.02,
                "network_section_inner_radius": 0.017, "network_rotation": "0,0,0.02", "initial_height": 0.3,
                "floor": "true", "contact_restitution": 0.5, "filter_frequency": 300, "ts_type": "impact",
                "ts_max_time": 0.6, "output_interval": 5e-4, "output_field_interval": 5e-3, "restart_interval": 0.01},
}
PATIENCE = 600  # [s] for one run, which takes seconds where it has the machine for itself


def ranks_of(pid):
    return [int(child) for child in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def living(pids):
    def lives(pid):
        try:
            return "Z" not in pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1][:3]
        except OSError:
            return False

    return [pid for pid in pids if lives(pid)]


def strike(process, chance, number):
    """Ends the run as the chance has it; returns when none of its processes lives."""
    ranks = ranks_of(process.pid)
    whom = chance.choice(["rank", "mpiexec", "all"]) if number == signal.SIGKILL else "mpiexec"
    targets = {"rank": [chance.choice(ranks)] if ranks else [process.pid], "mpiexec": [process.pid],
               "all": [process.pid, *ranks]}[whom]
    for pid in targets:
        try:
            os.kill(pid, number)
        except ProcessLookupError:
            pass
    process.communicate()
    begin = time.monotonic()
    while left := living(ranks):
        if time.monotonic() - begin > 10:  # orphans that nobody told
            for pid in left:
                os.kill(pid, signal.SIGKILL)
        time.sleep(0.01)
    return whom


def play(options, folder, span, chance, number):
    """A run with up to four ends before its own; returns what happened."""
    story = []
    line = common.command(options, 2)
    for go in range(40):
        process = common.start(line, cwd=folder)
        until = time.monotonic() + chance.uniform(0.0, 1.1 * span) if go < chance.randint(1, 4) else float("inf")
        begin = time.monotonic()
        while process.poll() is None and time.monotonic() < until:
            if time.monotonic() - begin > PATIENCE:
                process.kill()
                return [*story, "hangs"]
            time.sleep(0.002)
        if process.poll() is not None:
            _, err = process.communicate()
            if process.returncode == 0:
                return [*story, "ends"]
            if "expected the folder of a run" in err:  # nothing was written yet
                story.append("anew")
                line = common.command(options, 2)
                continue
            why = [line for line in err.splitlines() if "error" in line.lower()][:3]
            return [*story, f"fails with {process.returncode}: {'; '.join(why)}"]
        story.append(strike(process, chance, number))
        line = common.command({"continue": options["output_directory"]}, 2)
    return [*story, "never ends"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--signal", default="KILL")
    asked = parser.parse_args()
    kinds = asked.kinds.split(",")
    number = getattr(signal, "SIG" + asked.signal)
    counts = collections.Counter()
    with tempfile.TemporaryDirectory() as name:
        base = pathlib.Path(name)
        spans = {}
        for kind in kinds:
            (base / kind).mkdir()
            begin = time.monotonic()
            done = subprocess.run(common.command(KINDS[kind] | {"output_directory": "run"}, 2), cwd=base / kind,
                                  env=common.ENVIRONMENT, capture_output=True, text=True, check=False)
            if done.returncode != 0:
                sys.exit(done.stderr)
            spans[kind] = time.monotonic() - begin
        for run in range(asked.first, asked.first + asked.runs):
            chance = random.Random(f"{asked.seed}-{run}")
            kind = kinds[run % len(kinds)]
            folder = base / f"{kind}-{run}"
            folder.mkdir()
            story = play(KINDS[kind] | {"output_directory": "run"}, folder, spans[kind], chance, number)
            counts.update(f"{kind}: {what}" for what in story[:-1])
            found = ["no end"] if story[-1] != "ends" else same_run.differences(base / kind / "run", folder / "run")
            if number != signal.SIGKILL:  # a stop ends a step: by modes there is one more
                found = [what for what in found if "modal_steps" not in what]
            counts["equal" if not found else "different"] += 1
            if found:
                print(f"run {run}, {kind}, {' '.join(story)}: {'; '.join(found[:6])}", flush=True)
            shutil.rmtree(folder)
    print("straight runs take", ", ".join(f"{span:.2f} s ({kind})" for kind, span in spans.items()))
    print("\n".join(f"{count:5d}  {what}" for what, count in sorted(counts.items())))
    sys.exit(1 if counts["different"] else 0)


if __name__ == "__main__":
    main()
