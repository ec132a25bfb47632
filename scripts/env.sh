# Source this before mpirun: any number of ranks on any machine, also as root in a container, with one thread each.
export OMPI_ALLOW_RUN_AS_ROOT=1
export OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_rmaps_base_oversubscribe=1
export OMPI_MCA_hwloc_base_binding_policy=none
# A rank that waits gives its core away. Without this a busy machine runs 20 times slower.
export OMPI_MCA_mpi_yield_when_idle=1
export OMP_NUM_THREADS=1
export OPENBLAS_NUM_THREADS=1
