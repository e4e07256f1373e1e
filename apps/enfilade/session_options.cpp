#include "apps/enfilade/session_options.h"

#include "apps/common/program.h"

namespace enfilade::apps {

void add_subset_option(CLI::App& verb, std::string& subset) {
  add_value(verb, "--subset", subset, "N|FILE|all",
            "N episodes, spread over buildings and lengths; file of ids; all "
            "(default: 100, or as many as there are)");
}

void add_steps_option(CLI::App& verb, std::uint32_t& steps) {
  add_whole_number(verb, "--steps", steps,
                   "Most calls per episode; 0: 30, or the benchmark's limit if continuous", 0);
}

arena::Limits limits_of(const arena::World& world, std::uint32_t steps) {
  arena::Limits limits = arena::usual_limits(world.task());
  if (steps > 0) limits.steps = steps;
  return limits;
}

}  // namespace enfilade::apps
