#include "tests/includes/include_arrows.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <utility>

#include "enfilade/core/file.h"  // read_file

namespace enfilade::tests {
namespace {

/// A library, by how its headers' names begin, and the parts of the tree that may see it. A new
/// dependency is a decision: it needs a row here and its reason in docs/dependencies.md.
struct ThirdParty {
  std::string_view prefix;
  std::vector<std::string_view> allowed_in;
};

const std::vector<ThirdParty>& third_parties() {
  static const std::vector<ThirdParty> kThirdParties{
      {"fmt/", {"enfilade/", "apps/", "bench/", "tests/", "examples/"}},
      {"simdjson.h", {"enfilade/", "tests/"}},
      {"nlohmann/", {"enfilade/", "apps/", "bench/", "tests/"}},
      {"tbb/", {"enfilade/core/"}},
      {"nanoflann.hpp", {"enfilade/"}},
      {"zlib.h", {"enfilade/core/gzip", "apps/", "tests/"}},
      {"httplib.h", {"enfilade/arena/bounded_client.cpp", "enfilade/service/client.cpp", "tests/"}},
      {"kainjow/", {"enfilade/arena/prompt.cpp"}},
      {"SQLiteCpp/", {"enfilade/service/store/", "tests/"}},
      {"libpq-fe.h", {"enfilade/service/store/"}},
      {"openssl/",
       {"enfilade/arena/bounded_client.cpp", "enfilade/service/detail/", "tests/arena/"}},
      {"hwy/",
       {"enfilade/image/", "enfilade/render/", "enfilade/neural/", "enfilade/continuous/",
        "apps/"}},
      {"turbojpeg.h", {"enfilade/image/"}},
      {"jpeglib.h", {"enfilade/image/"}},
      {"jerror.h", {"enfilade/image/"}},
      {"spng.h", {"enfilade/image/"}},
      {"zip.h", {"enfilade/scan/", "tests/"}},
      {"zstd.h", {"enfilade/scan/"}},
      {"xxhash.h",
       {"enfilade/scan/", "enfilade/render/", "enfilade/features/", "enfilade/models/",
        "enfilade/neural/", "enfilade/arena/", "enfilade/continuous/", "tests/"}},
      {"utf8proc.h", {"enfilade/models/vocabularies/"}},
      {"embree3/", {"enfilade/mesh/"}},
      {"embree4/", {"enfilade/mesh/"}},
      {"tiny_gltf.h", {"enfilade/mesh/"}},
      {"draco/", {"enfilade/mesh/readers/"}},
      {"meshoptimizer.h", {"enfilade/mesh/readers/"}},
      {"webp/", {"enfilade/mesh/readers/"}},
      {"Recast.h", {"enfilade/mesh/", "enfilade/continuous/habitat/"}},
      {"Detour", {"enfilade/continuous/"}},
      {"epoxy/", {"enfilade/render/gl/"}},
      {"ATen/", {"enfilade/neural/", "tests/conformance/", "tests/support/", "bench/"}},
      {"torch/", {"enfilade/neural/"}},
      {"c10/", {"enfilade/neural/", "tests/conformance/", "tests/support/", "bench/"}},
      {"hdf5.h", {"enfilade/features/"}},
      {"CLI/", {"apps/", "bench/", "tests/conformance/"}},
      {"benchmark/", {"bench/"}},
      {"opencv2/", {"bench/peer/", "compat/"}},
      {"MatterSim.hpp", {"bench/peer/", "compat/", "tests/install/"}},
      {"gtest/", {"tests/"}},
      {"gmock/", {"tests/"}},
  };
  return kThirdParties;
}

/// The standard library's headers are the only ones with neither folder nor suffix in their names.
bool is_standard(std::string_view name) {
  return name.find_first_of("./") == std::string_view::npos;
}

/// What a source may use of POSIX and Linux, but no public header.
bool is_posix(std::string_view name) {
  static const std::set<std::string_view> kPosix{
      "unistd.h",    "fcntl.h",     "signal.h",     "spawn.h",       "dirent.h",   "poll.h",
      "dlfcn.h",     "link.h",      "netinet/in.h", "netdb.h",       "malloc.h",   "sched.h",
      "arpa/inet.h", "semaphore.h", "pthread.h",    "netinet/tcp.h", "linux/tcp.h"};
  return kPosix.contains(name) || name.starts_with("sys/");
}

/// The header of all names, for users' short programs: may include every folder, and none may it.
constexpr std::string_view kAllNames = "enfilade/enfilade.h";
/// Recordings are compared with the parts of a library too, and tests of a library share helpers.
constexpr std::array<std::string_view, 3> kTestsOfParts{"tests/conformance/", "tests/fuzz/",
                                                        "tests/support/"};
constexpr std::array<std::string_view, 4> kBenchesOfParts{
    "bench/bench_cuda.cpp", "bench/bench_duet.cpp", "bench/bench_neural.cpp",
    "bench/products_test.cpp"};

constexpr std::array<std::string_view, 6> kRoots{"enfilade", "apps",  "bench",
                                                 "compat",   "tests", "examples"};

/// Where a file lies: "enfilade/graph/x.h" is in the root enfilade and its folder graph.
struct Place {
  std::string_view root;
  std::string_view folder;  ///< of enfilade/; empty elsewhere, and for a file right in enfilade/

