// CVDN's dialogues: what is accepted is written and read back equal.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/tasks/dialogues.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  try {
    const auto dialogues = tasks::parse_dialogues(
        std::string_view(reinterpret_cast<const char*>(data), size), "<fuzz>");
    const std::string written = to_json(dialogues);
    EN_CHECK_EQ(to_json(tasks::parse_dialogues(written, "<fuzz>")), written);
  } catch (const Error&) {
  }
  return 0;
}
