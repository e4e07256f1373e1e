// What the annotations' reader accepts, the writer and the look-up must take.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/tokenizer.h"
#include "tests/fuzz/fixture.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  static const auto kGraphs = fuzz::graphs();
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  tasks::tokenize(text);
  try {
    const tasks::Annotations a = tasks::parse_annotations(text, "<fuzz>", "made");
    const std::string written = to_json(a);
    EN_CHECK_EQ(to_json(tasks::parse_annotations(written, "<fuzz>", "made")), written);
    make_episodes(a, kGraphs);
  } catch (const Error&) {
  }
  return 0;
}