  bool operator==(const Place&) const = default;
};

Place place_of(std::string_view path) {
  const std::size_t slash = path.find('/');
  if (slash == std::string_view::npos) return {};
  const std::string_view root = path.substr(0, slash);
  const std::string_view rest = path.substr(slash + 1);
  const std::size_t next = rest.find('/');
  if (root != "enfilade" || next == std::string_view::npos) return {root, {}};
  return {root, rest.substr(0, next)};
}

/// The sub-folder of its library that a file lies in: "http" for "enfilade/service/http/x.h". Empty
/// for a file right in the library.
std::string_view room_of(std::string_view path) {
  const Place place = place_of(path);
  if (place.folder.empty()) return {};
  const std::string_view rest = path.substr(path.find(place.folder) + place.folder.size() + 1);
  const std::size_t slash = rest.find('/');
  return slash == std::string_view::npos ? std::string_view{} : rest.substr(0, slash);
}

bool is_unit_test(std::string_view path) { return path.ends_with("_test.cpp"); }
bool in_detail(std::string_view path) { return path.find("/detail/") != std::string_view::npos; }
bool in_room(std::string_view path) { return !in_detail(path) && !room_of(path).empty(); }
bool is_public_header(std::string_view path) {
  return path.starts_with("enfilade/") && path.ends_with(".h") && !in_detail(path) &&
         !in_room(path);
}

/// Goes through one file.
class FileChecker {
 public:
  FileChecker(const SourceFile& file, const Arrows& allowed, std::vector<Diagnostic>& found)
      : file_(file), place_(place_of(file.path)), allowed_(allowed), found_(found) {}

