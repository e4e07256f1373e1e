#include "enfilade/capture/object_boxes.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/threads.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::capture {
namespace {

constexpr int kWidth = 640, kHeight = 480, kHeadings = 12, kViews = 36;
constexpr double kStep = kPi / 6;  // from view to view, both ways
constexpr double kHighest = kPi / 3;
// Pixels from the centre of a picture for a tangent of 1.
const double kFocal = kHeight / 2.0 / std::tan(kPi / 6);

// A picture's camera.
struct View {
  Vec3d forward, right, up;
};

View view_of(int index) {
  const double heading = kStep * (index % kHeadings), elevation = kStep * (index / kHeadings - 1);
  const double s = std::sin(heading), c = std::cos(heading);
  const double se = std::sin(elevation), ce = std::cos(elevation);
  return {{s * ce, c * ce, se}, {c, -s, 0}, {-s * se, -c * se, ce}};
}

const std::array<View, kViews>& views() {
  static const std::array<View, kViews> kAll = [] {
    std::array<View, kViews> all;
    for (int i = 0; i < kViews; ++i) all[static_cast<std::size_t>(i)] = view_of(i);
    return all;
  }();
  return kAll;
}

Vec3d direction_of(double heading, double elevation) {
  return {std::sin(heading) * std::cos(elevation), std::cos(heading) * std::cos(elevation),
          std::sin(elevation)};
}

// What is seen of an object in one view, pixels.
struct Frame {
  double pixels = 0;
  double x0 = kWidth, y0 = kHeight, x1 = 0, y1 = 0;

  void add(double px0, double py0, double px1, double py1, double area) {
    pixels += area;
    x0 = std::min(x0, px0);
    y0 = std::min(y0, py0);
    x1 = std::max(x1, px1);
    y1 = std::max(y1, py1);
  }
};

// What is seen of an object.
struct Seen {
  bool any = false;
  double distance = std::numeric_limits<double>::infinity();
  double solid_angle = 0;
  Vec3d sum;                   // of directions, by their solid angles
  double first = 0;            // heading of the first ray that met it
  double left = 0, right = 0;  // against it
  double bottom = kPi, top = -kPi;
  std::array<Frame, kViews> frames;

  void add(double heading, double elevation, double half, double area, double far) {
    if (!any) first = heading;
    any = true;
    distance = std::min(distance, far);
    solid_angle += area;
    sum += area * direction_of(heading, elevation);
    const double beside = std::remainder(heading - first, 2 * kPi);
    left = std::min(left, beside - half);
    right = std::max(right, beside + half);
    bottom = std::min(bottom, elevation - half);
    top = std::max(top, elevation + half);
  }
};

// Collects what rays from a point meet.
class Looker {
 public:
  Looker(const mesh::RayTracer& tracer, Vec3f eye, const ObjectBoxOptions& options)
      : tracer_(tracer),
        eye_(eye),
        options_(options),
        place_(tracer.mesh().objects.size(), kNone) {}

  std::vector<ObjectInView> look() {
    if (options_.around == 0) {
      for (int view = 0; view < kViews; ++view) look_into(view);
    } else {
      look_around();
    }
    std::vector<ObjectInView> found;
    for (std::size_t object = 0; object < place_.size(); ++object) {
      if (place_[object] == kNone) continue;
      const Seen& seen = seen_[place_[object]];
      if (seen.distance > options_.farthest) continue;
      found.push_back(of(static_cast<std::uint32_t>(object), seen));
    }
    return found;
  }

 private:
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  // What a ray met; nullptr if it is no object.
  Seen* at(const mesh::Hit& hit) {
    const mesh::Mesh& mesh = tracer_.mesh();
    if (!hit) return nullptr;
    const std::uint32_t object = mesh.triangle_object[hit.triangle];
    if (object >= place_.size()) return nullptr;
    if (place_[object] == kNone) {
      if (std::ranges::count(options_.left_out, mesh.objects[object].category) > 0) return nullptr;
      place_[object] = seen_.size();
      seen_.emplace_back();
    }
    return &seen_[place_[object]];
  }

