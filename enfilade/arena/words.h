/// \file  What a view holds, in words: for models that do not see.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

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

}  // namespace enfilade::arena
