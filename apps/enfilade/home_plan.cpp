#include "apps/enfilade/home_plan.h"

#include <algorithm>
#include <system_error>

#include "enfilade/homes/home.h"
#include "enfilade/homes/home_set.h"

namespace enfilade::apps {

std::optional<draw::PlanUnderlay> home_underlay(const std::filesystem::path& folder,
                                                const graph::NavGraph& graph) {
  std::error_code code;
  if (!std::filesystem::exists(folder / "homes.json", code)) return std::nullopt;
  const auto homes = homes::read_home_list(folder);
  const auto entry = std::ranges::find(homes, graph.scan(), &homes::HomeEntry::scan);
  if (entry == homes.end()) return std::nullopt;
  const homes::Home home = homes::make_home(entry->plan);
  draw::PlanUnderlay underlay = draw::plan_underlay(home.mesh, graph);
  for (const homes::PlanRoom& room : home.plan.rooms) {
    const Vec3d middle{(room.floor.x0 + room.floor.x1) / 2, (room.floor.y0 + room.floor.y1) / 2,
                       home.plan.storeys.at(room.storey).floor};
    draw::add_text(underlay, graph, to_float(middle), room.name);
  }
  return underlay;
}

}  // namespace enfilade::apps