  void check() {
    const bool known =
        place_.root != "enfilade" || file_.path == kAllNames || allowed_.contains(place_.folder);
    if (!known) report("unknown-folder", "lies in no folder of the table of arrows");
    if (known && in_room(file_.path) && !rooms_here().contains(room_of(file_.path))) {
      report("unknown-folder", "lies in no room of its library's table");
    }
    for (std::string_view rest = file_.text; !rest.empty();) {
      ++line_;
      const std::size_t end = std::min(rest.find('\n'), rest.size());
      const std::string_view name = included_name(rest.substr(0, end));
      if (known && !name.empty()) check_include(name);
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    check_namespace();
    if (line_ > kMaxLines) {
      report("too-long", fmt::format("{} lines, at most {}; split it by idea", line_, kMaxLines));
    }
  }

 private:
  void report(std::string code, std::string message) {
    found_.push_back({Severity::kError, file_.path, fmt::format("line {}", line_), std::move(code),
                      std::move(message)});
  }

  // A header opens its folder's namespace; forward declarations may open others.
  void check_namespace() {
    if (!file_.path.starts_with("enfilade/") || !file_.path.ends_with(".h")) return;
    std::string wanted = "namespace enfilade";
    // The vocabulary is in enfilade itself.
    if (place_.folder != "core" && place_.folder != "geometry") {
      for (std::size_t at = file_.path.find('/'); at != file_.path.rfind('/');) {
        const std::size_t next = file_.path.find('/', at + 1);
        wanted += "::" + file_.path.substr(at + 1, next - at - 1);
        at = next;
      }
    }
    const bool opened = file_.text.find("namespace") == std::string::npos ||
                        file_.text.find("\n" + wanted + " {") != std::string::npos ||
                        file_.text.find("\n" + wanted + "::") != std::string::npos;
    if (!opened) report("namespace", fmt::format("does not open its folder's {}", wanted));
  }

  void check_include(std::string_view name) {
    const Place target = place_of(name);
    if (std::ranges::find(kRoots, target.root) != kRoots.end()) {
      check_arrow(name, target);
      if (in_detail(name) || in_room(name)) check_private(name, target);
    } else if (!is_standard(name)) {
      check_third_party(name);
    }
  }

  void check_arrow(std::string_view name, const Place& target) {
    if (target == place_) return;
    if (may_reach(target)) return;
    report("upward", fmt::format("{}/ may not include \"{}\"",
                                 place_.folder.empty() ? place_.root : place_.folder, name));
  }

  bool may_reach(const Place& target) const {
    if (target.root == "enfilade") {
      if (place_.root != "enfilade" || file_.path == kAllNames) return true;
      return allowed_.find(place_.folder)->second.contains(target.folder);
    }
    // A benchmark may drive what the tests drive: scripted workers, a server of its own.
    if (target.root == "tests") return is_unit_test(file_.path) || place_.root == "bench";
    // Tests call the command line's parts; programs of both have its options and exit codes.
    return (place_.root == "tests" || place_.root == "bench") && target.root == "apps";
  }

  /// \pre `name` lies in a detail/ or in a room
  void check_private(std::string_view name, const Place& target) {
    if (std::ranges::any_of(kTestsOfParts,
                            [&](auto part) { return file_.path.starts_with(part); })) {
      return;
    }
    // Some parts are timed alone.
    if (std::ranges::find(kBenchesOfParts, file_.path) != kBenchesOfParts.end()) return;
    if (target != place_ && target.folder != "core") {
      report("detail", fmt::format("\"{}\" is private to its folder", name));
    } else if (is_public_header(file_.path)) {
      report("private-header",
             fmt::format("a public header includes \"{}\", which is not installed", name));
    } else if (in_room(name)) {
      check_room(name);
    }
  }

  const Arrows& rooms_here() const {
    static const Arrows kNone;
    const auto row = rooms().find(place_.folder);
    return row == rooms().end() ? kNone : row->second;
  }

  // What lies right in the library may include all of its rooms; its detail/ none.
  void check_room(std::string_view name) {
    const std::string_view from = room_of(file_.path);
    const std::string_view to = room_of(name);
    if (from.empty() || from == to) return;
    const auto row = rooms_here().find(from);
    if (row == rooms_here().end() || !row->second.contains(to)) {
      report("upward", fmt::format("{}/{}/ may not include \"{}\"", place_.folder, from, name));
    }
  }

  void check_third_party(std::string_view name) {
    if (is_public_header(file_.path)) {
      report("third-party", fmt::format("a public header includes <{}>; only the standard's and "
                                        "Enfilade's own are allowed",
                                        name));
      return;
    }
    if (is_posix(name)) return;
    const auto library = std::ranges::find_if(
        third_parties(), [&](const ThirdParty& row) { return name.starts_with(row.prefix); });
    if (library == third_parties().end()) {
      report("third-party", fmt::format("<{}> belongs to no library of the table; Enfilade's own "
                                        "are named from the root of the tree",
                                        name));
    } else if (!is_allowed_here(*library)) {
      report("third-party",
             fmt::format("<{}> is allowed in {} only", name, fmt::join(library->allowed_in, ", ")));
    }
  }

  bool is_allowed_here(const ThirdParty& library) const {
    return std::ranges::any_of(library.allowed_in, [&](std::string_view part) {
      return file_.path.starts_with(part) || (part == "tests/" && is_unit_test(file_.path));
    });
  }

  const SourceFile& file_;
  Place place_;
  const Arrows& allowed_;
  std::vector<Diagnostic>& found_;
  std::size_t line_ = 0;
};

}  // namespace

const Arrows& direct_arrows() {
  static const Arrows kArrows{
      {"core", {}},
      {"net", {"core"}},
      {"geometry", {"core"}},
      {"image", {"core", "geometry"}},
      {"scan", {"core", "geometry", "image"}},
      {"mesh", {"core", "geometry", "image"}},
      {"graph", {"scan", "mesh"}},
      {"render", {"scan"}},
      {"sim", {"graph", "render"}},
      {"continuous", {"graph", "render"}},
      {"tasks", {"graph"}},
      {"capture", {"scan", "mesh", "graph", "tasks"}},
      {"dataset", {"tasks", "render", "sim"}},
      {"draw", {"graph", "render", "tasks"}},
      {"features", {"scan"}},
      {"homes", {"capture", "draw", "tasks"}},
      {"agents", {"sim", "continuous", "render", "tasks"}},
      {"arena", {"agents", "dataset", "draw", "net"}},
      {"models", {"features", "tasks"}},
      {"neural", {"agents", "dataset", "models"}},
      {"report", {"agents", "dataset", "draw", "homes", "models"}},
      {"exports", {"dataset", "features", "capture", "agents"}},
      {"service", {"agents", "arena", "dataset", "draw", "homes", "net"}},
  };
  return kArrows;
}

const std::map<std::string, Arrows, std::less<>>& rooms() {
  static const std::map<std::string, Arrows, std::less<>> kRooms{
      {"continuous", {{"pixels", {}}, {"habitat", {}}}},
      {"draw", {{"plan", {}}}},
      {"features", {{"formats", {}}}},
      {"homes",
       {{"plan", {}},
        {"looks", {"plan"}},
        {"furniture", {"looks"}},
        {"instructions", {}},
        {"sets", {}},
        {"benchmarks", {"instructions"}}}},
      {"mesh", {{"light", {}}, {"readers", {}}}},
      {"models", {{"vocabularies", {}}}},
      {"net", {{"connections", {}}}},
      {"neural",
       {{"core", {}},
        {"encoders", {"core"}},
        {"seq2seq", {"core"}},
        {"panoramic", {"core"}},
        {"duet", {"core"}},
        {"speaker", {"core", "panoramic"}},
        {"continuous", {"core"}}}},
      {"render", {{"cpu", {}}, {"cuda", {"cpu"}}, {"gl", {"cpu"}}}},
      {"report", {{"parts", {}}}},
      {"service",
       transitive_closure(
           {{"store", {}},
            {"accounts", {"store"}},
            {"browsing", {}},
            {"sessions", {"store"}},
            {"evaluation", {"accounts", "store"}},
            {"collecting", {"store"}},
            {"http", {"accounts", "browsing", "evaluation", "collecting", "sessions"}}})},
      {"tasks", {{"formats", {}}, {"measures", {}}, {"paths", {"formats"}}, {"scorers", {}}}},
  };
  return kRooms;
}

Arrows transitive_closure(const Arrows& direct) {
  Arrows closed;
  std::set<std::string, std::less<>> open;  // the chain of folders being followed
  const std::function<void(const std::string&)> close = [&](const std::string& folder) {
    if (closed.contains(folder)) return;
    const auto row = direct.find(folder);
    if (row == direct.end()) throw ArgumentError("an arrow leads to no folder: " + folder);
    if (!open.insert(folder).second) throw ArgumentError("the arrows make a ring at " + folder);
    std::set<std::string, std::less<>> reached;
    for (const std::string& below : row->second) {
      close(below);
      reached.insert(below);
      reached.insert(closed[below].begin(), closed[below].end());
    }
    open.erase(folder);
    closed[folder] = std::move(reached);
  };
  for (const auto& [folder, below] : direct) close(folder);
  return closed;
}

std::string_view included_name(std::string_view line) {
  const auto skip = [&line](std::string_view blanks) {
    line.remove_prefix(std::min(line.find_first_not_of(blanks), line.size()));
  };
  skip(" \t");
  if (!line.starts_with('#')) return {};
  line.remove_prefix(1);
  skip(" \t");
  constexpr std::string_view kInclude = "include";
  if (!line.starts_with(kInclude)) return {};
  line.remove_prefix(kInclude.size());
  skip(" \t");
  if (line.empty() || (line.front() != '"' && line.front() != '<')) return {};
  const char closing = line.front() == '"' ? '"' : '>';
  const std::size_t end = line.find(closing, 1);
  return end == std::string_view::npos ? std::string_view{} : line.substr(1, end - 1);
}

std::vector<Diagnostic> check_includes(const std::vector<SourceFile>& files) {
  const Arrows allowed = transitive_closure(direct_arrows());
  std::vector<Diagnostic> found;
  for (const SourceFile& file : files) FileChecker(file, allowed, found).check();
  return found;
}

std::vector<SourceFile> read_sources(const std::filesystem::path& root) {
  std::vector<SourceFile> files;
  for (const std::string_view part : kRoots) {
    if (!std::filesystem::exists(root / part)) continue;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / part)) {
      const std::filesystem::path& path = entry.path();
      if (path.extension() != ".h" && path.extension() != ".cpp") continue;
      files.push_back({path.lexically_relative(root).generic_string(), read_file(path)});
    }
  }
  std::ranges::sort(files, {}, &SourceFile::path);
  return files;
}

}  // namespace enfilade::tests
