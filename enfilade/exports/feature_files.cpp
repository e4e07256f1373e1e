#include "enfilade/exports/feature_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/half.h"
#include "enfilade/core/rng.h"
#include "enfilade/exports/detail/scan_parts.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/features/tensor_file.h"
#include "enfilade/geometry/cube_map.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::exports {
namespace {

namespace fs = std::filesystem;
using features::FeatureSet;
using features::Hdf5Attribute;
using features::Hdf5Type;
using graph::NavGraph;
using Graphs = std::shared_ptr<const graph::GraphSet>;

constexpr std::size_t kViews = 36;
constexpr Camera kReverieCamera;  // of the boxes: 640 x 480, 60 degrees

/// Calls `has(graph, v)` for all included viewpoints. \throws LookupError for those it denies
template <class Has>
void require_all(const graph::GraphSet& graphs, const fs::path& file, const Has& has) {
  std::size_t total = 0;
  std::size_t missing = 0;
  std::string first;
  for (std::size_t i = 0; i < graphs.size(); ++i) {
    const NavGraph& graph = graphs.graph(ScanIndex(i));
    for (const ViewpointIndex v : detail::included(graph)) {
      ++total;
      if (has(graph, v)) continue;
      if (missing++ == 0) first = graph.scan() + "_" + graph.id(v);
    }
  }
  if (missing == 0) return;
  throw LookupError(fmt::format("{}: {} of {} viewpoints are not in it, the first: {}",
                                file.string(), missing, total, first));
}

/// Features of 36 views of every viewpoint of the graphs.
FeatureSet open_views(const graph::GraphSet& graphs, const fs::path& file) {
  FeatureSet set = FeatureSet::open(file);
  if (set.info().views != kViews) {
    refuse(file.string(), "", "bad-shape",
           fmt::format("{} views of a viewpoint; {} are wanted", set.info().views, kViews));
  }
  require_all(graphs, file, [&](const NavGraph& graph, ViewpointIndex v) {
    return set.row(graph.scan(), graph.id(v)).has_value();
  });
  return set;
}

/// Views' features, with the classes beside them if there are any.
class Columns {
 public:
  Columns(const graph::GraphSet& graphs, const FeatureSource& source)
      : views_(open_views(graphs, source.features)) {
    if (!source.logits.empty()) logits_.emplace(open_views(graphs, source.logits));
    columns_ = views_.info().dimensions + (logits_ ? logits_->info().dimensions : 0);
    numbers_.resize(kViews * columns_);
  }

  std::size_t columns() const noexcept { return columns_; }
  const Camera& camera() const noexcept { return views_.info().camera; }

  /// (36, columns), valid until the next call.
  std::span<const float> of(const std::string& scan, const std::string& viewpoint) {
    const std::size_t width = views_.info().dimensions;
    const std::size_t row = views_.row(scan, viewpoint).value();
    for (std::size_t view = 0; view < kViews; ++view) {
      const std::span<float> out = std::span(numbers_).subspan(view * columns_, columns_);
      views_.copy_view(row, view, out.first(width));
      if (logits_) {
        logits_->copy_view(logits_->row(scan, viewpoint).value(), view, out.subspan(width));
      }
    }
    return numbers_;
  }

 private:
  FeatureSet views_;
  std::optional<FeatureSet> logits_;
  std::size_t columns_ = 0;
  std::vector<float> numbers_;
};

/// Memory for numbers of one type.
class StoredNumbers {
 public:
  /// \throws ArgumentError unless it is kFloat16, kFloat32 or kFloat64
  explicit StoredNumbers(Hdf5Type type) : type_(type) {
    if (type != Hdf5Type::kFloat16 && type != Hdf5Type::kFloat32 && type != Hdf5Type::kFloat64) {
      throw ArgumentError("type of features: floats of 16, 32 or 64 bits are allowed");
    }
  }
  Hdf5Type type() const noexcept { return type_; }

  /// Valid until the next call, and as long as `numbers`. \throws ArgumentError naming `where`, for
  /// a number that is too large for the type
  std::span<const std::byte> store(std::span<const float> numbers, const std::string& where) {
    if (type_ == Hdf5Type::kFloat32) return std::as_bytes(numbers);
    if (type_ == Hdf5Type::kFloat64) {
      doubles_.assign(numbers.begin(), numbers.end());
      return std::as_bytes(std::span(doubles_));
    }
    halves_.resize(numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      halves_[i] = to_half(numbers[i]);
      if ((halves_[i] & 0x7c00U) == 0x7c00U) {
        throw ArgumentError(
            fmt::format("{}: {} is no number of 16 bits; 32 would hold it", where, numbers[i]));
      }
    }
    return std::as_bytes(std::span(halves_));
  }

