#include "enfilade/scan/file_tree.h"

#include <fmt/format.h>
#include <xxhash.h>
#include <zip.h>
#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <mutex>
#include <set>
#include <string_view>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/names.h"

namespace enfilade::scan {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kShownPath = 255;  // in messages, bytes
constexpr std::size_t kWhole = std::numeric_limits<std::size_t>::max();
// Of those that are packed like gzip's bombs fewer bytes are read (core/gzip.h).
constexpr std::uint64_t kLargestEntry = std::uint64_t{1} << 30;

[[noreturn]] void fail(const std::string& path, const char* doing, int reason) {
  throw FileError(
      fmt::format("{}: cannot {}: {}", path, doing, std::generic_category().message(reason)));
}

/// Name, size and time of a file.
std::string stamp(const fs::path& path) {
  std::error_code code;
  const std::uintmax_t size = fs::file_size(path, code);
  if (code) fail(path.string(), "look at", code.value());
  const fs::file_time_type time = fs::last_write_time(path, code);
  if (code) fail(path.string(), "look at", code.value());
  return fmt::format("{} {} {}\n", path.string(), size, time.time_since_epoch().count());
}

// --- a folder -------------------------------------------------------------------------------

class Folder final : public FileTree {
 public:
  explicit Folder(fs::path path) : path_(std::move(path)) {}

  std::optional<std::string> read_start(std::string_view name, std::size_t bytes) const override {
    if (!contains(name)) return std::nullopt;
    if (bytes == kWhole) return read_file(path_ / name);
    const std::string path = path_of(name);
    const auto close = [](std::FILE* f) { std::fclose(f); };
    const std::unique_ptr<std::FILE, decltype(close)> file(std::fopen(path.c_str(), "rb"), close);
    if (!file) fail(path, "open", errno);
    std::string start(bytes, '\0');
    start.resize(std::fread(start.data(), 1, bytes, file.get()));
    if (std::ferror(file.get()) != 0) fail(path, "read", errno);
    return start;
  }

  bool contains(std::string_view name) const override {
    if (name.empty() || name.find('/') != std::string_view::npos) return false;
    std::error_code code;
    const fs::file_status status = fs::status(path_ / name, code);
    if (status.type() == fs::file_type::not_found) return false;
    if (code) fail(path_of(name), "look at", code.value());
    return fs::is_regular_file(status);
  }

  std::vector<std::string> names() const override {
    std::vector<std::string> names;
    std::error_code code;
    for (fs::directory_iterator entry(path_, code), end; !code && entry != end;
         entry.increment(code)) {
      std::error_code gone;  // a file that disappears meanwhile is left out
      if (entry->is_regular_file(gone)) names.push_back(entry->path().filename().string());
    }
    if (code) fail(path_.string(), "list", code.value());
    std::ranges::sort(names);
    return names;
  }

  std::string path_of(std::string_view name) const override { return (path_ / name).string(); }

  std::string state() const override {
    std::string text;
    for (const std::string& name : names()) text += stamp(path_ / name);
    return text;
  }

 private:
  fs::path path_;
};

// --- a zip file -----------------------------------------------------------------------------

struct Discard {
  void operator()(zip_t* zip) const { zip_discard(zip); }
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};
using Handle = std::unique_ptr<zip_t, Discard>;

// libzip 1.11 has a code of its own for a file that is cut off.
bool lacks_list_of_entries(int code) {
#ifdef ZIP_ER_TRUNCATED_ZIP
  if (code == ZIP_ER_TRUNCATED_ZIP) return true;
#endif
  return code == ZIP_ER_NOZIP;
}

bool is_of_the_system(const zip_error_t& error) {
  const int kind = zip_error_system_type(&error);
  const int code = zip_error_code_zip(&error);
  return kind == ZIP_ET_SYS || code == ZIP_ER_NOENT || code == ZIP_ER_OPEN || code == ZIP_ER_MEMORY;
}

[[noreturn]] void fail_zip(zip_error_t& error, const std::string& name, bool opening) {
  const std::string words = zip_error_strerror(&error);
  const bool system = is_of_the_system(error);
  const int code = zip_error_code_zip(&error);
  zip_error_fini(&error);
  if (system) {
    throw FileError(fmt::format("{}: cannot {}: {}", name, opening ? "open" : "read", words));
  }
  if (opening && lacks_list_of_entries(code)) {
    refuse(name, "", "no-zip",
           "no zip file, or one that is cut off: the list of entries at its end is missing");
  }
  refuse(name, "", "bad-zip",
         fmt::format("a damaged {}: {}", opening ? "zip file" : "entry of a zip file", words));
}

std::string_view bare(std::string_view path) { return path.substr(path.rfind('/') + 1); }

/// A libzip handle serves one thread, and opening one reads the list of entries. So handles are
/// kept for later readers: there are as many as threads have ever read at once, which inflate in
/// parallel.
class Zip final : public FileTree {
 public:
  Zip(fs::path path, std::string bytes, std::string name, ZipNames names)
      : path_(std::move(path)), bytes_(std::move(bytes)), name_(std::move(name)), names_(names) {
    Handle handle = open();
    build_index(handle.get());
    idle_.push_back(std::move(handle));
  }

