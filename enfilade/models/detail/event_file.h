/// \file  Numbers over time in TensorBoard's files: TFRecords of Event messages, written by hand
/// because the library that writes them is TensorFlow (docs/models.md).
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "enfilade/models/detail/append_file.h"

namespace enfilade::models::detail {

/// CRC-32C (Castagnoli). reference: RFC 3720, appendix B.4, has test vectors.
std::uint32_t crc32c(std::string_view bytes) noexcept;

/// One number of a curve.
struct Scalar {
  std::string_view tag;  ///< "val_seen/success_rate"
  double value = 0;      ///< kept in single precision
  std::uint64_t step = 0;
  double time = 0;  ///< seconds since 1970
};

/// One file of scalars, appended to. One thread.
class EventFile {
 public:
  static constexpr std::string_view kPrefix = "events.out.tfevents.";

  /// "events.out.tfevents.<seconds>.enfilade" in `folder`. \throws FileError
  EventFile(const std::filesystem::path& folder, double time);
  void add(const Scalar& scalar);  ///< \throws FileError

 private:
  void write_record(std::string_view event);
  AppendFile file_;
};

}  // namespace enfilade::models::detail
