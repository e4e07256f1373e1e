// Files of attention and of decisions: what is accepted is written and read back equal.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/models/decisions.h"

namespace {

using namespace enfilade;

std::string text_of(const models::DecisionFile& file) {
  const std::vector<std::pair<std::string, models::EpisodeDecisions>> all(file.begin(), file.end());
  return models::decisions_json(all);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const models::RecordedSplit split = models::parse_recorded_split(
        std::string_view(reinterpret_cast<const char*>(data), size), "<fuzz>");
    if (const auto* decisions = std::get_if<models::DecisionFile>(&split)) {
      const std::string written = text_of(*decisions);
      EN_CHECK_EQ(text_of(models::parse_decisions(written, "<fuzz>")), written);
    }
  } catch (const Error&) {
  }
  return 0;
}
