/// \file  A file that only grows.
#pragma once
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>

namespace enfilade::models::detail {

/// What is written is in the system's hands when write() returns, so it survives the process. One
/// thread.
class AppendFile {
 public:
  /// Opens at the end of what is there, or makes the file. \throws FileError
  explicit AppendFile(const std::filesystem::path& path);
  void write(std::string_view bytes);  ///< \throws FileError

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace enfilade::models::detail
