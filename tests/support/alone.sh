# Read by the tests: one `export NAME=VALUE` a line, for programs that are started without mpiexec.
# Those need no daemon of Open MPI 4's, which serves programs that start others, and none of its folders, which would
# have one name for all of them: 0.13 s from start to end instead of 0.31.
export OMPI_MCA_ess_singleton_isolated=1
export OMPI_MCA_orte_create_session_dirs=0
export OMPI_MCA_sharedfp=individual
