#include "enfilade/service/browsing/newest_sources.h"

#include <algorithm>
#include <system_error>

#include "enfilade/core/errors.h"
#include "enfilade/scan/store.h"

namespace enfilade::service::browsing {

std::optional<NewestSources::Stamp> NewestSources::stamp_of(const std::filesystem::path& file) {
  std::error_code time, size;
  const Stamp stamp{std::filesystem::last_write_time(file, time),
                    std::filesystem::file_size(file, size)};
  return time || size ? std::nullopt : std::optional(stamp);
}

// A store's origin is its file. The stamp is taken before the file is opened: one that replaces it
// in between is opened at the next call.
void NewestSources::update(Watched& watched) {
  const scan::PanoramaSource& now = *watched.newest.source;
  if (dynamic_cast<const scan::Store*>(&now) == nullptr) return;
  const auto stamp = stamp_of(now.origin());
  if (!stamp || stamp == watched.stamp) return;
  watched.stamp = stamp;
  try {
    std::shared_ptr<const scan::PanoramaSource> store = scan::Store::open(now.origin());
    const bool same_places =
        std::ranges::equal(store->poses(), now.poses(), {}, &scan::PanoramaPose::viewpoint,
                           &scan::PanoramaPose::viewpoint);
    if (!same_places || store->state() == now.state()) return;
    watched.newest = {std::move(store), watched.newest.replaced + 1};
  } catch (const Error&) {  // it is gone, or no store: what was read of the old one stays
  }
}

NewestSource NewestSources::get(ScanIndex scan) {
  const scan::PanoramaSource& first = panoramas_.source(scan);  // may take long: without the lock
  const std::scoped_lock lock(mutex_);
  Watched& watched = watched_[scan];
  if (watched.newest.source == nullptr) {
    watched.newest.source = std::shared_ptr<const scan::PanoramaSource>(
        &first, [](const scan::PanoramaSource*) {});  // the set owns it
  }
  update(watched);
  return watched.newest;
}

}  // namespace enfilade::service::browsing
