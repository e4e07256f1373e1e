#include "enfilade/arena/words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "enfilade/arena/detail/view_renderer.h"
#include "enfilade/arena/dialect.h"
#include "enfilade/arena/wire.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/utf8.h"
#include "enfilade/core/written_lists.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::arena {
namespace {

using mesh::Mpcat40;

constexpr std::uint32_t kSize = 120;                 // pixels: a lamp across a room is seen
constexpr std::size_t kLeast = kSize * kSize / 200;  // pixels that are worth a word
constexpr std::size_t kMostWords = 6;

bool is_a_thing(std::size_t category) {
  constexpr std::array kNone{Mpcat40::kVoid,    Mpcat40::kWall,   Mpcat40::kFloor,
                             Mpcat40::kCeiling, Mpcat40::kColumn, Mpcat40::kBeam,
                             Mpcat40::kObjects, Mpcat40::kMisc,   Mpcat40::kUnlabeled};
  return category < mesh::kMpcat40Size && std::ranges::find(kNone, category, [](auto one) {
                                            return std::size_t(one);
                                          }) == kNone.end();
}

class LabelWords : public Words {
 public:
  explicit LabelWords(const ViewSources& sights)
      : sight_(sights), classes_(kSize * kSize), instances_(kSize * kSize) {}

  std::string of(const Standpoint& from) override {
    render::Outputs outputs;
    outputs.classes.emplace().pixels = std::as_writable_bytes(std::span(classes_));
    outputs.instances.emplace().pixels = instances_;
    const detail::Gaze gaze{from.heading, from.elevation};
    sight_.render(detail::camera_for(from, kSize), from, {&gaze, 1}, outputs);

    struct Seen {
      std::size_t pixels = 0;
      std::map<std::uint32_t, std::size_t> instances;  // and their pixels
    };
    std::map<std::size_t, Seen> by_class;
    for (std::size_t p = 0; p < classes_.size(); ++p) {
      if (!is_a_thing(classes_[p])) continue;
      Seen& seen = by_class[classes_[p]];
      ++seen.pixels;
      ++seen.instances[instances_[p]];
    }
    std::vector<std::pair<std::size_t, std::string>> words;
    for (const auto& [category, seen] : by_class) {
      if (seen.pixels < kLeast) continue;
      const auto count = std::ranges::count_if(
          seen.instances, [](const auto& one) { return one.second >= kLeast; });
      const std::string_view name = mesh::mpcat40(category).raw;
      words.emplace_back(seen.pixels, count > 1 ? fmt::format("{} ({})", name, count) : name);
    }
    std::ranges::stable_sort(words, std::greater(), &std::pair<std::size_t, std::string>::first);
    if (words.size() > kMostWords) words.resize(kMostWords);
    std::vector<std::string_view> names;
    for (const auto& [pixels, name] : words) names.push_back(name);
    return fmt::format("{}", fmt::join(names, ", "));
  }

 private:
  detail::ViewRenderer sight_;
  std::vector<std::uint16_t> classes_;
  std::vector<std::uint32_t> instances_;
};

class CaptionWords : public Words {
 public:
  CaptionWords(const ViewSources& sights, CaptionConfig config, Endpoint* endpoint,
               AnswerCache& cache)
      : painter_(sights), config_(std::move(config)), endpoint_(endpoint), cache_(cache) {}

  std::string of(const Standpoint& from) override {
    const PictureOrder order{{}, from, false, config_.picture_size, {}};
    const std::string key = order.key();
    // From the usual form, so that equal pictures have equal requests in every order of requests.
    Dialect dialect{.answers = Answers::kText, .limit = config_.limit};
    for (;;) {
      const std::string request = picture_request(config_.chat, dialect, config_.question, key);
      const KeptAnswer kept = cache_.get(request, [&] { return ask(request, order, dialect); });
      const auto refusal = find_refusal(kept.answer);
      if (!refusal) return one_line(after_reasoning(read_completion(kept.answer).text));
      if (kind_of(*refusal) == RefusalKind::kFilter) return {};
      const auto changed = remedy_for(*refusal, request, dialect, {});
      if (!changed) throw GivenUp(words_in(refusal->body));
      dialect = *changed;
    }
  }

 private:
  /// The response to a request, or the refusal that has a remedy.
  KeptAnswer ask(const std::string& request, const PictureOrder& order, const Dialect& dialect) {
    if (endpoint_ == nullptr) {
      throw GivenUp(
          fmt::format("the caption {} is not in the cache", AnswerCache::key_of(request)));
    }
    const std::string body =
        with_pictures(request, [&](std::string_view) { return painter_.draw(order); });
    const Patience patience{config_.attempts, config_.first_wait,
                            [](double seconds) {
                              std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
                              return true;
                            },
                            config_.longest_wait, config_.say};
    try {
      return post_patiently(*endpoint_, body, {"caption/" + order.key(), {}}, patience,
                            [](std::string_view answer) { read_completion(answer); });
    } catch (const RequestRefused& error) {
      const bool kept = kind_of(error.refusal()) == RefusalKind::kFilter ||
                        remedy_for(error.refusal(), request, dialect, {});
      if (!kept) throw;
      return {kept_refusal(error.refusal())};
    }
  }

  static std::string one_line(std::string_view text) {
    constexpr std::size_t kMost = 300;
    std::string line;
    for (const char c : trimmed(text)) {
      const bool blank = static_cast<unsigned char>(c) <= ' ';
      if (!blank) {
        line += c;
      } else if (!line.ends_with(' ')) {
        line += ' ';
      }
    }
    return std::string(utf8_prefix(line, kMost));
  }

  PictureMaker painter_;
  CaptionConfig config_;
  Endpoint* endpoint_;
  AnswerCache& cache_;
};

}  // namespace

WordsSource caption_words(ViewSources sights, CaptionConfig config, Endpoint* endpoint,
                          AnswerCache& cache) {
  if (config.chat.model.empty()) throw ArgumentError("captions: no model");
  return [sights = std::move(sights), config = std::move(config), endpoint, &cache] {
    return std::make_unique<CaptionWords>(sights, config, endpoint, cache);
  };
}

WordsSource label_words(ViewSources sights) {
  return [sights = std::move(sights)] { return std::make_unique<LabelWords>(sights); };
}

}  // namespace enfilade::arena
