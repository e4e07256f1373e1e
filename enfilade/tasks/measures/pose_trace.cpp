#include "enfilade/tasks/pose_trace.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/detail/json.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/numbers.h"
#include "enfilade/scan/file_tree.h"
#include "enfilade/scan/npy.h"

namespace enfilade::tasks {
namespace {

using json::Faults;
using json::Path;
using scan::NpyArray;
using scan::NpyKind;

constexpr std::size_t kMostBytes = std::size_t{1} << 28U;  // of an array
// A day at ten a second. A packed file of some hundred kilobytes may claim any number.
constexpr std::size_t kMostSnapshots = std::size_t{1} << 20U;
constexpr std::size_t kMatrix = 16;

// Reads the arrays of one file.
class TraceReader {
 public:
  TraceReader(const scan::FileTree& tree, const std::string& name) : tree_(tree), faults_(name) {}

  PoseTrace read() {
    const auto panos = array("pano", Need::kRequired);
    const auto times = array("time", Need::kRequired);
    const auto heard = array("audio_time", Need::kOptional);
    const auto extrinsic = array("extrinsic_matrix", Need::kRequired);
    const auto intrinsic = array("intrinsic_matrix", Need::kRequired);
    read_panos(panos);
    read_times(times);
    if (heard) read_heard(*heard);
    read_matrices("extrinsic_matrix", extrinsic, &PoseSnapshot::extrinsic);
    read_matrices("intrinsic_matrix", intrinsic, &PoseSnapshot::intrinsic);
    read_of_viewpoints();
    faults_.throw_if_errors();
    return std::move(trace_);
  }

 private:
  enum class Need : std::uint8_t { kRequired, kOptional };
  using Found = std::optional<NpyArray>;

  Found array(const std::string& name, Need need) {
    const std::string file = name + ".npy";
    const Path place(root_, name);
    if (!tree_.contains(file)) {
      if (need == Need::kRequired) {
        faults_.error(root_, "missing-array", fmt::format("has no array {}", quote(name)));
      }
      return std::nullopt;
    }
    try {
      // One byte more than is allowed, so that a larger one is seen and never taken whole.
      std::string bytes = *tree_.read_start(file, kMostBytes + 1);
      if (bytes.size() > kMostBytes) {
        faults_.error(place, "too-large", fmt::format("more than {} bytes", kMostBytes));
        return std::nullopt;
      }
      return NpyArray::parse(std::move(bytes));
    } catch (const InvalidInput& damaged) {
      for (Diagnostic fault : damaged.diagnostics()) {
        fault.file = faults_.file();
        fault.where = place.text();
        faults_.add(std::move(fault));
      }
    } catch (const FileError&) {
      throw;
    } catch (const Error& wrong) {
      faults_.error(place, "bad-array", wrong.what());
    }
    return std::nullopt;
  }

  // Whether an array is a list of rows of `width` elements, as many as there are snapshots.
  bool fits(std::string_view name, const NpyArray& array, std::size_t width) {
    const Path place(root_, name);
    const auto& shape = array.shape();
    // By division: a first size beside a 0 may be so large that a product overflows.
    const bool rows = !shape.empty() && shape[0] > 0 && array.size() % width == 0 &&
                      array.size() / width == shape[0] &&
                      (shape.size() <= 2 || (width == kMatrix && shape[1] == 4));
    if (!rows) {
      faults_.error(place, "wrong-shape",
                    fmt::format("shape {}, not (n, {}) with n from 1", array.shape_text(), width));
      return false;
    }
    if (shape[0] > kMostSnapshots) {
      faults_.error(place, "too-large",
                    fmt::format("{} snapshots; {} at most are read", shape[0], kMostSnapshots));
      return false;
    }
    if (!sized_) {
      trace_.snapshots.resize(shape[0]);
      sized_ = true;
    }
    if (shape[0] == trace_.snapshots.size()) return true;
    faults_.error(place, "other-length",
                  fmt::format("{} snapshots, where the arrays before have {}", shape[0],
                              trace_.snapshots.size()));
    return false;
  }

  bool is_number(std::string_view name, const NpyArray& array) {
    if (array.is_number() && array.kind() != NpyKind::kBool) return true;
    faults_.error(Path(root_, name), "wrong-type",
                  fmt::format("elements of type {}, not numbers", quote(array.type())));
    return false;
  }

