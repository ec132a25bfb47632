"""Whether two folders hold the same run: every file of udar to the bit, but for what only costs tell.

HDF5 files are compared by content, every dataset and attribute: where in the file they stand is HDF5's business.
"""

import json

import h5py
import numpy as np

TEXT = ("gauges.csv", "strikers.csv", "places.csv", "axles.csv", "energy.csv", "contact.csv", "impacts.csv",
        "impacts_merged.csv", "rests.csv", "envelope.csv", "results.xdmf", "paraview-state.py", "supports.vtp")
CONTENT = ("results.h5", "results.vtkhdf", "restart.h5")
# What a run costs is another in each: one that goes on solves once more for what the one before still had. A restart
# file says where the files stand, and where the run began.
COSTS = {"wall_seconds", "wall_seconds_mean", "own_seconds", "communication", "peak_memory_bytes", "memory_per_rank",
         "streamed_bytes", "line_solves", "stepping_line_solves"}
# Records that wait have bytes between their columns, too; they are in results.h5 when the run has ended.
PLACES = {"texts/results.h5", "tables/results.h5 extents", "texts/working directory", "scalars@counted line_solves",
          *(f"texts/results.h5 waiting rows of {table}" for table in ("impacts", "impacts_merged", "rests"))}


def content(path):
    """Bytes, kind and shape of all datasets and attributes of an HDF5 file by name."""
    found = {}

    def add(name, item):
        for key, value in item.attrs.items():
            found[f"{name}@{key}"] = np.asarray(value).tobytes()
        if isinstance(item, h5py.Dataset):
            values = np.asarray(item[()])
            # Between the columns of a record there may be bytes that mean nothing.
            columns = [values[column].tobytes() for column in values.dtype.names or ()] or [values.tobytes()]
            found[name] = (b"".join(columns), str(item.dtype), item.shape)

    with h5py.File(path, "r") as file:
        add("/", file)
        file.visititems(add)
    return {name: value for name, value in found.items() if name not in PLACES}


def differences(one, other, folders=True, but=()):
    """What tells the two runs apart, by file; empty: nothing. Options may name the folders."""
    found = []
    for name in (*TEXT, *CONTENT, "summary.json"):
        first, second = one / name, other / name
        if name in but:
            continue
        if first.exists() != second.exists():
            found.append(f"{name} is in one alone")
        elif not first.exists():
            continue
        elif name in TEXT:
            if first.read_bytes() != second.read_bytes():
                found.append(name)
        elif name in CONTENT:
            parts = [content(path) for path in (first, second)]
            if folders:  # the options name the folder
                for part, folder in zip(parts, (one, other)):
                    for key, value in part.items():
                        if key in ("/@options", "texts/options"):
                            text = value[0] if isinstance(value, tuple) else value
                            part[key] = text.replace(str(folder).encode(), b"RUN").rstrip(b"\0")
            keys = sorted(set(parts[0]) ^ set(parts[1]))
            found += [f"{name}: {key} is in one alone" for key in keys]
            found += [f"{name}: {key}" for key in parts[0] if key in parts[1] and parts[0][key] != parts[1][key]]
        else:
            summaries = [json.loads(path.read_text()) for path in (first, second)]
            found += [
                f"{name}: {key}: {summaries[0].get(key)} and {summaries[1].get(key)}"
                for key in summaries[0] | summaries[1]
                if key not in COSTS and summaries[0].get(key) != summaries[1].get(key)
            ]
    return found