  // Rays at equal angles, in rows of one elevation.
  void look_around() {
    const auto columns = static_cast<std::size_t>(options_.around);
    const double step = 2 * kPi / static_cast<double>(columns);
    const auto rows = static_cast<std::size_t>(std::lround(2 * kHighest / step));
    std::vector<mesh::Ray> rays(columns);
    std::vector<mesh::Hit> hits(columns);
    for (std::size_t row = 0; row < rows; ++row) {
      const double elevation = kHighest - (static_cast<double>(row) + 0.5) * step;
      for (std::size_t k = 0; k < columns; ++k) {
        const double heading = (static_cast<double>(k) + 0.5) * step;
        rays[k] = {eye_, to_float(direction_of(heading, elevation))};
      }
      tracer_.trace(rays, hits);
      for (std::size_t k = 0; k < columns; ++k) {
        Seen* const seen = at(hits[k]);
        if (seen == nullptr) continue;
        const double heading = (static_cast<double>(k) + 0.5) * step;
        seen->add(heading, elevation, step / 2, step * step * std::cos(elevation),
                  static_cast<double>(hits[k].distance));
        frame(*seen, heading, elevation, step);
      }
    }
  }

  // Adds a piece of the sphere to the pictures that show its middle.
  static void frame(Seen& seen, double heading, double elevation, double step) {
    const Vec3d middle = direction_of(heading, elevation);
    const int nearest = static_cast<int>(std::lround(heading / kStep));
    for (int turn = nearest - 2; turn <= nearest + 2; ++turn) {
      const int column = (turn + kHeadings) % kHeadings;
      for (int row = 0; row < 3; ++row) {
        const std::size_t index =
            static_cast<std::size_t>(row) * kHeadings + static_cast<std::size_t>(column);
        const View& view = views()[index];
        const double ahead = dot(middle, view.forward);
        if (ahead < 0.5) continue;  // the corners of a picture are at 50 degrees
        const double x = kFocal * dot(middle, view.right) / ahead + kWidth / 2.0;
        const double y = kHeight / 2.0 - kFocal * dot(middle, view.up) / ahead;
        if (x < 0 || x >= kWidth || y < 0 || y >= kHeight) continue;
        const double scale = kFocal * step / ahead, half = scale / 2;
        const double flat = std::cos(elevation);
        seen.frames[index].add(x - half * std::min(1.0, flat / ahead), y - half,
                               x + half * std::min(1.0, flat / ahead), y + half,
                               scale * scale * flat / ahead);
      }
    }
  }

  // A ray through each pixel of a view.
  void look_into(int index) {
    const View& view = views()[static_cast<std::size_t>(index)];
    std::vector<mesh::Ray> rays(kWidth);
    std::vector<mesh::Hit> hits(kWidth);
    for (int row = 0; row < kHeight; ++row) {
      for (int k = 0; k < kWidth; ++k) {
        rays[static_cast<std::size_t>(k)] = {eye_, to_float(through(view, k, row))};
      }
      tracer_.trace(rays, hits);
      for (int k = 0; k < kWidth; ++k) {
        Seen* const seen = at(hits[static_cast<std::size_t>(k)]);
        if (seen == nullptr) continue;
        const Vec3d d = through(view, k, row);
        const double far = length(d);  // of the pixel, in focal lengths
        const double heading = std::atan2(d.x, d.y), elevation = std::asin(d.z / far);
        // Several views show a direction: the one nearest to it counts for shares.
        const double area =
            is_nearest(index, heading, elevation) ? 1 / (kFocal * kFocal * far * far * far) : 0;
        seen->add(heading, elevation, 0.5 / kFocal, area,
                  static_cast<double>(hits[static_cast<std::size_t>(k)].distance) * far);
        seen->frames[static_cast<std::size_t>(index)].add(k, row, k + 1, row + 1, 1);
      }
    }
  }

  static bool is_nearest(int view, double heading, double elevation) {
    const int column = (static_cast<int>(std::lround(heading / kStep)) + kHeadings) % kHeadings;
    const int row = std::clamp(static_cast<int>(std::lround(elevation / kStep)) + 1, 0, 2);
    return view == row * kHeadings + column;
  }

