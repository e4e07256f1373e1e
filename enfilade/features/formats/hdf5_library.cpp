#include "enfilade/features/formats/hdf5_library.h"

namespace enfilade::features::formats {

std::mutex& Hdf5Library::mutex() {
  static std::mutex one;
  return one;
}

std::string Hdf5Library::reason() {
  std::string text;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned level, const H5E_error2_t* error, void* into) -> herr_t {
        // The innermost call gives the most exact reason.
        if (level == 0 && error->desc != nullptr) *static_cast<std::string*>(into) = error->desc;
        return 0;
      },
      &text);
  return text.empty() ? "the HDF5 library gives no reason" : text.substr(0, 300);
}

Hdf5Handle half_type() {
  Hdf5Handle type(H5Tcopy(H5T_IEEE_F32LE), H5Tclose);
  H5Tset_fields(type.id(), 15, 10, 5, 0, 10);
  H5Tset_size(type.id(), 2);
  H5Tset_ebias(type.id(), 15);
  return type;
}

}  // namespace enfilade::features::formats
