#include <algorithm>
#include <vector>

#include "io/hdf5_types.hpp"
#include "udar/io/hdf5_file.hpp"

namespace udar::io {

bool Hdf5File::has(const std::string& object, const std::string& attribute) {
  const bool object_exists = object == "/" || H5Lexists(file_, object.c_str(), H5P_DEFAULT) > 0;
  return object_exists && H5Aexists_by_name(file_, object.c_str(), attribute.c_str(), H5P_DEFAULT) > 0;
}

void Hdf5File::read_attribute_of(const std::string& object, const std::string& name, hid_t type, void* value) {
  agree(has(object, name), object + " has no attribute " + name);
  const Hdf5Id attribute{H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose};
  agree(attribute.valid());
  const Hdf5Id space{H5Aget_space(attribute), H5Sclose};
  agree(H5Sget_simple_extent_npoints(space) == 1, "attribute " + name + " of " + object + " is not a single value");
  agree(H5Aread(attribute, type, value) >= 0);
}

std::string Hdf5File::read_text(const std::string& object, const std::string& name) {
  std::string text(kAttributeBytesMax, '\0');
  read_attribute_of(object, name, text_type(text.size()), text.data());
  text.resize(std::min(text.find('\0'), text.size()));
  return text;
}

double Hdf5File::read_double(const std::string& object, const std::string& name) {
  double value = 0.0;
  read_attribute_of(object, name, H5T_NATIVE_DOUBLE, &value);
  return value;
}

std::int64_t Hdf5File::read_int(const std::string& object, const std::string& name) {
  std::int64_t value = 0;
  read_attribute_of(object, name, H5T_NATIVE_INT64, &value);
  return value;
}

std::uint64_t Hdf5File::read_uint(const std::string& object, const std::string& name) {
  std::uint64_t value = 0;
  read_attribute_of(object, name, H5T_NATIVE_UINT64, &value);
  return value;
}

std::vector<std::string> Hdf5File::attribute_names(const std::string& object) {
  agree(H5Lexists(file_, object.c_str(), H5P_DEFAULT) > 0, "there is no " + object);
  std::vector<std::string> names;
  const auto collect = [](hid_t, const char* name, const H5A_info_t*, void* list) -> herr_t {
    static_cast<std::vector<std::string>*>(list)->emplace_back(name);
    return 0;
  };
  agree(H5Aiterate_by_name(file_, object.c_str(), H5_INDEX_NAME, H5_ITER_INC, nullptr, collect, &names, H5P_DEFAULT) >=
        0);
  return names;
}

std::vector<std::string> Hdf5File::dataset_names(const std::string& group) {
  agree(H5Lexists(file_, group.c_str(), H5P_DEFAULT) > 0, "there is no " + group);
  std::vector<std::string> names;
  const auto collect = [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
    static_cast<std::vector<std::string>*>(list)->emplace_back(name);
    return 0;
  };
  agree(H5Literate_by_name(file_, group.c_str(), H5_INDEX_CRT_ORDER, H5_ITER_INC, nullptr, collect, &names,
                           H5P_DEFAULT) >= 0);
  return names;
}

std::vector<double> Hdf5File::read_small(const std::string& name) {
  const Hdf5Id data{H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose};
  agree(data.valid());
  const Hdf5Id space{H5Dget_space(data), H5Sclose};
  const hssize_t total = H5Sget_simple_extent_npoints(space);
  const Hdf5Id type{H5Dget_type(data), H5Tclose};
  agree(total >= 0 && type.valid());
  // What was never written has a size, too, of which memory would be taken.
  agree(static_cast<double>(H5Dget_storage_size(data)) >=
            static_cast<double>(total) * static_cast<double>(H5Tget_size(type)),
        name + " is not there as a whole");
  std::vector<double> values(static_cast<std::size_t>(total));
  if (total > 0) {
    agree(H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, transfer_, values.data()) >= 0);
  }
  return values;
}

std::string Hdf5File::read_bytes(const std::string& name) {
  const Hdf5Id data{H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose};
  agree(data.valid());
  const Hdf5Id space{H5Dget_space(data), H5Sclose};
  const hssize_t total = H5Sget_simple_extent_npoints(space);
  agree(total >= 0);
  std::string bytes(static_cast<std::size_t>(total), '\0');
  if (total > 0) {
    agree(H5Dread(data, H5T_NATIVE_UINT8, H5S_ALL, H5S_ALL, transfer_, bytes.data()) >= 0);
  }
  return bytes;
}

std::vector<double> Hdf5File::read_node_values(const std::string& name, const NodeRange& nodes) {
  const Hdf5Id data{H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose};
  agree(data.valid());
  const Hdf5Id space{H5Dget_space(data), H5Sclose};
  const hssize_t total = H5Sget_simple_extent_npoints(space);
  agree(
      H5Sget_simple_extent_ndims(space) == 1 && total == static_cast<hssize_t>(nodes.total),
      name + " has " + std::to_string(total) + " values where this run has " + std::to_string(nodes.total) + " nodes");
  const hsize_t begin = count_of(nodes.begin);
  const hsize_t count = count_of(nodes.count());
  const hsize_t memory = std::max<hsize_t>(count, 1);
  const Hdf5Id memory_space{H5Screate_simple(1, &memory, nullptr), H5Sclose};
  if (count > 0) {
    agree(H5Sselect_hyperslab(space, H5S_SELECT_SET, &begin, nullptr, &count, nullptr) >= 0);
  } else {
    agree(H5Sselect_none(space) >= 0 && H5Sselect_none(memory_space) >= 0);
  }
  std::vector<double> values(count);
  agree(H5Dread(data, H5T_NATIVE_DOUBLE, memory_space, space, transfer_, values.data()) >= 0);
  return values;
}

}  // namespace udar::io