 private:
  Hdf5Type type_;
  std::vector<std::uint16_t> halves_;
  std::vector<double> doubles_;
};

std::string job_of(const char* what, const FeatureSource& source) {
  return fmt::format("{}\n{}\n{}\ntype {}\n", what, detail::state_of(source.features),
                     source.logits.empty() ? "no logits" : detail::state_of(source.logits),
                     static_cast<int>(source.type));
}

// --- objects ---

/// The places of an object's boxes, the largest first.
std::vector<std::size_t> by_size(const tasks::ViewedObject& object) {
  std::vector<std::size_t> order(object.boxes.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, std::greater<>(), [&](std::size_t i) {
    return std::int64_t{object.boxes[i][2]} * object.boxes[i][3];
  });
  return order;
}

/// Heading and elevation of the middle of a box in a view.
std::array<float, 2> direction_of(std::uint8_t view, const std::array<std::int32_t, 4>& box) {
  const Mat3d world_from_camera_frame = world_from_camera(
      degrees(30.0 * (view % 12)), degrees(30.0 * (static_cast<int>(view / 12) - 1)));
  // Pixel centres are whole numbers here, and half a pixel from the box's edges.
  const Vec3d ray = pixel_rays(kReverieCamera, world_from_camera_frame)
                        .at(box[1] + (box[3] - 1) / 2.0, box[0] + (box[2] - 1) / 2.0);
  const double heading = wrap_heading(Radians(std::atan2(ray.x, ray.y))).value;
  return {static_cast<float>(heading), static_cast<float>(std::asin(ray.z / length(ray)))};
}

/// What a viewpoint's dataset holds.
struct ObjectRows {
  std::vector<float> features, directions, sizes;
  std::vector<std::int64_t> boxes, views;
  std::vector<std::string> ids;

  void add(const tasks::ViewedObject& object, std::span<const float> of_views,
           std::size_t columns) {
    const std::vector<std::size_t> order = by_size(object);
    const std::array<std::int32_t, 4>& box = object.boxes[order[0]];
    add_mean(object, order, of_views, columns);
    const std::array<float, 2> direction = direction_of(object.views[order[0]], box);
    directions.insert(directions.end(), direction.begin(), direction.end());
    sizes.insert(sizes.end(), {static_cast<float>(box[2]), static_cast<float>(box[3])});
    boxes.insert(boxes.end(), box.begin(), box.end());
    views.push_back(object.views[order[0]]);
    ids.push_back(std::to_string(object.id));
  }

 private:
  void add_mean(const tasks::ViewedObject& object, const std::vector<std::size_t>& order,
                std::span<const float> of_views, std::size_t columns) {
    constexpr std::size_t kMostViews = 3;
    const std::size_t count = std::min(order.size(), kMostViews);
    for (std::size_t column = 0; column < columns; ++column) {
      double sum = 0;
      for (std::size_t k = 0; k < count; ++k) {
        sum += of_views[object.views[order[k]] * columns + column];
      }
      features.push_back(static_cast<float>(sum / static_cast<double>(count)));
    }
  }
};

template <class T>
features::Hdf5Array array_of(Hdf5Type type, std::vector<std::uint64_t> shape,
                             const std::vector<T>& numbers) {
  return {type, std::move(shape), std::as_bytes(std::span(numbers))};
}

void write_rows(features::Hdf5Writer& part, const std::string& name, const ObjectRows& rows,
                std::size_t columns, StoredNumbers& stored, std::vector<Hdf5Attribute> attributes) {
  const std::uint64_t n = rows.ids.size();
  attributes.push_back({"directions", array_of(Hdf5Type::kFloat32, {n, 2}, rows.directions)});
  attributes.push_back({"sizes", array_of(Hdf5Type::kFloat32, {n, 2}, rows.sizes)});
  attributes.push_back({"bboxes", array_of(Hdf5Type::kInt64, {n, 4}, rows.boxes)});
  attributes.push_back({"viewindexs", array_of(Hdf5Type::kInt64, {n}, rows.views)});
  attributes.push_back({"obj_ids", rows.ids});
  part.write({name,
              {stored.type(), {n, columns}, stored.store(rows.features, name)},
              std::move(attributes)});
}

// --- tokens ---

std::vector<std::uint16_t> halves_of(const features::NamedArray& array, const fs::path& file) {
  std::vector<float> numbers(array.elements());
  bool finite = false;
  if (array.type == features::DType::kFloat32) {
    finite = copy_floats(array.bytes.data(), numbers);
  } else if (array.type == features::DType::kFloat16) {
    finite = copy_halves(array.bytes.data(), numbers);
  } else {
    refuse(file.string(), array.name, "unsupported-type",
           fmt::format("{}; floats of 16 or 32 bits are read", enum_name(array.type)));
  }
  std::vector<std::uint16_t> halves(numbers.size());
  std::ranges::transform(numbers, halves.begin(), to_half);
  if (!finite || std::ranges::any_of(halves, [](auto h) { return (h & 0x7c00U) == 0x7c00U; })) {
    refuse(file.string(), array.name, "not-finite", "a number that is no finite one of 16 bits");
  }
  return halves;
}

void check_tokens(const features::NamedArray& array, const TokenShape& wanted,
                  const fs::path& file) {
  if (array.shape.size() == 3 && array.shape[1] == wanted.tokens && array.shape[2] > 0 &&
      std::ranges::find(wanted.views, array.shape[0]) != wanted.views.end()) {
    return;
  }
  refuse(file.string(), array.name, "bad-shape",
         fmt::format("shape {}; {} views of {} tokens are wanted", fmt::join(array.shape, " "),
                     fmt::join(wanted.views, " or "), wanted.tokens));
}

}  // namespace

