// Texts that our writers make of what our readers accept are read back equal. The first byte says
// which benchmark, or in which form boxes of objects are written.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"

namespace {

using namespace enfilade;
using tasks::Task;

void check_annotations(std::string_view text, Task task) {
  const auto parse = [task](std::string_view of) {
    return tasks::parse_annotations(of, "<fuzz>", "made", task);
  };
  const std::string written = to_text(parse(text));
  if (written.empty()) return;  // lines of nothing, which are no file
  EN_CHECK_EQ(to_text(parse(written)), written);
}

// SOON's released form forgets ids: what it says of the rest is kept.
void check_released_soon(std::string_view text) {
  const auto parse = [](std::string_view of) {
    return tasks::parse_annotations(of, "<fuzz>", "made", Task::kSoon);
  };
  const tasks::Annotations read = parse(text);
  if (read.paths.empty()) return;
  const std::string written = to_released_soon(read);
  EN_CHECK_EQ(to_released_soon(parse(written)), written);
}

void check_walks(std::string_view text) {
  const auto walks = tasks::parse_demonstrations(text, "<fuzz>");
  if (walks.empty()) return;
  const std::string written = tasks::to_text(walks);
  EN_CHECK_EQ(tasks::to_text(tasks::parse_demonstrations(written, "<fuzz>")), written);
}

void check_boxes(std::string_view text, bool nested) {
  const std::string written = tasks::ObjectBoxes::parse(text, "<fuzz>").to_json(nested);
  EN_CHECK_EQ(tasks::ObjectBoxes::parse(written, "<fuzz>").to_json(nested), written);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  try {
    switch (data[0]) {
      case '0':
        check_annotations(text, Task::kR2r);
        break;
      case '1':
        check_annotations(text, Task::kR2rBack);
        break;
      case '2':
        check_annotations(text, Task::kRxr);
        break;
      case '3':
        check_annotations(text, Task::kSoon);
        break;
      case '4':
      case '5':
        check_boxes(text, data[0] == '4');
        break;
      case '6':
        check_annotations(text, Task::kReverie);
        break;
      case '7':
        check_annotations(text, Task::kCvdn);
        break;
      case '8':
        check_walks(text);
        break;
      default:
        check_released_soon(text);
    }
  } catch (const enfilade::Error&) {
  }
  return 0;
}
