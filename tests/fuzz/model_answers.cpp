// What a language model or its server says must end as a call, as a mistake, or as a fault of the
// server; whatever call was read, the session has to take it or refuse it.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>

#include "enfilade/arena/chat.h"
#include "enfilade/arena/world.h"
#include "enfilade/core/check.h"
#include "tests/support/grid_world.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  using arena::Answers;
  static arena::GraphWorld world(arena::testing::episodes());
  static const arena::Prompt prompt = arena::Prompt::named("text");
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const arena::SessionLimits limits{.steps = 3, .mistakes = 2};
  for (const Answers answers : {Answers::kTools, Answers::kJson, Answers::kText}) {
    const auto session = world.start_on_graph(0, limits);
    arena::Chat chat(prompt, {.model = "m"}, {.answers = answers}, limits);
    while (!session->ending()) {
      chat.ask(session->observation(), {}, {});
      arena::ChatAnswer answer;
      try {
        answer = chat.read(text);
      } catch (const InvalidInput&) {
        break;
      }
      const std::uint32_t before = session->observation().step + session->mistakes();
      if (answer.reading.call) {
        session->call(*answer.reading.call);
      } else {
        EN_CHECK(!answer.reading.fault.empty());
        session->misread(answer.reading.fault);
      }
      EN_CHECK_EQ(session->observation().step + session->mistakes(), before + 1);
      chat.close(text, answer, session->observation());
    }
  }
  try {
    const arena::Prompt own = arena::Prompt::parse(text, "<fuzz>", "fuzz");
    const auto session = world.start_on_graph(0);
    own.start(session->observation(), own.answers(), {});
    own.step(session->observation(), own.answers(), {}, {});
  } catch (const InvalidInput&) {
  }
  return 0;
}
