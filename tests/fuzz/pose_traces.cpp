// Pose traces. The first byte says what the rest is: 'z' a whole .npz, 'n' one array of NumPy's,
// any other one of the arrays of a trace that is good but for that. What is accepted is written and
// read back equal.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/scan/zip_writer.h"
#include "enfilade/tasks/formats/npy.h"
#include "enfilade/tasks/pose_trace.h"

namespace {

using namespace enfilade;
using tasks::formats::NpyArray;

constexpr std::array kArrays{"pano",       "time",      "extrinsic_matrix", "intrinsic_matrix",
                             "audio_time", "text_mask", "feature_weights"};

// Times become floats when they are written, and stay what they are from then on.
void check_trace(std::string bytes) {
  const tasks::PoseTrace trace = tasks::parse_pose_trace(std::move(bytes), "<fuzz>");
  for (const tasks::PoseSnapshot& one : trace.snapshots) look_of(one);
  std::string written;
  try {
    written = to_npz(trace);
  } catch (const ArgumentError&) {  // a time beyond the range of floats
    return;
  }
  EN_CHECK(to_npz(tasks::parse_pose_trace(written, "<fuzz>")) == written);
}

void check_array(std::string bytes) {
  const NpyArray array = NpyArray::parse(std::move(bytes));
  for (std::size_t i = 0; i < array.size(); ++i) {
    if (array.is_text()) {
      array.text(i);
    } else {
      array.number(i);
    }
  }
}

std::string with_array(std::size_t which, std::string_view bytes) {
  const std::vector<std::string> panos{"v0", "v1"};
  std::vector<scan::ZipEntry> entries{
      {"pano.npy", tasks::formats::write_npy(panos, {2, 1})},
      {"time.npy", tasks::formats::write_npy(std::vector<float>{0, 1}, {2, 1})},
      {"extrinsic_matrix.npy", tasks::formats::write_npy(std::vector<float>(32, 1), {2, 16})},
      {"intrinsic_matrix.npy", tasks::formats::write_npy(std::vector<float>(32, 1), {2, 16})}};
  if (which >= entries.size()) entries.push_back({std::string(kArrays[which]) + ".npy", ""});
  entries[std::min(which, entries.size() - 1)].content = bytes;
  return scan::zip(entries);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string bytes(reinterpret_cast<const char*>(data + 1), size - 1);
  try {
    if (data[0] == 'z') {
      check_trace(bytes);
    } else if (data[0] == 'n') {
      check_array(bytes);
    } else {
      check_trace(with_array(data[0] % kArrays.size(), bytes));
    }
  } catch (const Error&) {
  }
  return 0;
}