  std::optional<std::string> read_start(std::string_view name, std::size_t bytes) const override {
    const auto found = index_.find(name);
    if (found == index_.end()) return std::nullopt;
    const Entry& entry = entries_[found->second];
    if (entry.twice) {
      refuse(path_of(name), "", "repeated-name",
             names_ == ZipNames::kBare
                 ? fmt::format("lies in two folders of the zip, one of them {}",
                               quote(entry.path, kShownPath))
                 : std::string("comes twice in the zip"));
    }
    Handle handle = take();
    std::string content = read_entry(handle.get(), entry, path_of(name), bytes);
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(handle));
    return content;
  }

  bool contains(std::string_view name) const override { return index_.contains(name); }

  std::vector<std::string> names() const override {
    std::vector<std::string> names;
    names.reserve(index_.size());
    for (const auto& [name, place] : index_) names.emplace_back(name);
    std::ranges::sort(names);
    return names;
  }

  std::string path_of(std::string_view name) const override {
    return fmt::format("{}:{}", name_, name);
  }

  std::string state() const override {
    if (!path_.empty()) return stamp(path_);
    return fmt::format("{} {} {:x}\n", name_, bytes_.size(),
                       XXH3_64bits(bytes_.data(), bytes_.size()));
  }

 private:
  struct Entry {
    std::string path;  ///< in the zip
    std::uint64_t index = 0;
    std::uint64_t size = 0, packed = 0;
    bool twice = false;
  };

  Handle open() const {
    std::error_code ignored;  // libzip reports a file that is missing
    if (path_.empty() ? bytes_.empty() : fs::file_size(path_, ignored) == 0) {
      refuse(name_, "", "no-zip",
             "an empty file, no zip");  // to libzip it is a zip without entries
    }
    zip_error_t error;
    zip_error_init(&error);
    zip_source_t* source = path_.empty()
                               ? zip_source_buffer_create(bytes_.data(), bytes_.size(), 0, &error)
                               : zip_source_file_create(path_.c_str(), 0, -1, &error);
    if (source == nullptr) fail_zip(error, name_, true);
    zip_t* zip = zip_open_from_source(source, ZIP_RDONLY, &error);
    if (zip == nullptr) {
      zip_source_free(source);
      fail_zip(error, name_, true);
    }
    zip_error_fini(&error);
    return Handle(zip);
  }

  std::string_view name_of(std::string_view path) const {
    return names_ == ZipNames::kBare ? bare(path) : path;
  }

