/// \file  A folder for one test, or for one run of a program that tests.
#pragma once
#include <unistd.h>
#include <cerrno>
#include <filesystem>
#include <string>
#include <system_error>

namespace enfilade::tests {

/// Fresh and empty, gone with this object. No two share a name, as tests run at the same time.
/// \throws std::system_error
class TemporaryFolder {
 public:
  explicit TemporaryFolder(const std::string& name) {
    std::string made =
        (std::filesystem::temp_directory_path() / ("enfilade_" + name + "_XXXXXX")).string();
    if (mkdtemp(made.data()) == nullptr) {
      throw std::system_error(errno, std::generic_category(), made);
    }
    path_ = made;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace enfilade::tests
