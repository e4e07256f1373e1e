#include "enfilade/scan/panorama_set.h"

#include <fmt/format.h>
#include <algorithm>
#include <atomic>
#include <mutex>
#include <set>
#include <system_error>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/scan/matterport_images.h"
#include "enfilade/scan/store.h"

namespace enfilade::scan {

namespace {

LookupError not_found(const std::string& scan, const std::string& tried) {
  return LookupError(
      fmt::format("scan {}: no panoramas found; {}", quote(scan),
                  tried.empty() ? "no folder to look in was named (--images)" : "tried:" + tried));
}

// Null if no place has the scan; `tried` then names the places.
std::shared_ptr<const PanoramaSource> find_panoramas(const PanoramaPlaces& places,
                                                     const std::string& scan, std::string& tried) {
  for (const std::filesystem::path& folder : places.images) {
    const std::filesystem::path packed = store_file(folder, scan);
    std::error_code ignored;
    if (std::filesystem::exists(packed, ignored)) return Store::open(packed);
    tried += fmt::format("\n  {}", packed.string());
    try {
      return open_matterport_images(folder, places.connectivity, scan);
    } catch (const LookupError& error) {  // lists what it looked for
      tried += fmt::format("\n  {}", error.what());
    }
  }
  return nullptr;
}

}  // namespace

// Readers use `opened`; `source` owns it and is accessed under the mutex only.
struct PanoramaSet::Slot {
  std::atomic<const PanoramaSource*> opened{nullptr};
  std::mutex mutex;
  std::shared_ptr<const PanoramaSource> source;
};

PanoramaSet::PanoramaSet(PanoramaPlaces places, std::vector<std::string> scans)
    : places_(std::move(places)),
      scans_(std::move(scans)),
      slots_(std::make_unique<Slot[]>(scans_.size())) {
  std::set<std::string_view> seen;
  for (const std::string& scan : scans_) {
    if (!seen.insert(scan).second) {
      throw ArgumentError(fmt::format("scans: {} twice; each may be named once", quote(scan)));
    }
  }
}

PanoramaSet::~PanoramaSet() = default;

std::shared_ptr<const PanoramaSet> PanoramaSet::open(PanoramaPlaces places,
                                                     std::vector<std::string> scans) {
  return std::shared_ptr<PanoramaSet>(new PanoramaSet(std::move(places), std::move(scans)));
}

std::shared_ptr<const PanoramaSet> PanoramaSet::of(
    std::vector<std::shared_ptr<const PanoramaSource>> sources) {
  std::vector<std::string> scans;
  for (const auto& source : sources) {
    if (!source) {
      throw ArgumentError(
          fmt::format("sources: number {} of {} is null", scans.size(), sources.size()));
    }
    scans.push_back(source->scan());
  }
  const std::shared_ptr<PanoramaSet> set(new PanoramaSet({}, std::move(scans)));
  for (std::size_t i = 0; i < sources.size(); ++i) {
    Slot& slot = set->slots_[i];
    slot.source = std::move(sources[i]);
    slot.opened = slot.source.get();
  }
  return set;
}

std::optional<ScanIndex> PanoramaSet::find(std::string_view scan) const {
  const auto at = std::ranges::find(scans_, scan);
  if (at == scans_.end()) return std::nullopt;
  return ScanIndex(static_cast<std::size_t>(at - scans_.begin()));
}

ScanIndex PanoramaSet::at(std::string_view scan) const {
  if (const auto found = find(scan)) return *found;
  throw LookupError(fmt::format("scan {}: not one of the {} of this set", quote(scan), size()));
}

const PanoramaSource* PanoramaSet::find_source(ScanIndex scan) const {
  std::string tried;
  return open(scan, tried);
}

const PanoramaSource& PanoramaSet::source(ScanIndex scan) const {
  std::string tried;
  if (const PanoramaSource* found = open(scan, tried)) return *found;
  throw not_found(scans_[scan.at()], tried);
}

const PanoramaSource* PanoramaSet::open(ScanIndex scan, std::string& tried) const {
  EN_CHECK_LT(scan.at(), size());
  Slot& slot = slots_[scan.at()];
  if (const PanoramaSource* opened = slot.opened.load(std::memory_order_acquire)) return opened;
  const std::scoped_lock lock(slot.mutex);
  if (!slot.source) {
    slot.source = find_panoramas(places_, scans_[scan.at()], tried);
    slot.opened.store(slot.source.get(), std::memory_order_release);
  }
  return slot.source.get();
}

std::shared_ptr<const PanoramaSource> open_panoramas(const PanoramaPlaces& places,
                                                     const std::string& scan) {
  std::string tried;
  if (auto found = find_panoramas(places, scan, tried)) return found;
  throw not_found(scan, tried);
}

}  // namespace enfilade::scan
