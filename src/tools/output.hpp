#pragma once
/// @file
/// Rows of fields into results.h5 against plain writes of as many bytes.

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <string>
#include <system_error>
#include <vector>

#include "udar/structure/beam_chain.hpp"

namespace udar::bench {

/// What `dd bs=8M` does: one process writes the same block again and again.
class PlainFile {
 public:
  explicit PlainFile(std::string path)
      : path_{std::move(path)}, descriptor_{open(path_.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0644)} {}
  PlainFile(const PlainFile&) = delete;
  PlainFile& operator=(const PlainFile&) = delete;
  ~PlainFile();

  void write_bytes(std::size_t bytes);
  void sync() const { fsync(descriptor_); }

 private:
  std::string path_;
  int descriptor_;
  std::vector<char> block_ = std::vector<char>(std::size_t{8} << 20, 'u');
};

/// Writes rows of all fields of the beam's nodes into a results.h5 in `directory`, in turn with the same bytes by rank
/// 0 alone into a plain file; prints JSON. Both files are removed.
void output(const BeamChain& beam, const std::string& directory, long repeats);

}  // namespace udar::bench
