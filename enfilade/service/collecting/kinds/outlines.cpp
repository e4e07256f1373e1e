#include "enfilade/service/collecting/kinds/outlines.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "enfilade/draw/outlines.h"
#include "enfilade/geometry/vec.h"

namespace enfilade::service::collecting::kinds {
namespace {

using nlohmann::ordered_json;

// Of the pictures that boxes are measured in.
constexpr double kHalfWidth = 320, kHalfHeight = 240;
constexpr double kViewStep = std::numbers::pi / 6;  // of headings and of elevations
constexpr int kViewsARow = 12;
// Slack of a product of sines: edges are included in spite of rounding.
constexpr double kSlack = 1e-9;

/// Where a pixel of a view looks.
tasks::Direction direction_of(std::uint8_t view, double x, double y) {
  const double focal = kHalfHeight / std::tan(std::numbers::pi / 6);
  const double heading = kViewStep * (view % kViewsARow);
  const double elevation = kViewStep * (view / kViewsARow - 1);
  const double right = (x - kHalfWidth) / focal, down = (y - kHalfHeight) / focal;
  // In the vertical plane of the view: forward and up.
  const double forward = std::cos(elevation) + down * std::sin(elevation);
  const double up = std::sin(elevation) - down * std::cos(elevation);
  double turned = heading + std::atan2(right, forward);
  turned -= 2 * std::numbers::pi * std::floor(turned / (2 * std::numbers::pi));
  return {Radians(turned), Radians(std::atan2(up, std::hypot(right, forward)))};
}

double area_of(const std::array<std::int32_t, 4>& box) {
  return static_cast<double>(box[2]) * static_cast<double>(box[3]);
}

}  // namespace

Outline outline_of(std::uint8_t view, const std::array<std::int32_t, 4>& box) {
  const double left = box[0], top = box[1], right = left + box[2], bottom = top + box[3];
  return {direction_of(view, left, top), direction_of(view, right, top),
          direction_of(view, right, bottom), direction_of(view, left, bottom)};
}

bool contains(const Outline& outline, const tasks::Direction& direction) {
  const Vec3d point = draw::unit_vector(direction);
  Vec3d middle;
  for (const tasks::Direction& corner : outline) middle += draw::unit_vector(corner);
  if (dot(point, middle) <= 0) return false;  // behind one's back
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const Vec3d edge =
        cross(draw::unit_vector(outline[k]), draw::unit_vector(outline[(k + 1) % outline.size()]));
    if (dot(edge, point) * dot(edge, middle) < -kSlack) return false;
  }
  return true;
}

Outlines outlines_of(const tasks::ObjectBoxes& objects, const std::string& scan,
                     const std::vector<std::string>& viewpoints, std::int64_t object) {
  Outlines outlines;
  for (const std::string& viewpoint : viewpoints) {
    for (const tasks::ViewedObject& one : objects.at(scan, viewpoint)) {
      if (one.id != object || !one.visible()) continue;
      std::vector<std::pair<double, Outline>> found;
      for (std::size_t k = 0; k < one.views.size(); ++k) {
        found.emplace_back(-area_of(one.boxes[k]), outline_of(one.views[k], one.boxes[k]));
      }
      std::ranges::stable_sort(found, {}, &std::pair<double, Outline>::first);
      auto& list = outlines[viewpoint];
      for (auto& [size, outline] : found) list.push_back(outline);
    }
  }
  return outlines;
}

std::string outlines_json(const Outlines& outlines) {
  const auto rounded = [](Radians angle) { return std::round(angle.value * 1e5) / 1e5; };
  ordered_json out = ordered_json::object();
  for (const auto& [viewpoint, list] : outlines) {
    auto& entry = out[viewpoint] = ordered_json::array();
    for (const Outline& outline : list) {
      auto corners = ordered_json::array();
      for (const tasks::Direction& corner : outline) {
        corners.push_back({rounded(corner.heading), rounded(corner.elevation)});
      }
      entry.push_back(std::move(corners));
    }
  }
  return out.dump();
}

Outlines parse_outlines(const std::string& json) {
  Outlines outlines;
  if (json.empty()) return outlines;
  const auto read = ordered_json::parse(json);
  for (const auto& [viewpoint, list] : read.items()) {
    for (const auto& corners : list) {
      Outline outline;
      for (std::size_t k = 0; k < outline.size(); ++k) {
        outline[k] = {Radians(corners.at(k).at(0).get<double>()),
                      Radians(corners.at(k).at(1).get<double>())};
      }
      outlines[viewpoint].push_back(outline);
    }
  }
  return outlines;
}

std::optional<std::int64_t> object_at(const tasks::ObjectBoxes& objects, const std::string& scan,
                                      const std::string& viewpoint,
                                      const tasks::Direction& direction) {
  std::optional<std::int64_t> found;
  double least = std::numeric_limits<double>::infinity();
  for (const tasks::ViewedObject& one : objects.at(scan, viewpoint)) {
    for (std::size_t k = 0; k < one.views.size(); ++k) {
      const double area = area_of(one.boxes[k]);
      if (area >= least || !contains(outline_of(one.views[k], one.boxes[k]), direction)) continue;
      least = area;
      found = one.id;
    }
  }
  return found;
}

std::string category_of(const std::string& name) { return name.substr(0, name.find('#')); }

}  // namespace enfilade::service::collecting::kinds
