#include "io/hdf5_types.hpp"

#include <algorithm>
#include <utility>

namespace udar::io {

Hdf5Id& Hdf5Id::operator=(Hdf5Id&& other) noexcept {
  if (this != &other) {
    reset();
    id_ = other.release();
    close_ = other.close_;
  }
  return *this;
}

hid_t Hdf5Id::release() noexcept { return std::exchange(id_, H5I_INVALID_HID); }

void Hdf5Id::reset() noexcept {
  if (id_ >= 0) {
    close_(id_);
  }
  id_ = H5I_INVALID_HID;
}

Hdf5Id text_type(std::size_t length) {
  Hdf5Id type{H5Tcopy(H5T_C_S1), H5Tclose};
  H5Tset_size(type, std::max<std::size_t>(length, 1));
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

}  // namespace udar::io