  void build_index(zip_t* zip) {
    const auto count = static_cast<std::uint64_t>(zip_get_num_entries(zip, 0));
    entries_.reserve(count);
    for (std::uint64_t i = 0; i < count; ++i) {
      zip_stat_t stat;
      // Raw: libzip would convert a name that is not UTF-8, and it would differ from a folder's.
      if (zip_stat_index(zip, i, ZIP_FL_ENC_RAW, &stat) != 0 || (stat.valid & ZIP_STAT_NAME) == 0) {
        refuse(name_, "", "bad-zip", fmt::format("a damaged zip file: entry {} has no name", i));
      }
      if (bare(stat.name).empty()) continue;  // a folder
      if ((stat.valid & ZIP_STAT_ENCRYPTION_METHOD) != 0 && stat.encryption_method != ZIP_EM_NONE) {
        refuse(name_, "", "encrypted",
               fmt::format("{} is encrypted, which is not read", quote(stat.name, kShownPath)));
      }
      entries_.push_back({stat.name, i, (stat.valid & ZIP_STAT_SIZE) != 0 ? stat.size : 0,
                          (stat.valid & ZIP_STAT_COMP_SIZE) != 0 ? stat.comp_size : 0});
    }
    index_.reserve(entries_.size());
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      const auto [at, fresh] = index_.emplace(name_of(entries_[i].path), i);
      if (!fresh) entries_[at->second].twice = true;
    }
  }

  Handle take() const {
    {
      const std::lock_guard lock(mutex_);
      if (!idle_.empty()) {
        Handle handle = std::move(idle_.back());
        idle_.pop_back();
        return handle;
      }
    }
    return open();
  }

  static std::string read_entry(zip_t* zip, const Entry& entry, const std::string& path,
                                std::size_t bytes) {
    const char* name = zip_get_name(zip, entry.index, ZIP_FL_ENC_RAW);
    if (name == nullptr || name != entry.path) {
      throw FileError(fmt::format("{}: the zip file was changed while it was read", path));
    }
    const std::uint64_t most = std::min(
        kLargestEntry, std::max<std::uint64_t>(kAlwaysUnpacked, kMostPacking * entry.packed));
    if (entry.size > most) {
      refuse(path, "", "too-large",
             fmt::format("{} bytes from {} packed ones; at most {} are read", entry.size,
                         entry.packed, most));
    }
    const std::unique_ptr<zip_file_t, Discard> file(zip_fopen_index(zip, entry.index, 0));
    if (!file) fail_read(zip_get_error(zip), path);
    std::string content;
    for (;;) {
      // Memory grows with what was read, not with what a damaged header claims. One byte more than
      // the entry has is asked for, to reach its end, where libzip compares the checksum.
      const std::size_t have = content.size();
      const std::size_t room =
          std::min<std::size_t>({bytes - have, static_cast<std::size_t>(entry.size) + 1 - have,
                                 std::max<std::size_t>(have, std::size_t{1} << 20)});
      if (room == 0) return content;
      content.resize(have + room);
      const zip_int64_t got = zip_fread(file.get(), content.data() + have, room);
      if (got < 0) fail_read(zip_file_get_error(file.get()), path);
      content.resize(have + static_cast<std::size_t>(got));
      if (got == 0 ? content.size() < entry.size : content.size() > entry.size) {
        refuse(path, "", "bad-zip",
               fmt::format("a damaged entry of a zip file: {} than the {} bytes "
                           "that are listed",
                           got == 0 ? "less" : "more", entry.size));
      }
      if (got == 0) return content;
    }
  }

  [[noreturn]] static void fail_read(const zip_error_t* error, const std::string& path) {
    zip_error_t copy = *error;
    copy.str = nullptr;  // the cached text belongs to libzip
    fail_zip(copy, path, false);
  }

  fs::path path_;      ///< empty: in memory
  std::string bytes_;  ///< of a zip in memory
  std::string name_;
  ZipNames names_;
  std::vector<Entry> entries_;
  std::unordered_map<std::string_view, std::size_t> index_;  ///< name_of() -> place in entries_
  mutable std::mutex mutex_;
  mutable std::vector<Handle> idle_;
};

}  // namespace

std::optional<std::string> FileTree::read(std::string_view name) const {
  return read_start(name, kWhole);
}

std::shared_ptr<const FileTree> FileTree::folder(const fs::path& path) {
  std::error_code code;
  const fs::file_status status = fs::status(path, code);
  if (code && status.type() != fs::file_type::not_found) fail(path.string(), "open", code.value());
  if (!fs::is_directory(status)) {
    fail(path.string(), "open", fs::exists(status) ? ENOTDIR : ENOENT);
  }
  return std::make_shared<Folder>(path);
}

std::shared_ptr<const FileTree> FileTree::zip(const fs::path& path, ZipNames names) {
  check_plain_file(path);
  return std::make_shared<Zip>(path, std::string(), path.string(), names);
}

