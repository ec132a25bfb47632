// A restart file with a right checksum over something that no run has written: HDF5 that is well formed, with objects
// that are missing, of another kind, another type or another size.

#include <hdf5.h>

#include <filesystem>
#include <vector>

#include "fuzz/falls.hpp"
#include "io/file_checksum.hpp"
#include "udar/io/checkpoint.hpp"
#include "udar/io/hdf5_file.hpp"

namespace {

using namespace udar;
using io::Hdf5Id;

constexpr const char* kWhole = "whole.h5";
constexpr const char* kChanged = "changed.h5";

/// What is in the file, by name: objects, and of each the attributes.
struct Content {
  std::vector<std::string> objects{"/"};
  std::vector<std::pair<std::string, std::string>> attributes;
};

Content content_of(const char* path) {
  Content content;
  const Hdf5Id file{H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
  const auto add = [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
    static_cast<std::vector<std::string>*>(list)->emplace_back(std::string{"/"} + name);
    return 0;
  };
  H5Lvisit(file, H5_INDEX_NAME, H5_ITER_INC, add, &content.objects);
  for (const std::string& object : content.objects) {
    std::vector<std::string> names;
    const auto add_name = [](hid_t, const char* name, const H5A_info_t*, void* list) -> herr_t {
      static_cast<std::vector<std::string>*>(list)->emplace_back(name);
      return 0;
    };
    H5Aiterate_by_name(file, object.c_str(), H5_INDEX_NAME, H5_ITER_INC, nullptr, add_name, &names, H5P_DEFAULT);
    for (const std::string& name : names) {
      content.attributes.emplace_back(object, name);
    }
  }
  return content;
}

Hdf5Id any_type(fuzz::Bytes& bytes) {
  switch (bytes.choice(7)) {
    case 0:
      return {H5Tcopy(H5T_NATIVE_INT8), H5Tclose};
    case 1:
      return {H5Tcopy(H5T_NATIVE_DOUBLE), H5Tclose};
    case 2:
      return {H5Tcopy(H5T_STD_U64BE), H5Tclose};
    case 3: {
      Hdf5Id text{H5Tcopy(H5T_C_S1), H5Tclose};
      H5Tset_size(text, 1 + bytes.choice(256));
      return text;
    }
    case 4: {
      Hdf5Id text{H5Tcopy(H5T_C_S1), H5Tclose};
      H5Tset_size(text, H5T_VARIABLE);
      return text;
    }
    case 5: {
      Hdf5Id pair{H5Tcreate(H5T_COMPOUND, 16), H5Tclose};
      H5Tinsert(pair, "a", 0, H5T_NATIVE_DOUBLE);
      return pair;
    }
    default:
      return {H5Tvlen_create(H5T_NATIVE_DOUBLE), H5Tclose};
  }
}

Hdf5Id any_space(fuzz::Bytes& bytes) {
  constexpr std::array<hsize_t, 8> kSizes{0, 1, 2, 7, 8, 64, hsize_t{1} << 33, hsize_t{1} << 60};
  const std::array<hsize_t, 2> sizes{kSizes.at(bytes.choice(8)), kSizes.at(bytes.choice(8))};
  switch (bytes.choice(4)) {
    case 0:
      return {H5Screate(H5S_NULL), H5Sclose};
    case 1:
      return {H5Screate(H5S_SCALAR), H5Sclose};
    case 2:
      return {H5Screate_simple(2, sizes.data(), nullptr), H5Sclose};
    default:
      return {H5Screate_simple(1, sizes.data(), nullptr), H5Sclose};
  }
}

void change_attribute(hid_t file, const Content& content, fuzz::Bytes& bytes) {
  const auto& [object, name] = content.attributes[bytes.choice(content.attributes.size())];
  H5Adelete_by_name(file, object.c_str(), name.c_str(), H5P_DEFAULT);
  if (bytes.choice(4) == 0) {
    return;
  }
  const Hdf5Id type = any_type(bytes);
  const Hdf5Id space = any_space(bytes);
  const Hdf5Id made{
      H5Acreate_by_name(file, object.c_str(), name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      H5Aclose};
  std::array<char, 256> value{};
  const std::string_view given = bytes.text(bytes.choice(value.size()));
  std::ranges::copy(given, value.begin());
  if (made.valid() && H5Tget_class(type) != H5T_VLEN && H5Tis_variable_str(type) <= 0 &&
      H5Sget_simple_extent_npoints(space) == 1) {
    H5Awrite(made, type, value.data());
  }
}

void change_object(hid_t file, const Content& content, fuzz::Bytes& bytes) {
  const std::string& name = content.objects[bytes.choice(content.objects.size())];
  const std::string& other = content.objects[bytes.choice(content.objects.size())];
  if (name == "/") {
    return;
  }
  H5Ldelete(file, name.c_str(), H5P_DEFAULT);
  switch (bytes.choice(5)) {
    case 0:
      break;
    case 1:
      static_cast<void>(Hdf5Id{H5Gcreate2(file, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose});
      break;
    case 2:
      H5Lcreate_soft(other.c_str(), file, name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
      break;
    case 3:
      H5Lcreate_hard(file, other.c_str(), file, name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
      break;
    default: {
      const Hdf5Id type = any_type(bytes);
      const Hdf5Id space = any_space(bytes);
      const Hdf5Id layout{H5Pcreate(H5P_DATASET_CREATE), H5Pclose};
      const int dimensions = H5Sget_simple_extent_ndims(space);
      if (dimensions > 0) {  // in pieces, of which none is written: of any size in a small file
        const std::array<hsize_t, 2> piece{64, 64};
        H5Pset_chunk(layout, dimensions, piece.data());
      }
      static_cast<void>(
          Hdf5Id{H5Dcreate2(file, name.c_str(), type, space, H5P_DEFAULT, layout, H5P_DEFAULT), H5Dclose});
    }
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes{data, size};
  const fuzz::Fall& fall = fuzz::falls()[1];
  const io::PointOrder points{fall.model->structure->points()};
  const io::PointOrder cells{points.comm(), fall.model->structure->topology()};
  static const Content kContent = [&] {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    MotionState state = fall.saved;
    state.parameters = {{.name = "nodes", .value = "7"}, {.name = "beam", .value = "short"}};
    io::write_checkpoint(points, kWhole, state, &cells);
    return content_of(kWhole);
  }();
  std::filesystem::copy_file(kWhole, kChanged, std::filesystem::copy_options::overwrite_existing);
  {
    const Hdf5Id file{H5Fopen(kChanged, H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose};
    for (int changes = 0; changes < 8 && !bytes.empty(); ++changes) {
      if (bytes.choice(2) == 0) {
        change_attribute(file, kContent, bytes);
      } else {
        change_object(file, kContent, bytes);
      }
    }
  }
  static_cast<void>(io::append_checksum(PETSC_COMM_WORLD, kChanged));
  fuzz::allow_refusal([&] {
    const MotionState state = io::read_checkpoint(points, kChanged, {}, &cells);
    fuzz::insert_case(fall.yaml);
    ImpactDynamics dynamics{*fall.model};
    dynamics.restore(state);
  });
  return 0;
}
