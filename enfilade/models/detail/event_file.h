/// \file  TensorBoard's event files: TFRecords of Event messages. Written without a library, as the
/// only one is TensorFlow (docs/models.md).
#pragma once
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>

namespace enfilade::models::detail {

/// A file that is only appended to. When write() returns, the operating system has the data, so it
/// survives a kill of the process. One thread.
class AppendFile {
 public:
  /// Opens a file at its end, or creates it. \throws FileError
  explicit AppendFile(const std::filesystem::path& path);
  void write(std::string_view bytes);  ///< \throws FileError

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Close> file_;
};

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