std::shared_ptr<const FileTree> FileTree::zip_in_memory(std::string bytes,
                                                        const std::string& name) {
  return std::make_shared<Zip>(fs::path(), std::move(bytes), name, ZipNames::kBare);
}

// --- writing --------------------------------------------------------------------------------

namespace {

// The layout is that of PKWARE's APPNOTE.TXT, sections 4.3 and 4.4.
constexpr std::uint32_t kLocalHeader = 0x04034b50, kListEntry = 0x02014b50, kListEnd = 0x06054b50;
constexpr std::uint16_t kVersion = 20, kUtf8Names = 0x0800, kDeflated = 8;
constexpr std::uint16_t kFirstDay = 0x0021;  // 1980-01-01
// Around the deflated bytes, gzip has a header of this size and, behind, checksum and size.
constexpr std::size_t kGzipHeader = 10, kGzipTrailer = 8, kChecksum = 4;

void put16(std::string& bytes, std::size_t value) {
  for (const unsigned shift : {0U, 8U}) bytes += static_cast<char>(value >> shift & 0xffU);
}

void put32(std::string& bytes, std::size_t value) {
  for (const unsigned shift : {0U, 8U, 16U, 24U}) {
    bytes += static_cast<char>(value >> shift & 0xffU);
  }
}

void check(std::span<const ZipEntry> entries) {
  constexpr std::size_t kMost16 = std::numeric_limits<std::uint16_t>::max();
  if (entries.size() > kMost16) {
    throw ArgumentError(fmt::format("{} files in a zip; {} at most", entries.size(), kMost16));
  }
  std::set<std::string_view> names;
  for (const ZipEntry& entry : entries) {
    if (entry.name.empty() || entry.name.size() > kMost16) {
      throw ArgumentError(fmt::format("a name of {} bytes in a zip; 1 to {} are allowed",
                                      entry.name.size(), kMost16));
    }
    if (!names.insert(entry.name).second) {
      throw ArgumentError(fmt::format("{} is twice in a zip", quote(entry.name, kShownPath)));
    }
  }
}

void check_size(std::size_t bytes) {
  if (bytes >= std::numeric_limits<std::uint32_t>::max()) {
    throw ArgumentError(fmt::format("a zip of {} bytes; less than 4 GiB is allowed", bytes));
  }
}

// What the header of an entry and its place in the list have in common.
std::string common_fields(const ZipEntry& entry, std::string_view checksum, std::size_t packed) {
  std::string bytes;
  put16(bytes, kVersion);
  put16(bytes, kUtf8Names);
  put16(bytes, kDeflated);
  put16(bytes, 0);  // midnight
  put16(bytes, kFirstDay);
  bytes += checksum;
  put32(bytes, packed);
  put32(bytes, entry.content.size());
  put16(bytes, entry.name.size());
  put16(bytes, 0);  // no extra fields
  return bytes;
}

}  // namespace

std::string zip(std::span<const ZipEntry> entries) {
  check(entries);
  std::string bytes, list;
  for (const ZipEntry& entry : entries) {
    check_size(entry.content.size());
    const std::string gzipped = gzip(entry.content, 6);
    const std::string_view whole = gzipped;
    const std::size_t packed = whole.size() - kGzipHeader - kGzipTrailer;
    const std::string_view checksum = whole.substr(kGzipHeader + packed, kChecksum);
    const std::string fields = common_fields(entry, checksum, packed);
    check_size(bytes.size());
    const std::size_t place = bytes.size();
    put32(bytes, kLocalHeader);
    bytes.append(fields).append(entry.name).append(whole.substr(kGzipHeader, packed));
    put32(list, kListEntry);
    put16(list, kVersion);
    list += fields;
    put16(list, 0);  // no comment
    put16(list, 0);  // first disk
    put16(list, 0);  // attributes
    put32(list, 0);
    put32(list, place);
    list += entry.name;
  }
  const std::size_t place = bytes.size();
  check_size(place + list.size());
  bytes += list;
  put32(bytes, kListEnd);
  put16(bytes, 0);
  put16(bytes, 0);
  put16(bytes, entries.size());
  put16(bytes, entries.size());
  put32(bytes, list.size());
  put32(bytes, place);
  put16(bytes, 0);  // no comment
  return bytes;
}

}  // namespace enfilade::scan