void write_view_features(const Graphs& graphs, const FeatureSource& source, const fs::path& file,
                         const ExportOptions& options) {
  StoredNumbers stored(source.type);
  Columns columns(*graphs, source);
  detail::write_by_scan(
      *graphs, file, job_of("views", source), options,
      [&](features::Hdf5Writer& part, ScanIndex scan, ViewpointIndex v, const std::string& name) {
        const NavGraph& graph = graphs->graph(scan);
        const std::span<const float> numbers = columns.of(graph.scan(), graph.id(v));
        part.write({name,
                    {stored.type(), {kViews, columns.columns()}, stored.store(numbers, name)},
                    detail::view_attributes(graph.scan(), graph.id(v), columns.camera())});
      });
}

void write_object_features(const Graphs& graphs, const tasks::ObjectBoxes& boxes,
                           const FeatureSource& source, const fs::path& file, std::size_t most,
                           const ExportOptions& options) {
  check_range("most", static_cast<double>(most), 1, 1000);
  StoredNumbers stored(source.type);
  Columns columns(*graphs, source);
  const std::string all = boxes.to_json(false);
  const std::string job = fmt::format("{}objects {:016x} {}\n", job_of("objects", source),
                                      stream_of(all.data(), all.size()), most);
  detail::write_by_scan(
      *graphs, file, job, options,
      [&](features::Hdf5Writer& part, ScanIndex scan, ViewpointIndex v, const std::string& name) {
        const NavGraph& graph = graphs->graph(scan);
        ObjectRows rows;
        std::span<const float> numbers;
        for (const tasks::ViewedObject& object : boxes.at(graph.scan(), graph.id(v))) {
          if (!object.visible() || rows.ids.size() == most) continue;
          if (numbers.empty()) numbers = columns.of(graph.scan(), graph.id(v));
          rows.add(object, numbers, columns.columns());
        }
        if (rows.ids.empty()) return;
        write_rows(part, name, rows, columns.columns(), stored,
                   detail::view_attributes(graph.scan(), graph.id(v), kReverieCamera));
      });
}

TokenShape bevbert_tokens() { return {{12}, 196}; }
TokenShape gridmm_tokens() { return {{12, 36}, 50}; }

void write_tokens(const Graphs& graphs, const fs::path& tokens, const TokenShape& shape,
                  const fs::path& file, const ExportOptions& options) {
  const features::TensorFile arrays = features::TensorFile::open(tokens);
  require_all(*graphs, tokens, [&](const NavGraph& graph, ViewpointIndex v) {
    return arrays.find(graph.scan() + "_" + graph.id(v)) != nullptr;
  });
  detail::write_by_scan(*graphs, file, "tokens\n" + detail::state_of(tokens) + "\n", options,
                        [&](features::Hdf5Writer& part, ScanIndex /*scan*/,
                            ViewpointIndex /*viewpoint*/, const std::string& name) {
                          const features::NamedArray& array = *arrays.find(name);
                          check_tokens(array, shape, tokens);
                          const std::vector<std::uint16_t> halves = halves_of(array, tokens);
                          part.write({name,
                                      {Hdf5Type::kFloat16,
                                       {array.shape.begin(), array.shape.end()},
                                       std::as_bytes(std::span(halves))},
                                      {}});
                        });
}

}  // namespace enfilade::exports
