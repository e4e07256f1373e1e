#include "enfilade/graph/check.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"

namespace enfilade::graph {
namespace {

using scan::Connectivity;
using scan::ConnectivityEntry;

// Rotation parts are printed with 6 to 7 digits in Matterport3D's files; products of two such
// numbers are off by a few times that.
constexpr double kPoseTolerance = 1e-3;

class Checker {
 public:
  Checker(const Connectivity& connectivity, const CheckOptions& options)
      : c_(connectivity),
        options_(options),
        n_(connectivity.entries.size()),
        part_(n_),
        touched_(n_, false) {
    std::iota(part_.begin(), part_.end(), std::size_t{0});
  }

  std::vector<Diagnostic> run() {
    if (n_ == 0) report(Severity::kWarning, "$", "no-viewpoints", "the file has no viewpoint");
    for (std::size_t i = 0; i < n_; ++i) {
      check_pose(i);
      check_edges(i);
    }
    check_isolated();
    check_parts();
    if (to_excluded_ > 0) {
      report(
          Severity::kNote, "$", "edge-to-excluded",
          fmt::format("{} flags of excluded viewpoints are set; they are ignored", to_excluded_));
    }
    return std::move(diagnostics_);
  }

  // Undirected ones between included viewpoints, counted by run().
  std::size_t edges() const { return edges_; }

 private:
  void report(Severity severity, std::string where, std::string code, std::string message) {
    diagnostics_.push_back(
        {severity, c_.file, std::move(where), std::move(code), std::move(message)});
  }

  bool unobstructed(std::size_t i, std::size_t j) const {
    return std::ranges::binary_search(c_.entries[i].unobstructed, ViewpointIndex(j));
  }

  // Rows of a rotation are of length 1, at right angles; the last row of the matrix is 0 0 0 1.
  void check_pose(std::size_t i) {
    const auto& p = c_.entries[i].pose;
    const auto dot = [&p](std::size_t a, std::size_t b) {
      return p[4 * a] * p[4 * b] + p[4 * a + 1] * p[4 * b + 1] + p[4 * a + 2] * p[4 * b + 2];
    };
    double worst = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = a; b < 3; ++b) {
        worst = std::max(worst, std::abs(dot(a, b) - (a == b ? 1 : 0)));
      }
    }
    const double determinant = p[0] * (p[5] * p[10] - p[6] * p[9]) -
                               p[1] * (p[4] * p[10] - p[6] * p[8]) +
                               p[2] * (p[4] * p[9] - p[5] * p[8]);
    const bool last_row = p[12] == 0 && p[13] == 0 && p[14] == 0 && p[15] == 1;
    if (worst > kPoseTolerance || determinant < 0 || !last_row) {
      report(Severity::kWarning, fmt::format("$[{}].pose", i), "bad-pose",
             fmt::format("not a rigid motion: its rotation is off by {:.3g}, determinant {:.3g}, "
                         "last row {} {} {} {}",
                         worst, determinant, p[12], p[13], p[14], p[15]));
    }
  }

  void check_edges(std::size_t i) {
    const ConnectivityEntry& from = c_.entries[i];
    for (const ViewpointIndex v : from.unobstructed) {
      const std::size_t j = v.at();
      const std::string where = fmt::format("$[{}].unobstructed[{}]", i, j);
      if (j == i) {
        report(Severity::kWarning, where, "self-edge", "a viewpoint is no neighbour of itself");
        continue;
      }
      if (!from.included || !c_.entries[j].included) {
        ++to_excluded_;
        continue;
      }
      touched_[i] = touched_[j] = true;
      if (!unobstructed(j, i)) {
        report(Severity::kWarning, where, "one-way-edge",
               fmt::format("true, but $[{}].unobstructed[{}] is false", j, i));
      } else if (j < i) {
        continue;  // reported from the other end
      }
      ++edges_;
      join(i, j);
      check_lengths(i, j, where);
    }
  }

  void check_lengths(std::size_t i, std::size_t j, const std::string& where) {
    const Vec3d offset = c_.entries[j].position() - c_.entries[i].position();
    const double distance = length(offset);
    if (distance > options_.longest_edge) {
      report(Severity::kWarning, where, "long-edge",
             fmt::format("{:.2f} m; the paper allows {:.2f} m", distance, options_.longest_edge));
    }
    const double flat = std::hypot(offset.x, offset.y);
    if (distance == 0) {
      report(Severity::kWarning, where, "same-position",
             "both ends are at one point: the heading between them is undefined");
    } else if (flat < options_.shortest_offset) {
      report(Severity::kWarning, where, "steep-edge",
             fmt::format("ends {:.4f} m apart horizontally: the heading is unstable", flat));
    }
  }

