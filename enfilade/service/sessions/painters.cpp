#include "enfilade/service/sessions/painters.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "enfilade/core/threads.h"

namespace enfilade::service::sessions {

Painters::Painters(std::shared_ptr<const Site> site)
    : site_(std::move(site)), idle_(static_cast<std::size_t>(std::max(1, available_threads()))) {}
Painters::~Painters() = default;

std::string Painters::draw(const arena::PictureOrder& order) {
  std::unique_ptr<arena::PictureMaker> painter;
  {
    std::unique_lock lock(mutex_);
    returned_.wait(lock, [this] { return !idle_.empty(); });
    painter = std::move(idle_.back());
    idle_.pop_back();
  }
  struct Return {
    Painters& all;
    std::unique_ptr<arena::PictureMaker>& painter;
    ~Return() {
      const std::scoped_lock lock(all.mutex_);
      // Those that are made stay last, so that they are taken first.
      all.idle_.insert(painter ? all.idle_.end() : all.idle_.begin(), std::move(painter));
      all.returned_.notify_one();
    }
  } const back{*this, painter};
  if (painter == nullptr) {
    // The site has the data set for as long as it lives.
    painter = std::make_unique<arena::PictureMaker>(
        arena::ViewSources{.data = {site_, &site_->data()}, .scene_of = {}});
  }
  return painter->draw(order);
}

}  // namespace enfilade::service::sessions
