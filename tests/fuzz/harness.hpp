#pragma once
/// @file
/// What all fuzz targets share: a process of one rank, a folder of its own, bytes to decide by.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "udar/petsc/error.hpp"

namespace udar::fuzz {

/// What models may take by estimate [bytes].
inline constexpr double kMemory = 1e8;

/// @brief Starts MPI, PETSc and HDF5 once, and changes into a new folder, which the end of the process removes.
void start();

/// @brief Writes a file in that folder.
void write_file(const std::string& name, std::string_view content);

/// @brief Reads keys in YAML as a case file's, in the place of all that were read before.
void insert_case(const std::string& yaml);

/// @brief What a program does with a user's input: it may refuse it with a message, and nothing else.
template <class Program>
void allow_refusal(const Program& program) {
  try {
    program();
  } catch (const InputError&) {    // NOLINT(bugprone-empty-catch): what it should do
  } catch (const FileError&) {     // NOLINT(bugprone-empty-catch)
  } catch (const SolveError&) {    // NOLINT(bugprone-empty-catch)
  } catch (const petsc::Error&) {  // NOLINT(bugprone-empty-catch): what PETSc finds is a message, too
  }
}

/// @brief The bytes of an input, one decision after the other; zeros behind their end.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : left_{reinterpret_cast<const char*>(data), size} {}

  [[nodiscard]] bool empty() const noexcept { return left_.empty(); }
  template <class Number>
  Number number() {
    Number value{};
    const std::string_view bytes = text(sizeof(Number));
    std::memcpy(&value, bytes.data(), bytes.size());
    return value;
  }
  /// One of `count` things.
  std::size_t choice(std::size_t count) { return number<std::uint8_t>() % count; }
  std::string_view text(std::size_t most) {
    const std::string_view taken = left_.substr(0, most);
    left_.remove_prefix(taken.size());
    return taken;
  }
  /// All that is left.
  std::string_view rest() { return text(left_.size()); }
  /// Up to a mark, which is passed over, or to the end.
  std::string_view part(std::string_view mark) {
    const std::string_view taken = left_.substr(0, left_.find(mark));
    left_.remove_prefix(taken.size());
    static_cast<void>(text(mark.size()));
    return taken;
  }

 private:
  std::string_view left_;
};

}  // namespace udar::fuzz

/// @name What libFuzzer calls, or `replay.cpp` where there is none.
/// @{
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv);
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
/// @}
