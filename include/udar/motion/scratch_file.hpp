#pragma once
/// @file
/// Where what does not stay in memory waits.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>

namespace udar {

/// @brief A file of this process alone, without a name: it is gone when the program ends, however it ends. Not
/// collective.
class ScratchFile {
 public:
  /// @param folder where it stands once something is appended; empty: where the system keeps such files
  void set_folder(std::string folder) { folder_ = std::move(folder); }
  /// @return false if the disk takes it not; the file then has what it had
  [[nodiscard]] bool append(std::span<const std::byte> bytes);
  /// @brief Reads what was appended. @param offset [bytes] @throws FileError on this rank
  void read(std::uint64_t offset, std::span<std::byte> to) const;
  /// Gives its space back.
  void clear();

 private:
  struct Close {
    void operator()(std::FILE* file) const noexcept { std::fclose(file); }
  };

  bool open();

  std::string folder_;
  std::unique_ptr<std::FILE, Close> file_;
  std::uint64_t size_ = 0;
};

}  // namespace udar
