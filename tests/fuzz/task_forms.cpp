// Texts that our writers make of what our readers accept are read back equal. The first byte says
// which reader and writer.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/tasks/formats/fine_grained.h"
#include "enfilade/tasks/formats/r2r_family.h"
#include "enfilade/tasks/formats/rxr.h"
#include "enfilade/tasks/formats/soon.h"
#include "enfilade/tasks/objects.h"

namespace {

using namespace enfilade;
namespace formats = tasks::formats;

template <class Parse, class Write>
void round_trip(std::string_view text, const Parse& parse, const Write& write) {
  const auto read = parse(std::string(text));
  const std::string written = write(read);
  if (written.empty()) return;  // lines of nothing, which are no file
  EN_CHECK_EQ(write(parse(written)), written);
}

void check(std::uint8_t which, std::string_view text) {
  const std::string file = "<fuzz>", split = "made";
  switch (which) {
    case '0':
      return round_trip(
          text,
          [&](const std::string& t) {
            return formats::parse_r2r_family(t, file, split, tasks::Task::kR2r);
          },
          [](const auto& a) { return formats::to_r2r_family(a); });
    case '1':
      return round_trip(
          text, [&](const std::string& t) { return formats::parse_fine_grained(t, file, split); },
          [](const auto& a) { return formats::to_r2r_family(a); });
    case '2':
      return round_trip(
          text, [&](const std::string& t) { return formats::parse_rxr_guide(t, file, split); },
          [](const auto& a) { return formats::to_rxr_guide(a); });
    case '3':
      return round_trip(
          text, [&](const std::string& t) { return formats::parse_soon_lines(t, file, split); },
          [](const auto& a) { return formats::to_soon_lines(a); });
    default:
      return round_trip(
          text, [&](const std::string& t) { return tasks::ObjectBoxes::parse(t, file); },
          [&](const auto& boxes) { return boxes.to_json(which == '4'); });
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  try {
    check(data[0], std::string_view(reinterpret_cast<const char*>(data + 1), size - 1));
  } catch (const enfilade::Error&) {
  }
  return 0;
}