  void check_isolated() {
    for (std::size_t i = 0; i < n_; ++i) {
      if (c_.entries[i].included && !touched_[i]) {
        report(Severity::kWarning, fmt::format("$[{}]", i), "isolated-viewpoint",
               fmt::format("{} has no edge", c_.entries[i].id));
        isolated_.insert(i);
      }
    }
  }

  // All connected parts but the largest. Isolated viewpoints are left out, as they are reported
  // already.
  void check_parts() {
    std::vector<std::vector<std::size_t>> parts(n_);
    for (std::size_t i = 0; i < n_; ++i) {
      if (c_.entries[i].included && !isolated_.contains(i)) parts[root(i)].push_back(i);
    }
    std::erase_if(parts, [](const auto& part) { return part.empty(); });
    if (parts.size() < 2) return;
    const auto largest = std::ranges::max_element(parts, {}, &std::vector<std::size_t>::size);
    const std::size_t rest = largest->size();
    for (const auto& part : parts) {
      if (&part == &*largest) continue;
      report(Severity::kWarning, fmt::format("$[{}]", part.front()), "disconnected-part",
             fmt::format("{} viewpoints are out of reach of the other {}", part.size(), rest));
    }
  }

  std::size_t root(std::size_t i) {
    while (part_[i] != i) i = part_[i] = part_[part_[i]];
    return i;
  }
  void join(std::size_t i, std::size_t j) { part_[root(i)] = root(j); }

  const Connectivity& c_;
  const CheckOptions& options_;
  std::size_t n_;
  std::vector<std::size_t> part_;  // union-find
  std::vector<bool> touched_;      // by an edge
  std::set<std::size_t> isolated_;
  std::size_t to_excluded_ = 0, edges_ = 0;
  std::vector<Diagnostic> diagnostics_;
};

FileReport check_file(const std::filesystem::path& directory, const std::string& scan,
                      const CheckOptions& options) {
  FileReport report;
  report.scan = scan;
  try {
    const Connectivity connectivity = scan::load_connectivity(directory, scan);
    report.viewpoints = connectivity.entries.size();
    report.included = static_cast<std::size_t>(
        std::ranges::count(connectivity.entries, true, &ConnectivityEntry::included));
    Checker checker(connectivity, options);
    report.diagnostics = checker.run();
    report.edges = checker.edges();
  } catch (const InvalidInput& error) {
    report.diagnostics = error.diagnostics();
  } catch (const FileError& error) {
    report.diagnostics = {{Severity::kError, scan::connectivity_file(directory, scan).string(), "",
                           "no-file", error.what()}};
  }
  return report;
}

std::set<std::string> scans_with_files(const std::filesystem::path& directory) {
  std::set<std::string> scans;
  std::error_code code;
  for (const auto& entry : std::filesystem::directory_iterator(directory, code)) {
    if (auto scan = scan::scan_of_file(entry.path())) scans.insert(*std::move(scan));
  }
  if (code) throw FileError(fmt::format("{}: {}", directory.string(), code.message()));
  return scans;
}

}  // namespace

std::vector<Diagnostic> check_graph(const Connectivity& connectivity, const CheckOptions& options) {
  return Checker(connectivity, options).run();
}

std::vector<FileReport> check_folder(const std::filesystem::path& directory,
                                     const CheckOptions& options) {
  std::set<std::string> files = scans_with_files(directory);
  const bool listed = file_exists(directory / "scans.txt");
  const std::vector<std::string> scans = listed
                                             ? scan::load_scan_list(directory)
                                             : std::vector<std::string>(files.begin(), files.end());
  std::vector<FileReport> reports;
  for (const std::string& scan : scans) {
    reports.push_back(check_file(directory, scan, options));
    files.erase(scan);
  }
  if (scans.empty()) {
    throw FileError(
        fmt::format("{}: holds neither scans.txt nor any *_connectivity.json", directory.string()));
  }
  for (const std::string& scan : files) {
    FileReport report;
    report.scan = scan;
    report.diagnostics = {{Severity::kNote,
                           find_text_file(scan::connectivity_file(directory, scan)).string(), "",
                           "unlisted-file", "scans.txt does not name this scan; not checked"}};
    reports.push_back(std::move(report));
  }
  return reports;
}

}  // namespace enfilade::graph
