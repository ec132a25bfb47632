"""What udar's scripts share: reading of result files, and their pictures.

tools     errors of one line, the command line's parser, tables
files     the files of a run: tables, summary, options, units; nothing else opens them
results   a run as its pictures need it: `Run`
curves    thinning, units that suit what is shown
palette   colours, parts of the energy
shapes    what of a displacement is deformation
style     units of axes, labels: what all pictures have in common
figures   the pictures of one run, or of several laid over each other
networks  structure and deformation of a network in space
studies   the pictures of a study
cli       udar-plot
report    udar-report
"""
import os

os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")  # a run that is still writing may be looked at
