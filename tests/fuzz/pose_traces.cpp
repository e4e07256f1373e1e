// Pose traces. The first byte says what the rest is: 'z' a whole .npz, any other one of the arrays
// of a trace that is good but for that. What is accepted is written and read back equal.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/scan/file_tree.h"
#include "enfilade/tasks/pose_trace.h"

namespace {

using namespace enfilade;

constexpr std::array kArrays{"pano",       "time",      "extrinsic_matrix", "intrinsic_matrix",
                             "audio_time", "text_mask", "feature_weights"};

bool times_are_floats(const tasks::PoseSnapshot& one) {
  constexpr double kMost = std::numeric_limits<float>::max();
  return std::abs(one.time) <= kMost && std::abs(one.audio_time.value_or(0)) <= kMost;
}

// Times become floats when they are written, and stay what they are from then on.
void check_trace(std::string bytes) {
  const tasks::PoseTrace trace = tasks::parse_pose_trace(std::move(bytes), "<fuzz>");
  for (const tasks::PoseSnapshot& one : trace.snapshots) look_of(one);
  std::string written;
  try {
    written = to_npz(trace);
  } catch (const ArgumentError&) {
    EN_CHECK(!std::ranges::all_of(trace.snapshots, times_are_floats));
    return;
  }
  EN_CHECK(to_npz(tasks::parse_pose_trace(written, "<fuzz>")) == written);
}

// The arrays of a good trace, with one of them replaced or added.
std::string with_array(std::size_t which, std::string bytes) {
  static const std::vector<scan::ZipEntry> kGood = [] {
    tasks::PoseTrace trace;
    const tasks::CameraLook look{{1, 2, 3}, Radians(1), Radians(0.2), Radians(1), 1.5};
    trace.snapshots = {snapshot_of("v0", 0, look), snapshot_of("v1", 1, look)};
    const auto tree = scan::FileTree::zip_in_memory(to_npz(trace), "<made>");
    std::vector<scan::ZipEntry> entries;
    for (const std::string& name : tree->names()) entries.push_back({name, *tree->read(name)});
    return entries;
  }();
  std::vector<scan::ZipEntry> entries = kGood;
  const std::string name = std::string(kArrays[which]) + ".npy";
  const auto found = std::ranges::find(entries, name, &scan::ZipEntry::name);
  if (found != entries.end()) {
    found->content = std::move(bytes);
  } else {
    entries.push_back({name, std::move(bytes)});
  }
  return scan::zip(entries);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string bytes(reinterpret_cast<const char*>(data + 1), size - 1);
  try {
    if (data[0] == 'z') {
      check_trace(bytes);
    } else {
      check_trace(with_array(data[0] % kArrays.size(), bytes));
    }
  } catch (const Error&) {
  }
  return 0;
}
