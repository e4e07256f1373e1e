#include "apps/enfilade/verbs.h"

#include <fmt/format.h>
#include <string_view>

namespace enfilade::apps {

std::string version_with_commit() {
  constexpr std::string_view kCommit = EN_COMMIT;
  return kCommit.empty() ? EN_VERSION : fmt::format("{}, commit {}", EN_VERSION, kCommit);
}

}  // namespace enfilade::apps
