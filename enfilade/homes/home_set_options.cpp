#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>

#include "enfilade/core/enum_names.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/homes/sets/home_list.h"
#include "enfilade/tasks/path_sampling.h"

namespace enfilade::homes {

HomeSetOptions home_set_preset(std::string_view name) {
  HomeSetOptions o;
  if (name == "small") {
    o.homes = 2;
    o.kind = HomeKind::kFlat;
    o.least_area = o.most_area = kLeastArea;
    o.face_size = 64;
    o.samples = 1;
  } else if (name == "full") {
    o.homes = 90;
    o.least_area = 350;
    o.most_area = 850;
    o.face_size = 512;
  } else if (name == "pretty" || name == "demo" || name == "graphs" || name == "training") {
    o.least_area = 85;
    o.most_area = 100;
    o.stairs_every = 8;
  } else {
    throw ArgumentError(
        fmt::format("preset: {:?} is none of {}", name, fmt::join(home_set_presets(), ", ")));
  }
  if (name == "graphs") {
    o.homes = 6;
    o.face_size = 0;
  } else if (name == "training" || name == "demo") {
    o.homes = name == "demo" ? 60 : 96;
    o.pretty = name == "demo" ? 3 : 0;
    o.face_size = 64;
    o.samples = 1;
    o.light = HomeLight::kCoarse;
  }
  return o;
}

std::vector<std::string> home_set_presets() {
  return {"small", "pretty", "demo", "full", "graphs", "training"};
}

mesh::BakeOptions bake_options(HomeLight light, int threads) {
  if (light == HomeLight::kCoarse) {
    // Much coarser points save little: most are then corners of furniture.
    return {.spacing = 1, .detail = 1, .rays = 12, .threads = threads};
  }
  // Takes a third of the time of the finest light; in rooms, the difference is hardly visible.
  return {.detail = 0.5F, .rays = 48, .threads = threads};
}

HomeLight parse_home_light(std::string_view name) {
  if (const auto light = find_enum<HomeLight>(name)) return *light;
  throw ArgumentError(
      fmt::format("light: {:?} is none of {}", name, fmt::join(names_of(HomeLight()), ", ")));
}

std::vector<std::string> pretty_homes(const HomeSetOptions& options) {
  if (options.pretty == 0 || options.face_size == 0) return {};
  std::vector<std::string> scans;
  for (std::size_t i = 0; i < options.homes; ++i) scans.push_back(sets::scan_name(i));
  if (options.homes >= kLeastHomes) {
    const auto split_of = tasks::splits_of_buildings(scans, {.seed = options.seed});
    const auto rank = [&](const std::string& scan) {
      const std::string& split = split_of.at(scan);
      return split == "val_unseen" ? 0 : split == "train" ? 1 : 2;
    };
    std::ranges::stable_sort(scans, {}, rank);
  }
  scans.resize(std::min(options.pretty, scans.size()));
  std::ranges::sort(scans);
  return scans;
}

}  // namespace enfilade::homes
