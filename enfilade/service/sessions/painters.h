/// \file  The pictures of sessions and runs, drawn by as many painters as there are processors.
#pragma once
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "enfilade/arena/pictures.h"
#include "enfilade/service/site.h"

namespace enfilade::service::sessions {

/// Draws pictures for all requests. A painter belongs to one thread at a time, and keeps decoded
/// panoramas. It is made when it is first needed. All functions may be called from any thread.
class Painters {
 public:
  explicit Painters(std::shared_ptr<const Site> site);
  ~Painters();
  Painters(const Painters&) = delete;
  Painters& operator=(const Painters&) = delete;

  /// JPEG. Waits while all painters are busy. \throws as arena::PictureMaker
  std::string draw(const arena::PictureOrder& order);

 private:
  std::shared_ptr<const Site> site_;
  std::mutex mutex_;  // of what follows
  std::condition_variable returned_;
  std::vector<std::unique_ptr<arena::PictureMaker>> idle_;  // made ones last; null: not made yet
};

}  // namespace enfilade::service::sessions
