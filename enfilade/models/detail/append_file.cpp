#include "enfilade/models/detail/append_file.h"

#include <fmt/format.h>
#include <cerrno>
#include <system_error>

#include "enfilade/core/errors.h"

namespace enfilade::models::detail {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, int reason) {
  throw FileError(
      fmt::format("{}: cannot write: {}", path.string(), std::generic_category().message(reason)));
}

}  // namespace

AppendFile::AppendFile(const std::filesystem::path& path)
    : path_(path), file_(std::fopen(path.c_str(), "ab")) {
  if (!file_) fail(path_, errno);
}

void AppendFile::write(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size() ||
      std::fflush(file_.get()) != 0) {
    fail(path_, errno);
  }
}

}  // namespace enfilade::models::detail