  std::optional<double> finite(const NpyArray& array, std::size_t i, const Path& place) {
    const double value = array.number(i);
    if (std::isfinite(value)) return value;
    faults_.error(place, "not-finite", fmt::format("{}, not a finite number", value));
    return std::nullopt;
  }

  std::optional<float> float_at(const NpyArray& array, std::size_t i, const Path& place,
                                double most = std::numeric_limits<float>::max()) {
    const auto value = finite(array, i, place);
    if (!value) return std::nullopt;
    if (std::abs(*value) <= most) return static_cast<float>(*value);
    faults_.error(place, "too-large", fmt::format("{}, beyond {}", *value, most));
    return std::nullopt;
  }

  void read_panos(const Found& array) {
    if (!array) return;
    const Path list(root_, "pano");
    if (!array->is_text()) {
      faults_.error(list, "wrong-type",
                    fmt::format("elements of type {}, not texts", quote(array->type())));
      return;
    }
    if (!fits("pano", *array, 1)) return;
    for (std::size_t i = 0; i < array->size() && !faults_.full(); ++i) {
      std::string& viewpoint = trace_.snapshots[i].viewpoint;
      viewpoint = array->text(i);
      if (std::string fault = fault_of_id(viewpoint); !fault.empty()) {
        faults_.error(Path(list, i), "bad-id", std::move(fault));
      }
    }
  }

  void read_times(const Found& array) {
    if (!array || !is_number("time", *array) || !fits("time", *array, 1)) return;
    const Path list(root_, "time");
    double before = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < array->size() && !faults_.full(); ++i) {
      const Path place(list, i);
      if (i == 0 && std::isnan(array->number(0))) {  // 0, as in the data set's viewer
        before = 0;
        continue;
      }
      const auto time = finite(*array, i, place);
      if (!time) continue;
      trace_.snapshots[i].time = *time;
      if (*time < before) {
        faults_.error(place, "goes-back", fmt::format("{} s, after {} s", *time, before));
      }
      before = *time;
    }
  }

  void read_heard(const NpyArray& array) {
    if (!is_number("audio_time", array) || !fits("audio_time", array, 1)) return;
    const Path list(root_, "audio_time");
    for (std::size_t i = 0; i < array.size() && !faults_.full(); ++i) {
      trace_.snapshots[i].audio_time = finite(array, i, Path(list, i));
    }
  }

  void read_matrices(std::string_view name, const Found& array,
                     std::array<float, kMatrix> PoseSnapshot::*matrix) {
    if (!array || !is_number(name, *array) || !fits(name, *array, kMatrix)) return;
    const Path list(root_, name);
    for (std::size_t i = 0; i < array->size() && !faults_.full(); ++i) {
      const std::size_t row = i / kMatrix, k = i % kMatrix;
      const Path place(list, row);
      const auto value = float_at(*array, i, Path(place, k), kMostMetres);
      if (value) (trace_.snapshots[row].*matrix)[k] = *value;
    }
  }

  // What belongs to the path's viewpoints.
  void read_of_viewpoints() {
    if (const auto masks = array("image_mask", Need::kOptional)) {
      if (is_mask("image_mask", *masks, {kMaskHeight, kMaskWidth})) {
        trace_.image_mask = bools_of(*masks);
      }
    }
    if (const auto weights = array("feature_weights", Need::kOptional)) read_weights(*weights);
    // The data set's page has the first name, files of some mirrors the second.
    for (const char* name : {"text_mask", "text_masks"}) {
      const auto masks = array(name, Need::kOptional);
      if (!masks || !is_mask(name, *masks, {0})) continue;
      trace_.text_mask = bools_of(*masks);
      trace_.subwords = masks->shape()[1];
      break;
    }
  }

  void read_weights(const NpyArray& array) {
    if (!is_number("feature_weights", array) || !has_shape("feature_weights", array, {kMaskViews}))
      return;
    const Path list(root_, "feature_weights");
    trace_.feature_weights.assign(array.size(), 0);
    for (std::size_t i = 0; i < array.size() && !faults_.full(); ++i) {
      const Path row(list, i / kMaskViews);
      const auto value = float_at(array, i, Path(row, i % kMaskViews));
      if (value) trace_.feature_weights[i] = *value;
    }
  }

