#include "enfilade/core/output_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "enfilade/core/detail/replace_file.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/names.h"

namespace enfilade {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void stop(const fs::path& path, const char* doing, int reason) {
  // What open() says of a link where it must not follow one is no help to a reader.
  const std::string why = reason == ELOOP || reason == ENOTDIR
                              ? "a link or a file stands in the place of a folder"
                              : std::generic_category().message(reason);
  throw FileError(fmt::format("{}: cannot {}: {}", path.string(), doing, why));
}

// ".part" and a process id, which write() puts behind a name.
constexpr std::size_t kLongestOwnName = 255 - 12;

void split(std::string_view name, std::vector<std::string>& parts) {
  for (std::size_t at = 0; at <= name.size();) {
    const std::size_t end = std::min(name.find('/', at), name.size());
    parts.emplace_back(name.substr(at, end - at));
    at = end + 1;
  }
}

Descriptor open_root(const fs::path& folder) {
  const int root = ::open(folder.empty() ? "." : folder.c_str(), detail::kOpenFolder);
  if (root < 0) stop(folder, "open", errno);
  return Descriptor(root);
}

enum class Missing { kMake, kSkip };

// Opens the folder of the first `count` parts, follows no link. A missing one is made, or gives -1.
int open_below(const fs::path& folder, const std::vector<std::string>& parts, std::size_t count,
               Missing missing = Missing::kMake) {
  const Descriptor root = open_root(folder);
  int at = ::fcntl(root.number(), F_DUPFD_CLOEXEC, 0);
  if (at < 0) stop(folder, "open", errno);
  fs::path path = folder;
  for (std::size_t i = 0; i < count; ++i) {
    path /= parts[i];
    const Descriptor parent(at);
    if (missing == Missing::kMake && ::mkdirat(at, parts[i].c_str(), 0777) != 0 &&
        errno != EEXIST) {
      stop(path, "make the folder", errno);
    }
    at = ::openat(parent.number(), parts[i].c_str(), detail::kOpenFolder | O_NOFOLLOW);
    if (at < 0 && errno == ENOENT && missing == Missing::kSkip) return at;
    if (at < 0) stop(path, "open", errno);
  }
  return at;
}

// Removes a file, or a folder with everything in it. Goes by descriptors, so that a folder which
// becomes a link meanwhile leads nowhere.
void remove_tree(int parent, const std::string& name, const fs::path& shown) {
  if (::unlinkat(parent, name.c_str(), 0) == 0 || errno == ENOENT) return;
  if (errno != EISDIR) stop(shown, "remove", errno);
  {
    const Descriptor folder(
        ::openat(parent, name.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (folder.number() < 0) stop(shown, "remove", errno);
    std::vector<std::string> names;
    const int reason = detail::list_names(folder.number(), names);
    if (reason != 0) stop(shown, "remove", reason);
    for (const std::string& one : names) remove_tree(folder.number(), one, shown / one);
  }
  if (::unlinkat(parent, name.c_str(), AT_REMOVEDIR) != 0 && errno != ENOENT) {
    stop(shown, "remove", errno);
  }
}

}  // namespace

OutputFolder::OutputFolder(fs::path folder) : root_(std::move(folder)), path_(root_) {
  if (!root_.empty()) make_folder(root_);
}

OutputFolder::OutputFolder(const OutputFolder& above, std::string_view name)
    : root_(above.root_),
      below_(above.below_.empty() ? std::string(name) : above.below_ + "/" + std::string(name)),
      path_(above.path_ / name) {}

std::vector<std::string> OutputFolder::parts_of(std::string_view name) const {
  if (!is_name(name)) {
    throw ArgumentError(
        fmt::format("{}: {} is not a name of a file in this folder", path_.string(), quote(name)));
  }
  std::vector<std::string> parts;
  if (!below_.empty()) split(below_, parts);
  split(name, parts);
  return parts;
}

void OutputFolder::write(std::string_view name, std::string_view content) const {
  const std::vector<std::string> parts = parts_of(name);
  const Descriptor folder(open_below(root_, parts, parts.size() - 1));
  detail::replace_file(folder.number(), parts.back(), content, path_ / name);
}

fs::path OutputFolder::file(std::string_view name) const {
  const std::vector<std::string> parts = parts_of(name);
  const Descriptor folder(open_below(root_, parts, parts.size() - 1));
  struct stat status {};
  if (::fstatat(folder.number(), parts.back().c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 &&
      S_ISLNK(status.st_mode) && ::unlinkat(folder.number(), parts.back().c_str(), 0) != 0) {
    stop(path_ / name, "remove the link", errno);
  }
  return path_ / name;
}

OutputFolder OutputFolder::folder(std::string_view name) const {
  const std::vector<std::string> parts = parts_of(name);
  const Descriptor made(open_below(root_, parts, parts.size()));
  return {*this, name};
}

void OutputFolder::remove(std::string_view name) const {
  const std::vector<std::string> parts = parts_of(name);
  const Descriptor folder(open_below(root_, parts, parts.size() - 1, Missing::kSkip));
  if (folder.number() >= 0 && ::unlinkat(folder.number(), parts.back().c_str(), 0) != 0 &&
      errno != ENOENT) {
    stop(path_ / name, "remove", errno);
  }
}

bool OutputFolder::remove_empty(std::string_view name) const {
  const std::vector<std::string> parts = parts_of(name);
  const Descriptor folder(open_below(root_, parts, parts.size() - 1, Missing::kSkip));
  return folder.number() >= 0 &&
         ::unlinkat(folder.number(), parts.back().c_str(), AT_REMOVEDIR) == 0;
}

void OutputFolder::remove_all(std::string_view name) const {
  const std::vector<std::string> parts = parts_of(name);
  const Descriptor folder(open_below(root_, parts, parts.size() - 1, Missing::kSkip));
  if (folder.number() >= 0) remove_tree(folder.number(), parts.back(), path_ / name);
}

void OutputFolder::rename(std::string_view from, std::string_view to) const {
  const std::vector<std::string> old = parts_of(from), parts = parts_of(to);
  const Descriptor source(open_below(root_, old, old.size() - 1, Missing::kSkip));
  struct stat status {};
  if (source.number() < 0 ||
      ::fstatat(source.number(), old.back().c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0) {
    stop(path_ / from, "rename", source.number() < 0 ? ENOENT : errno);
  }
  const Descriptor target(open_below(root_, parts, parts.size() - 1));
  if (::renameat(source.number(), old.back().c_str(), target.number(), parts.back().c_str()) != 0) {
    stop(path_ / to, "write", errno);
  }
}

void OutputFolder::remove_unfinished(std::string_view folder, std::string_view ending) const {
  std::vector<std::string> parts;
  if (!folder.empty()) {
    parts = parts_of(folder);
  } else if (!below_.empty()) {
    split(below_, parts);
  }
  int number = -1;
  try {
    number = open_below(root_, parts, parts.size(), Missing::kSkip);
  } catch (const FileError&) {
    return;  // a link: what is behind it is not ours
  }
  const Descriptor there(number);
  if (number >= 0) {
    detail::remove_unfinished(number, ending, folder.empty() ? path_ : path_ / folder);
  }
}

bool OutputFolder::is_name(std::string_view name) noexcept {
  for (std::size_t at = 0; at <= name.size();) {
    const std::size_t end = std::min(name.find('/', at), name.size());
    if (!is_file_name(name.substr(at, end - at))) return false;
    if (end == name.size() && end - at > kLongestOwnName) return false;
    at = end + 1;
  }
  return true;
}

}  // namespace enfilade
