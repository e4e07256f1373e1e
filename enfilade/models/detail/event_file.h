/// \file  TensorBoard's event files: TFRecords of Event messages. Written without a library, as the
/// only one is TensorFlow (docs/models.md).
#pragma once
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "enfilade/models/detail/append_file.h"

namespace enfilade::models::detail {

/// CRC-32C (Castagnoli). reference: RFC 3720, appendix B.4, has test vectors.
std::uint32_t crc32c(std::string_view bytes) noexcept;

/// One point of a curve.
struct Scalar {
  std::string_view tag;  ///< "val_seen/success_rate"
  double value = 0;      ///< stored in single precision
  std::uint64_t step = 0;
  double time = 0;  ///< seconds since 1970
};

/// Appends scalars to a file. One thread.
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