  // Masks may have been saved as bools or numbers.
  bool is_mask(std::string_view name, const NpyArray& array, std::vector<std::size_t> row) {
    if (array.is_number()) return has_shape(name, array, std::move(row));
    faults_.error(Path(root_, name), "wrong-type",
                  fmt::format("elements of type {}, not bools", quote(array.type())));
    return false;
  }

  // \param row  the shape behind the number of viewpoints; 0: any size but 0
  bool has_shape(std::string_view name, const NpyArray& array, std::vector<std::size_t> row) {
    const auto& shape = array.shape();
    bool same = shape.size() == row.size() + 1 && shape[0] > 0;
    for (std::size_t d = 0; same && d < row.size(); ++d) {
      same = row[d] == 0 ? shape[d + 1] > 0 : shape[d + 1] == row[d];
    }
    const Path place(root_, name);
    if (!same) {
      std::string wanted = "k";
      for (const std::size_t one : row) {
        wanted += one == 0 ? ", m" : fmt::format(", {}", one);
      }
      faults_.error(
          place, "wrong-shape",
          fmt::format("shape {}, not ({}) with sizes from 1", array.shape_text(), wanted));
      return false;
    }
    if (trace_.viewpoints == 0) trace_.viewpoints = shape[0];
    if (shape[0] == trace_.viewpoints) return true;
    faults_.error(
        place, "other-length",
        fmt::format("{} viewpoints, where the arrays before have {}", shape[0], trace_.viewpoints));
    return false;
  }

  static std::vector<std::uint8_t> bools_of(const NpyArray& array) {
    std::vector<std::uint8_t> bools(array.size());
    for (std::size_t i = 0; i < bools.size(); ++i) bools[i] = array.number(i) != 0 ? 1 : 0;
    return bools;
  }

  const scan::FileTree& tree_;
  Faults faults_;
  const Path root_;
  PoseTrace trace_;
  bool sized_ = false;
};

void check_sizes(const PoseTrace& trace) {
  const auto check = [](std::string_view name, std::size_t size, std::size_t wanted) {
    if (size == 0 || size == wanted) return;
    throw ArgumentError(fmt::format("{} of a pose trace: {} elements, not {}", name, size, wanted));
  };
  if (trace.snapshots.empty()) throw ArgumentError("a pose trace without a snapshot");
  check("image_mask", trace.image_mask.size(), trace.viewpoints * kMaskHeight * kMaskWidth);
  check("feature_weights", trace.feature_weights.size(), trace.viewpoints * kMaskViews);
  check("text_mask", trace.text_mask.size(), trace.viewpoints * trace.subwords);
  const auto heard = static_cast<std::size_t>(std::ranges::count_if(
      trace.snapshots, [](const PoseSnapshot& one) { return one.audio_time.has_value(); }));
  check("audio_time", heard, trace.snapshots.size());
}

template <class Value>
std::string vector_of(const PoseTrace& trace, const Value& value) {
  std::vector<float> values;
  for (const PoseSnapshot& one : trace.snapshots) values.push_back(static_cast<float>(value(one)));
  return scan::write_npy(values, {values.size(), 1});
}

std::string matrices_of(const PoseTrace& trace, std::array<float, kMatrix> PoseSnapshot::*matrix) {
  std::vector<float> values;
  for (const PoseSnapshot& one : trace.snapshots) {
    values.insert(values.end(), (one.*matrix).begin(), (one.*matrix).end());
  }
  return scan::write_npy(values, {trace.snapshots.size(), kMatrix});
}

std::string panos_of(const PoseTrace& trace) {
  std::vector<std::string> panos;
  for (const PoseSnapshot& one : trace.snapshots) panos.push_back(one.viewpoint);
  return scan::write_npy(panos, {panos.size(), 1});
}

}  // namespace

std::string pose_trace_name(TraceRole role, std::int64_t id) {
  return fmt::format("{:06}_{}_pose_trace.npz", id,
                     role == TraceRole::kGuide ? "guide" : "follower");
}

PoseTrace load_pose_trace(const std::filesystem::path& file) {
  return parse_pose_trace(read_file(file), file.string());
}