  static Vec3d through(const View& view, int column, int row) {
    return view.forward + ((column + 0.5 - kWidth / 2.0) / kFocal) * view.right +
           ((kHeight / 2.0 - row - 0.5) / kFocal) * view.up;
  }

  ObjectInView of(std::uint32_t object, const Seen& seen) const {
    ObjectInView result;
    result.object = object;
    result.distance = seen.distance;
    result.share = std::min(1.0, seen.solid_angle / (4 * kPi));
    result.left = wrap_heading(Radians(seen.first + seen.left)).value;
    result.right = wrap_heading(Radians(seen.first + seen.right)).value;
    result.bottom = seen.bottom;
    result.top = seen.top;
    result.middle = {wrap_heading(Radians(std::atan2(seen.sum.x, seen.sum.y))),
                     Radians(std::atan2(seen.sum.z, std::hypot(seen.sum.x, seen.sum.y)))};
    for (std::size_t view = 0; view < seen.frames.size(); ++view) {
      const Frame& f = seen.frames[view];
      if (f.pixels < options_.least_pixels || f.pixels == 0) continue;
      const auto pixel = [](double v, int most) {
        return std::clamp(static_cast<std::int32_t>(std::lround(v)), 0, most);
      };
      const std::int32_t x0 = pixel(f.x0, kWidth - 1), y0 = pixel(f.y0, kHeight - 1);
      result.views.push_back(static_cast<std::uint8_t>(view));
      result.boxes.push_back(
          {x0, y0, std::max(1, pixel(f.x1, kWidth) - x0), std::max(1, pixel(f.y1, kHeight) - y0)});
    }
    return result;
  }

  const mesh::RayTracer& tracer_;
  Vec3f eye_;
  const ObjectBoxOptions& options_;
  std::vector<std::size_t> place_;  // by object: its place in seen_, or kNone
  std::vector<Seen> seen_;
};

void check(const mesh::RayTracer& tracer, const ObjectBoxOptions& options) {
  if (tracer.mesh().triangle_object.empty()) {
    throw ArgumentError("mesh: its triangles belong to no objects");
  }
  if (!(options.farthest > 0)) {
    throw ArgumentError(fmt::format("farthest: {} m, not more than 0", options.farthest));
  }
  if (!(options.least_pixels >= 0)) {
    throw ArgumentError(fmt::format("least_pixels: {}, not 0 or more", options.least_pixels));
  }
  if (options.around != 0 && (options.around < 36 || options.around > 100'000)) {
    throw ArgumentError(
        fmt::format("around: {} rays, neither 0 nor from 36 to 100000", options.around));
  }
}

}  // namespace

std::vector<ObjectInView> objects_in_view(const mesh::RayTracer& tracer, Vec3f eye,
                                          const ObjectBoxOptions& options) {
  check(tracer, options);
  if (!std::isfinite(eye.x) || !std::isfinite(eye.y) || !std::isfinite(eye.z)) {
    throw ArgumentError(fmt::format("eye: ({}, {}, {}), not finite", eye.x, eye.y, eye.z));
  }
  return Looker(tracer, eye, options).look();
}

tasks::ObjectBoxes compute_object_boxes(const mesh::RayTracer& tracer,
                                        const scan::Connectivity& connectivity,
                                        const ObjectBoxOptions& options) {
  check(tracer, options);
  const auto& entries = connectivity.entries;
  std::vector<std::vector<tasks::ViewedObject>> found(entries.size());
  parallel_for(entries.size(), 1, options.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (!entries[i].included) continue;
      for (ObjectInView& seen : objects_in_view(tracer, to_float(entries[i].position()), options)) {
        found[i].push_back({seen.object, tracer.mesh().objects[seen.object].name,
                            std::move(seen.views), std::move(seen.boxes)});
      }
    }
  });
  tasks::ObjectBoxes boxes;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (entries[i].included) boxes.add(connectivity.scan, entries[i].id, std::move(found[i]));
  }
  return boxes;
}

}  // namespace enfilade::capture
