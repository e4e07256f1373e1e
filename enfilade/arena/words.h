/// \file  What a view holds, in words: for models that do not see.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "enfilade/arena/answer_cache.h"
#include "enfilade/arena/chat.h"
#include "enfilade/arena/endpoint.h"
#include "enfilade/arena/pictures.h"
#include "enfilade/arena/session.h"

namespace enfilade::arena {

/// Puts views into words. One thread at a time.
class Words {
 public:
  virtual ~Words() = default;
  /// What is seen from there, in a view as Pictures::kPlaces has it; empty: nothing that has a
  /// name. Equal views give equal words.
  virtual std::string of(const Standpoint& from) = 0;
};

/// Makes words for one thread; may be called from any.
using WordsSource = std::function<std::unique_ptr<Words>()>;

/// From pictures of classes and instances (mpcat40): "bed, chair (2), window", the largest first.
/// Walls, floors, ceilings and what has no name are left out, and so is what takes less than a
/// two-hundredth of the view. \throws from of(): ArgumentError without such pictures, naming what
/// is missing; as Painter::draw()
WordsSource label_words(Sights sights);

/// How a captioner is asked.
struct CaptionConfig {
  ChatConfig chat = {};  ///< its model
  std::string question =
      "Say in one short sentence what this picture of the inside of a building shows.";
  std::uint32_t picture_size = 512;  ///< pixels, 64 to 2048
  int attempts = 6;                  ///< requests for one caption before it is given up
  double first_wait = 1;             ///< seconds after the first that failed; doubled each time
};

/// From a model that looks at pictures, one sentence each; kept as other answers are, so that it is
/// asked once for each picture, ever. A caption is data, as everything in an observation is: line
/// ends in it become blanks, and 300 bytes are kept at most.
/// \param endpoint null: nobody is asked, and a caption that is not in the cache is an error.
/// Endpoint and cache outlive all words \throws from of(): what arena::ask() leaves an episode for
WordsSource caption_words(Sights sights, CaptionConfig config, Endpoint* endpoint,
                          AnswerCache& cache);

}  // namespace enfilade::arena
