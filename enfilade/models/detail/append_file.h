/// \file  A file that is only appended to.
#pragma once
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>

namespace enfilade::models::detail {

/// When write() returns, the operating system has the data, so it survives a kill of the process.
/// One thread.
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

}  // namespace enfilade::models::detail
