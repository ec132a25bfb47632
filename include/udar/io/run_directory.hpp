#pragma once
/// @file
/// The folder a run writes into.

#include <mpi.h>

#include <string>

namespace udar::io {

/// @brief Makes `path` ready for the files of one run: creates it, with its parents, and checks that it takes files.
/// @param[in] path      option `-output_directory`
/// @param[in] overwrite option `-output_overwrite`: a run already in the folder is removed, our own files only
/// @param[in] keep      a file that stays even then: the `-restart_file` this run starts from; empty for none
/// @note Collective; only rank 0 touches the disk. A refusal changes nothing.
/// @throws FileError on all ranks if the folder cannot be made or written, or holds a run and `overwrite` is false
/// @see docs/output.md
void prepare_run_directory(MPI_Comm comm, const std::string& path, bool overwrite, const std::string& keep = {});

}  // namespace udar::io
