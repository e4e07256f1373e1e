#include "enfilade/core/check.h"

#include <cstdio>
#include <cstdlib>

namespace enfilade::detail {

void check_failed(const char* file, int line, const char* expression, const std::string& values) {
  std::fprintf(stderr, "%s:%d: Enfilade is broken: %s does not hold%s%s\n", file, line, expression,
               values.empty() ? "" : ": ", values.c_str());
  std::abort();
}

}  // namespace enfilade::detail
