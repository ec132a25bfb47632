# Source this before mpirun: any number of ranks on any machine, also as root in a container, with one thread each.
# The tests take their environment from here: one `export NAME=VALUE` a line.
export OMPI_ALLOW_RUN_AS_ROOT=1
export OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
# More ranks than cores: Open MPI 4, and 5 whose launcher is PRRTE.
export OMPI_MCA_rmaps_base_oversubscribe=1
export PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe
export OMPI_MCA_hwloc_base_binding_policy=none
export PRTE_MCA_hwloc_default_binding_policy=none
# A rank that waits gives its core away. Without this a busy machine runs 20 times slower with Open MPI 4; of 5 the
# programs choose the way by the number of ranks and cores.
export OMPI_MCA_mpi_yield_when_idle=1
# A program that is started without mpirun needs no daemon of Open MPI 4 beside it: it starts in half the time.
export OMPI_MCA_ess_singleton_isolated=1
export OMP_NUM_THREADS=1
export OPENBLAS_NUM_THREADS=1
# In a container without /sys every program would say so before anything else.
export HWLOC_HIDE_ERRORS=2
