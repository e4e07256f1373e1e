// What the readers of the benchmarks' files accept, the look-up must take. The first byte says
// which reader; what is left over chooses among benchmarks by the text itself.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "enfilade/core/errors.h"
#include "enfilade/tasks/files.h"
#include "tests/fuzz/fixture.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  using tasks::Task;
  static const auto kGraphs = fuzz::graphs();
  if (size == 0) return 0;
  constexpr std::uint8_t kTasks = static_cast<std::uint8_t>(Task::kSoon) + 1;
  const std::uint8_t which = static_cast<std::uint8_t>(data[0] - '0');
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  const Task task =
      which < kTasks ? static_cast<Task>(which) : tasks::find_task(text).value_or(Task::kR2r);
  try {
    make_episodes(tasks::parse_annotations(text, "<fuzz>", "made", task), kGraphs);
  } catch (const Error&) {
  }
  return 0;
}