PoseTrace parse_pose_trace(std::string bytes, const std::string& name) {
  const auto tree = scan::FileTree::zip_in_memory(std::move(bytes), name);
  return TraceReader(*tree, name).read();
}

std::string to_npz(const PoseTrace& trace) {
  check_sizes(trace);
  std::vector<scan::ZipEntry> entries;
  const auto add = [&entries](const char* name, std::string npy) {
    entries.push_back({fmt::format("{}.npy", name), std::move(npy)});
  };
  add("pano", panos_of(trace));
  add("time", vector_of(trace, [](const PoseSnapshot& one) { return one.time; }));
  if (trace.snapshots[0].audio_time) {
    add("audio_time", vector_of(trace, [](const PoseSnapshot& one) { return *one.audio_time; }));
  }
  add("extrinsic_matrix", matrices_of(trace, &PoseSnapshot::extrinsic));
  add("intrinsic_matrix", matrices_of(trace, &PoseSnapshot::intrinsic));
  const std::size_t k = trace.viewpoints;
  if (!trace.image_mask.empty()) {
    add("image_mask", scan::write_npy(trace.image_mask, {k, kMaskHeight, kMaskWidth}));
  }
  if (!trace.text_mask.empty()) {
    add("text_mask", scan::write_npy(trace.text_mask, {k, trace.subwords}));
  }
  if (!trace.feature_weights.empty()) {
    add("feature_weights", scan::write_npy(trace.feature_weights, {k, kMaskViews}));
  }
  std::string bytes = scan::zip(entries);
  try {
    parse_pose_trace(bytes, "the pose trace");
  } catch (const InvalidInput& refused) {
    throw ArgumentError(refused.what());
  }
  return bytes;
}

CameraLook look_of(const PoseSnapshot& snapshot) {
  const auto& m = snapshot.extrinsic;
  CameraLook look;
  look.position = {m[3], -m[11], m[7]};
  // The camera looks along -z: minus the third column, in our frame.
  const Vec3d along{-m[2], m[10], -m[6]};
  const double level = std::hypot(along.x, along.y);
  if (level > 0) look.heading = wrap_heading(Radians(std::atan2(along.x, along.y)));
  if (level > 0 || along.z != 0) look.elevation = Radians(std::atan2(along.z, level));
  const double up = snapshot.intrinsic[5], right = snapshot.intrinsic[0];
  look.view_angle = Radians(2 * std::atan2(1, up));
  look.aspect = right != 0 ? up / right : 1;
  return look;
}

PoseSnapshot snapshot_of(std::string viewpoint, double time, const CameraLook& look) {
  EN_CHECK(look.view_angle.value > 0 && look.view_angle.value < kPi && look.aspect > 0);
  PoseSnapshot snapshot;
  snapshot.viewpoint = std::move(viewpoint);
  snapshot.time = time;
  const double sh = std::sin(look.heading.value), ch = std::cos(look.heading.value);
  const double se = std::sin(look.elevation.value), ce = std::cos(look.elevation.value);
  const Vec3d right{ch, -sh, 0}, along{sh * ce, ch * ce, se};
  const Vec3d up = cross(right, along);
  const auto column = [&snapshot](std::size_t k, Vec3d ours) {
    // To the frame whose y is up.
    snapshot.extrinsic[k] = static_cast<float>(ours.x);
    snapshot.extrinsic[4 + k] = static_cast<float>(ours.z);
    snapshot.extrinsic[8 + k] = static_cast<float>(-ours.y);
  };
  column(0, right);
  column(1, up);
  column(2, -along);
  column(3, look.position);
  snapshot.extrinsic[15] = 1;
  constexpr double kNear = 0.1, kFar = 1000;
  const double focal = 1 / std::tan(look.view_angle.value / 2);
  snapshot.intrinsic[0] = static_cast<float>(focal / look.aspect);
  snapshot.intrinsic[5] = static_cast<float>(focal);
  snapshot.intrinsic[10] = static_cast<float>((kFar + kNear) / (kNear - kFar));
  snapshot.intrinsic[11] = static_cast<float>(2 * kFar * kNear / (kNear - kFar));
  snapshot.intrinsic[14] = -1;
  return snapshot;
}

}  // namespace enfilade::tasks
