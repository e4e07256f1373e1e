/// \file  Descriptions of views, in words: for models without vision.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "enfilade/arena/chat.h"
#include "enfilade/arena/endpoint.h"
#include "enfilade/arena/pictures.h"
#include "enfilade/arena/session.h"

namespace enfilade::arena {

/// Puts views into words. One thread at a time.
class Words {
 public:
  virtual ~Words() = default;
  /// Description of a view of PictureKind::kPlaces at `from`; empty if no object in it has a name.
  /// Equal views give equal words.
  virtual std::string of(const Standpoint& from) = 0;
};

/// Makes words for one thread; may be called from any.
using WordsSource = std::function<std::unique_ptr<Words>()>;

/// From pictures of classes and instances (mpcat40): "bed, chair (2), window", the largest first.
/// Walls, floors, ceilings, objects without a name, and those below a two-hundredth of the view are
/// left out.
/// \throws from of(): ArgumentError without such pictures, naming what is missing; as
/// PictureMaker::draw()
WordsSource label_words(ViewSources sights);

/// Settings of the captions.
struct CaptionConfig {
  ChatConfig chat = {};                       ///< its model
  LimitField limit = LimitField::kMaxTokens;  ///< of ChatConfig::most_tokens
  std::string question =
      "Say in one short sentence what this picture of the inside of a building shows.";
  std::uint32_t picture_size = 512;  ///< pixels, 64 to 2048
  int attempts = 6;                  ///< requests for one caption before it is given up
  double first_wait = 1;             ///< seconds after the first that failed; doubled each time
  double longest_wait = kLongestAskedWait;                    ///< as Patience::longest_wait
  std::function<void(const std::string& sentence)> say = {};  ///< as Patience::say
};

/// From a vision model, one sentence each. Captions are cached as other responses are, so each
/// picture is sent only once. A caption is data, as everything in an observation is: line ends in
/// it become blanks, and 300 bytes are kept at most.
/// \param endpoint null: nothing is sent, and a caption that is not in the cache is an error.
/// Endpoint and cache outlive all words
/// \throws from of(): errors for which arena::ask() gives up an episode
WordsSource caption_words(ViewSources sights, CaptionConfig config, Endpoint* endpoint,
                          AnswerCache& cache);

}  // namespace enfilade::arena
