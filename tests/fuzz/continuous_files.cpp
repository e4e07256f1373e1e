// VLN-CE's files: texts that our writers make of what our readers accept are read back equal. The
// first byte says which file it is.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/continuous_score.h"

namespace {

using namespace enfilade;

void check_episodes(std::string_view text) {
  const tasks::ContinuousEpisodes read = tasks::parse_continuous_episodes(text, "<fuzz>", "made");
  for (const tasks::ContinuousEpisode& one : read.episodes) {
    EN_CHECK(!one.scan().empty());
    EN_CHECK(one.start_heading().value >= 0);
  }
  const std::string written = to_json(read);
  const auto again = tasks::parse_continuous_episodes(written, "<fuzz>", "made");
  EN_CHECK(again.episodes == read.episodes);
  EN_CHECK(again.vocabulary == read.vocabulary);
  EN_CHECK_EQ(to_json(again), written);
}

void check_walks(std::string_view text) {
  const tasks::ExpertWalks read = tasks::parse_expert_walks(text, "<fuzz>");
  const std::string written = to_json(read);
  EN_CHECK(tasks::parse_expert_walks(written, "<fuzz>") == read);
}

// Episodes 7 and 9, by instructions 93 and 91, both from (1, 0, 2) of Habitat.
void check_results(std::string_view text) {
  static const tasks::ContinuousEpisodes kEpisodes = [] {
    tasks::ContinuousEpisodes episodes{"made", "<made>", {}};
    for (const int id : {7, 9}) {
      tasks::ContinuousEpisode one;
      one.id = id;
      one.start = {1, -2, 0};
      one.instruction.id = std::to_string(100 - id);
      episodes.episodes.push_back(one);
    }
    return episodes;
  }();
  using Form = tasks::ContinuousForm;
  const auto parse = [](std::string_view of) {
    return tasks::parse_continuous_results(of, "<fuzz>", kEpisodes, tasks::Coverage::kPart);
  };
  const auto read = parse(text);
  const Form form = read.front().headings.empty() ? Form::kRxr : Form::kR2r;
  const std::string written = to_json(read, kEpisodes, form);
  EN_CHECK_EQ(to_json(parse(written), kEpisodes, form), written);
  for (const tasks::ContinuousResult& walk : read) {
    to_score(walk, std::vector<double>(walk.positions.size(), 1.0));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  try {
    switch (data[0]) {
      case 'e':
        check_episodes(text);
        break;
      case 'w':
        check_walks(text);
        break;
      default:
        check_results(text);
    }
  } catch (const enfilade::InvalidInput&) {
  }
  return 0;
}
