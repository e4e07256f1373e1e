#include "enfilade/agents/neural/detail/hash.h"

#include <fmt/format.h>
#include <xxhash.h>

namespace enfilade::agents::neural {

std::string hash_of(std::string_view bytes) {
  return fmt::format("{:016x}", XXH3_64bits(bytes.data(), bytes.size()));
}

}  // namespace enfilade::agents::neural
