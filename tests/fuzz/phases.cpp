// Files of phases: what is accepted keeps the rules by which secret goals are protected.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/service/phases.h"
#include "tests/fuzz/json_mutator.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  using service::Scores;
  try {
    const auto phases = service::parse_phases(
        std::string_view(reinterpret_cast<const char*>(data), size), "/folder/phases.json");
    for (const service::Phase& phase : phases) {
      EN_CHECK(!phase.name.empty() && phase.name.size() <= 40 && !phase.split.empty());
      EN_CHECK(phase.per_day >= 1 && phase.per_address_day >= 1 && phase.teams >= 1);
      EN_CHECK(phase.step > 0 && phase.step < 1);
      const bool secret = phase.goals_secret();
      EN_CHECK(!secret || (phase.scores != Scores::kPublic && phase.per_team.has_value()));
      EN_CHECK(secret || phase.scores == Scores::kPublic || phase.scores == Scores::kHidden);
    }
  } catch (const InvalidInput& error) {
    EN_CHECK(!error.diagnostics().empty());
  }
  return 0;
}
