// The reader of people's corrections to a graph, and what applying them does.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/graph/corrections.h"
#include "tests/support/graphs.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const graph::Corrections read = graph::parse_corrections(text, "<fuzz>");
    const std::string written = graph::to_json(read);
    EN_CHECK(graph::to_json(graph::parse_corrections(written, "<again>")) == written);
    graph::apply(graph::testing::square(), read, "<fuzz>");
  } catch (const Error&) {
  }
  return 0;
}
