#include "enfilade/render/face_cache.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <list>
#include <mutex>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/threads.h"
#include "enfilade/image/face_cells.h"
#include "enfilade/render/detail/cell_pool.h"
#include "enfilade/render/detail/layers.h"
#include "enfilade/render/detail/shared_cells.h"
#include "enfilade/render/detail/shared_file.h"

namespace enfilade::render {
namespace {

using scan::Layer;

enum class State : std::uint8_t { kLoading, kReady, kFailed };

// Where faces are that the cache makes room for, each within a limit of its own.
enum Place : std::uint8_t { kOwn, kShared, kPlaces };

struct Entry {
  FaceKey key;
  // Both null if the source has it in memory, or another process is decoding it.
  detail::CellPool::Piece memory;
  detail::SharedCells::Pin pin;
  std::uint8_t* target = nullptr;  // where it is decoded
  const std::uint8_t* cells = nullptr;
  std::size_t bytes = 0;  // that it takes there
  Place where = kOwn;
  std::uint32_t size = 0;
  std::optional<detail::SharedKey> shared_key;
  State state = State::kLoading;
  std::uint32_t holders = 0;  // that have acquired it and not released it, loaders included
  std::exception_ptr failure;
  std::list<Entry*>::iterator place;  // in idle[where] if holders == 0, else in `held`
};

Face face_of(const Entry& entry) { return {entry.cells, entry.size}; }

// Faces of one panorama and layer that are decoded by one call to the source, or one face that is
// decoded in parts.
struct Unit {
  std::array<Entry*, kCubeFaces> entries{};
  FaceKey first;
  std::uint32_t parts = 1, missing = 1;  // that are not decoded yet
  std::exception_ptr failure;
};

bool is_empty(const Unit& unit) {
  return std::ranges::all_of(unit.entries, [](const Entry* entry) { return entry == nullptr; });
}

std::uint64_t count_faces(std::span<const Unit> units) {
  std::uint64_t count = 0;
  for (const Unit& unit : units) {
    count += kCubeFaces - static_cast<std::size_t>(std::ranges::count(unit.entries, nullptr));
  }
  return count;
}

// What has to be done for faces that are not in the cache.
struct Plan {
  std::vector<Unit> decode;
  std::vector<Unit> await;  // that another process decodes; their entries have no memory yet
  std::vector<Unit> found;  // in the shared file
};

// What a thread decodes in one go.
struct Task {
  Unit* unit = nullptr;
  std::uint32_t part = 0;  // < unit->parts
};

// How long acquire() waits for another process that decodes a face, which takes some milliseconds,
// before it decodes the face itself: that process may be stopped.
constexpr std::chrono::seconds kPatience(1);

// A part needs rows beside it too, and all of them the same tables.
constexpr std::uint32_t kMostParts = 4;

// Whole units, as many for each thread; those left over in parts, so that no thread has to wait for
// another's last face. The tasks of a thread follow each other.
std::vector<Task> share_out(std::span<Unit> units, std::size_t threads,
                            const scan::PanoramaSet& panoramas) {
  const std::size_t whole = units.size() / threads, left = units.size() % threads;
  std::vector<Task> rest;
  for (Unit& unit : units.last(left)) {
    const FaceKey& key = unit.first;
    const scan::PanoramaSource& source = panoramas.source(key.scan);
    const Entry* entry = unit.entries[index(key.face)];
    if (key.layer == Layer::kColour && entry != nullptr && !source.reads_whole_panoramas() &&
        source.reads_rows(key.viewpoint, key.face)) {
      unit.parts = static_cast<std::uint32_t>(
          std::min<std::size_t>({threads / left, kMostParts, entry->size}));
      unit.missing = unit.parts;
    }
    for (std::uint32_t part = 0; part < unit.parts; ++part) rest.push_back({&unit, part});
  }
  std::vector<Task> tasks;
  for (std::size_t t = 0; t < threads; ++t) {
    for (Unit& unit : units.subspan(t * whole, whole)) tasks.push_back({&unit, 0});
    const std::size_t end = rest.size() * (t + 1) / threads;
    for (std::size_t k = rest.size() * t / threads; k < end; ++k) tasks.push_back(rest[k]);
  }
  return tasks;
}

// Reads the values of a unit's faces in rows, and puts them into cells.
template <class T, class Read>
void read_values(const Unit& unit, const Read& read) {
  thread_local std::vector<T> rows;  // of the faces that are read, one after the other
  std::size_t needed = 0;
  for (const Entry* entry : unit.entries) {
    if (entry != nullptr) needed += std::size_t{entry->size} * entry->size;
  }
  if (rows.size() < needed) rows.resize(needed);
  std::array<T*, kCubeFaces> buffers{};
  T* next = rows.data();
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const Entry* entry = unit.entries[k];
    if (entry == nullptr) continue;
    buffers[k] = next;
    next += std::size_t{entry->size} * entry->size;
  }
  read(buffers);
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    Entry* entry = unit.entries[k];
    if (entry == nullptr) continue;
    image::ValueCells<T>::from_rows(buffers[k], entry->size, entry->target);
  }
}

}  // namespace

std::size_t face_bytes(Layer layer, std::uint32_t size) noexcept {
  const std::size_t bytes = scan::cells_bytes(layer, size);
  // An odd number of lines, so that the same rows of faces do not meet in the same cache sets.
  return bytes % (2 * image::kCellBytes) == 0 ? bytes + image::kCellBytes : bytes;
}

std::size_t default_cache_bytes() {
  constexpr std::uint64_t kLeast = std::uint64_t{64} << 20, kMost = std::uint64_t{1} << 30;
  return static_cast<std::size_t>(std::clamp(available_memory() / 16, kLeast, kMost));
}

std::filesystem::path shared_cache_path(std::size_t bytes) {
  return fmt::format("/dev/shm/enfilade-cache-{}-{}-{}", geteuid(), bytes >> 20U,
                     detail::SharedFile::kVersion);
}

struct FaceCache::Impl {
  Impl(std::shared_ptr<const scan::PanoramaSet> set, const FaceCacheConfig& c)
      : panoramas(std::move(set)), config(c) {
    if (!panoramas) throw ArgumentError("panoramas: null, but a cache needs a PanoramaSet");
    if (config.threads < 0) throw ArgumentError("config.threads: below 0");
    if (!config.shared) return;
    shared = std::make_unique<detail::SharedCells>(*config.shared);
    shared_keys.emplace(*panoramas);
  }

  using Lock = std::unique_lock<std::mutex>;
  using Time = std::chrono::steady_clock::time_point;

  void acquire(std::span<const FaceKey> keys, std::span<Face> faces, int threads, bool ahead);
  void release(const Lock&, Entry& entry) noexcept;
  void hold(const Lock&, Entry& entry);
  Entry& add(Lock& lock, const FaceKey& key, std::uint32_t size, std::size_t bytes, Plan& plan);
  void take_own(const Lock& lock, Entry& entry, std::size_t bytes);
  void take_shared(const Lock& lock, Entry& entry, detail::SharedCells::Claim claim,
                   std::size_t bytes);
  void plan(Lock& lock, std::span<const FaceKey> keys, Plan& plan, bool ahead);
  void plan_one(Lock& lock, const FaceKey& key, Plan& plan);
  void fail(const Lock& lock, std::span<Unit> units) noexcept;
  void settle(const Lock& lock, Unit& unit) noexcept;
  void make_ready(Plan& plan, int threads);
  void load(const Task& task);
  void await(Unit& unit, Time limit);
  void decode(const Task& task);
  void make_room(const Lock&, Place where, std::size_t bytes);
  void forget(const Lock&, Entry& entry, std::list<Entry*>& from) noexcept;
  void clear(const Lock& lock, Place where) noexcept;
  void leave_parents_faces(const Lock& lock);
  void work_ahead(const std::stop_token& stop);

  std::shared_ptr<const scan::PanoramaSet> panoramas;
  FaceCacheConfig config;

  std::mutex mutex;
  std::condition_variable_any changed;  // an entry became ready or failed; wishes came
  // Before the entries, whose faces are in them.
  detail::CellPool memory;
  std::vector<std::unique_ptr<detail::SharedCells>> inherited;  // of processes that forked
  std::unique_ptr<detail::SharedCells> shared;                  // null: nothing is shared
  std::optional<detail::SharedKeys> shared_keys;
  std::unordered_map<FaceKey, std::unique_ptr<Entry>, detail::FaceKeyHash> entries;
  // Entries move between these as nodes, so that nothing is allocated.
  std::list<Entry*> held;
  std::array<std::list<Entry*>, kPlaces> idle;  // without holders; least recently used first
  FaceCacheCounters counters;
  std::vector<FaceKey> wishes;  // of prefetch(), the next one last
  std::jthread helper;          // last: it ends before what it uses
};

void FaceCache::Impl::hold(const Lock&, Entry& entry) {
  if (entry.holders++ == 0) held.splice(held.end(), idle[entry.where], entry.place);
}

void FaceCache::Impl::release(const Lock& lock, Entry& entry) noexcept {
  if (--entry.holders > 0) return;
  if (entry.state == State::kFailed) {
    forget(lock, entry, held);
    return;
  }
  auto& list = idle[entry.where];
  list.splice(list.end(), held, entry.place);
}

// \pre it has no holder, but is in `from` still
void FaceCache::Impl::forget(const Lock&, Entry& entry, std::list<Entry*>& from) noexcept {
  (entry.where == kShared ? counters.shared_bytes : counters.bytes) -= entry.bytes;
  from.erase(entry.place);
  entries.erase(FaceKey(entry.key));
}

// Removes faces until `bytes` more fit.
void FaceCache::Impl::make_room(const Lock& lock, Place where, std::size_t bytes) {
  const std::size_t limit = where == kShared ? shared->fair_share() : config.bytes;
  const std::size_t& used = where == kShared ? counters.shared_bytes : counters.bytes;
  while (used + bytes > limit && !idle[where].empty()) {
    forget(lock, *idle[where].front(), idle[where]);
  }
}

void FaceCache::Impl::clear(const Lock& lock, Place where) noexcept {
  while (!idle[where].empty()) forget(lock, *idle[where].front(), idle[where]);
}

// In a child, where the parent's pins are not this process's: the parent may unpin at any time, and
// the faces then change.
void FaceCache::Impl::leave_parents_faces(const Lock& lock) {
  if (!shared || !shared->is_forked()) return;
  auto own = std::make_unique<detail::SharedCells>(*config.shared);
  inherited.push_back(std::move(shared));
  shared = std::move(own);
  clear(lock, kShared);
  for (Entry* entry : held) {
    if (entry->where != kShared) continue;
    entry->state = State::kFailed;
    entry->failure = std::make_exception_ptr(
        Error("the process forked while this face was in use: the child has to release it first"));
  }
}

void FaceCache::Impl::take_own(const Lock& lock, Entry& entry, std::size_t bytes) {
  make_room(lock, kOwn, bytes);
  entry.memory = memory.take(bytes);
  entry.target = entry.memory.get();
  entry.cells = entry.target;
  entry.bytes = bytes;
  counters.bytes += bytes;
}

void FaceCache::Impl::take_shared(const Lock& lock, Entry& entry, detail::SharedCells::Claim claim,
                                  std::size_t bytes) {
  make_room(lock, kShared, bytes);
  entry.pin = std::move(claim.pin);
  entry.target = claim.cells;
  entry.cells = claim.cells;
  entry.where = kShared;
  entry.bytes = bytes;
  counters.shared_bytes += bytes;
}

// With `bytes` of memory; 0: the source has it.
Entry& FaceCache::Impl::add(Lock& lock, const FaceKey& key, std::uint32_t size, std::size_t bytes,
                            Plan& plan) {
  using ClaimResult = detail::SharedCells::ClaimResult;
  auto entry = std::make_unique<Entry>();
  std::vector<Unit>* units = &plan.decode;
  entry->key = key;
  entry->size = size;
  entry->holders = 1;
  if (shared && bytes > 0) entry->shared_key = shared_keys->key(key, size);
  if (entry->shared_key) {
    auto claim = shared->claim(*entry->shared_key, bytes);
    if (claim.found == ClaimResult::kReady) units = &plan.found;
    if (claim.found == ClaimResult::kElsewhere) units = &plan.await;
    if (claim.pin) take_shared(lock, *entry, std::move(claim), bytes);
  }
  if (bytes > 0 && !entry->pin && units == &plan.decode) take_own(lock, *entry, bytes);
  entry->place = held.insert(held.end(), entry.get());
  Entry& added = *entry;
  entries.emplace(key, std::move(entry));
  units->back().entries[index(key.face)] = &added;
  return added;
}

void FaceCache::Impl::plan_one(Lock& lock, const FaceKey& key, Plan& plan) {
  const scan::PanoramaSource& source = panoramas->source(key.scan);
  const std::uint32_t size = source.face_sizes(key.viewpoint)[index(key.layer)];
  if (size == 0) throw source.lacks(key.layer, key.viewpoint);
  if (size > image::kLargestCellFace) {
    throw Error(fmt::format(
        "{}: scan {}, viewpoint {}: its {} faces have {} x {} texels; drawing "
        "takes at most {} x {}",
        source.origin(), source.scan(), source.poses()[key.viewpoint.at()].viewpoint,
        to_string(key.layer), size, size, image::kLargestCellFace, image::kLargestCellFace));
  }
  const bool in_memory = source.has_cells(key.layer, key.viewpoint);
  const std::size_t bytes = in_memory ? 0 : face_bytes(key.layer, size);
  // First, so that what follows is undone if it throws.
  for (auto* units : {&plan.decode, &plan.await, &plan.found}) units->emplace_back().first = key;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const FaceKey face{key.scan, key.viewpoint, key.layer, cube_face(k)};
    const bool wanted = face == key || source.reads_whole_panoramas();
    if (wanted && !entries.contains(face)) add(lock, face, size, bytes, plan);
  }
  for (auto* units : {&plan.decode, &plan.await, &plan.found}) {
    if (is_empty(units->back())) units->pop_back();
  }
}

void FaceCache::Impl::fail(const Lock& lock, std::span<Unit> units) noexcept {
  for (Unit& unit : units) {
    unit.failure = std::current_exception();
    settle(lock, unit);
  }
}

// Decides what has to be decoded; each face is decoded by one thread only.
void FaceCache::Impl::plan(Lock& lock, std::span<const FaceKey> keys, Plan& plan, bool ahead) {
  std::size_t done = 0;
  try {
    for (const FaceKey& key : keys) {
      const auto found = entries.find(key);
      if (found != entries.end()) {
        hold(lock, *found->second);
        if (!ahead) ++counters.hits;
      } else {
        plan_one(lock, key, plan);
        hold(lock, *entries.find(key)->second);
        ++(ahead ? counters.prefetched : counters.misses);
      }
      ++done;
    }
  } catch (...) {
    for (auto* units : {&plan.decode, &plan.await, &plan.found}) fail(lock, *units);
    for (const FaceKey& key : keys.first(done)) release(lock, *entries.find(key)->second);
    throw;
  }
  counters.shared_hits += count_faces(plan.found);
  for (Unit& unit : plan.found) settle(lock, unit);
}

void FaceCache::Impl::decode(const Task& task) {
  const Unit& unit = *task.unit;
  const scan::PanoramaSource& source = panoramas->source(unit.first.scan);
  if (unit.parts > 1) {
    const Entry& entry = *unit.entries[index(unit.first.face)];
    const std::uint32_t begin = entry.size * task.part / unit.parts,
                        end = entry.size * (task.part + 1) / unit.parts;
    return source.read_colour_rows(unit.first.viewpoint, unit.first.face, {begin, end},
                                   {entry.target, entry.size});
  }
  if (source.has_cells(unit.first.layer, unit.first.viewpoint)) {
    for (Entry* entry : unit.entries) {
      if (entry == nullptr) continue;
      entry->cells = source.cells(entry->key.layer, entry->key.viewpoint, entry->key.face);
    }
    return;
  }
  scan::FaceMask mask = 0;
  scan::ColourFaces colour;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    const Entry* entry = unit.entries[k];
    if (entry == nullptr) continue;
    mask = static_cast<scan::FaceMask>(mask | 1U << k);
    colour[k] = {entry->target, entry->size};
  }
  const ViewpointIndex viewpoint = unit.first.viewpoint;
  switch (unit.first.layer) {
    case Layer::kColour:
      return source.read_colour(viewpoint, mask, colour);
    case Layer::kDepth:
    case Layer::kClass:
      return read_values<std::uint16_t>(unit, [&](const scan::Faces16& faces) {
        source.read_16(unit.first.layer, viewpoint, mask, faces);
      });
    case Layer::kInstance:
      return read_values<std::uint32_t>(
          unit, [&](const scan::Faces32& faces) { source.read_instances(viewpoint, mask, faces); });
  }
}

// The unit's faces are ready, or failed: wakes those who wait.
void FaceCache::Impl::settle(const Lock& lock, Unit& unit) noexcept {
  for (Entry* entry : unit.entries) {
    if (entry == nullptr) continue;
    if (entry->pin && !unit.failure) shared->finish(entry->pin);
    if (unit.failure) entry->pin.reset();
    entry->state = unit.failure ? State::kFailed : State::kReady;
    entry->failure = unit.failure;
    release(lock, *entry);  // the loader's own hold
  }
  changed.notify_all();
}

// Does not throw: failures are stored in the entries.
void FaceCache::Impl::load(const Task& task) {
  const auto begin = std::chrono::steady_clock::now();
  std::exception_ptr failure;
  try {
    decode(task);
  } catch (...) {
    failure = std::current_exception();
  }
  const auto spent = std::chrono::steady_clock::now() - begin;
  const Lock lock(mutex);
  counters.decode_nanoseconds += static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(spent).count());
  Unit& unit = *task.unit;
  if (failure && !unit.failure) unit.failure = failure;
  if (--unit.missing > 0) return;
  if (!unit.failure) counters.decoded += count_faces({&unit, 1});
  settle(lock, unit);
}

// Waits for the process that decodes the unit's faces, but decodes what that one does not. Does not
// throw.
void FaceCache::Impl::await(Unit& unit, Time limit) {
  Unit found = unit;
  found.entries = {};
  try {
    for (std::size_t k = 0; k < kCubeFaces; ++k) {
      Entry* entry = unit.entries[k];
      if (entry == nullptr) continue;
      const std::size_t bytes = face_bytes(entry->key.layer, entry->size);
      auto claim = shared->claim(*entry->shared_key, bytes, limit);
      const Lock lock(mutex);
      if (claim.found == detail::SharedCells::ClaimResult::kReady) {
        std::swap(found.entries[k], unit.entries[k]);
      }
      claim.pin ? take_shared(lock, *entry, std::move(claim), bytes)
                : take_own(lock, *entry, bytes);
    }
  } catch (...) {
    const Lock lock(mutex);
    unit.failure = std::current_exception();
    settle(lock, unit);
  }
  {
    const Lock lock(mutex);
    counters.shared_hits += count_faces({&found, 1});
    settle(lock, found);
    if (unit.failure) return;
  }
  if (!is_empty(unit)) load({&unit, 0});
}

void FaceCache::Impl::make_ready(Plan& plan, int threads) {
  const auto count = static_cast<std::size_t>(threads_or_all(threads));
  const std::vector<Task> tasks = share_out(plan.decode, count, *panoramas);
  parallel_for(tasks.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) load(tasks[k]);
  });
  // Afterwards, so that processes that wait for each other all have done their own part.
  const Time limit = std::chrono::steady_clock::now() + kPatience;
  parallel_for(plan.await.size(), 1, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) await(plan.await[k], limit);
  });
}

void FaceCache::Impl::acquire(std::span<const FaceKey> keys, std::span<Face> faces, int threads,
                              bool ahead) {
  Plan plan_of_all;  // allocates only if something is missing
  Lock lock(mutex);
  leave_parents_faces(lock);
  plan(lock, keys, plan_of_all, ahead);
  if (!plan_of_all.decode.empty() || !plan_of_all.await.empty()) {
    lock.unlock();
    make_ready(plan_of_all, threads);
    lock.lock();
  }
  std::exception_ptr failure;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    Entry& entry = *entries.find(keys[k])->second;
    changed.wait(lock, [&] { return entry.state != State::kLoading; });
    if (entry.state == State::kFailed && !failure) failure = entry.failure;
    faces[k] = face_of(entry);
  }
  if (!failure) return;
  for (const FaceKey& key : keys) release(lock, *entries.find(key)->second);
  std::rethrow_exception(failure);
}

void FaceCache::Impl::work_ahead(const std::stop_token& stop) {
  for (;;) {
    FaceKey wish;
    {
      Lock lock(mutex);
      changed.wait(lock, stop, [&] { return !wishes.empty(); });
      if (stop.stop_requested()) return;
      wish = wishes.back();
      wishes.pop_back();
      if (entries.contains(wish)) continue;
    }
    Face face;
    try {
      acquire({&wish, 1}, {&face, 1}, 1, true);
      const Lock lock(mutex);
      release(lock, *entries.find(wish)->second);
    } catch (const std::exception&) {
      // acquire() throws it again when the face is needed.
    }
  }
}

FaceCache::FaceCache(std::shared_ptr<const scan::PanoramaSet> panoramas,
                     const FaceCacheConfig& config)
    : impl_(std::make_unique<Impl>(std::move(panoramas), config)) {}

FaceCache::~FaceCache() = default;

const scan::PanoramaSet& FaceCache::panoramas() const noexcept { return *impl_->panoramas; }
const FaceCacheConfig& FaceCache::config() const noexcept { return impl_->config; }

void FaceCache::acquire(std::span<const FaceKey> keys, std::span<Face> faces) {
  EN_CHECK_EQ(keys.size(), faces.size());
  impl_->acquire(keys, faces, impl_->config.threads, false);
}

void FaceCache::release(std::span<const FaceKey> keys) noexcept {
  const Impl::Lock lock(impl_->mutex);
  for (const FaceKey& key : keys) impl_->release(lock, *impl_->entries.find(key)->second);
}

void FaceCache::prefetch(std::span<const FaceKey> keys) {
  if (!impl_->config.prefetch_thread) return;
  const Impl::Lock lock(impl_->mutex);
  impl_->leave_parents_faces(lock);
  // More than half of the memory would push out what is being looked at.
  std::size_t bytes = 0;
  impl_->wishes.clear();
  for (const FaceKey& key : keys) {
    if (impl_->entries.contains(key)) continue;
    const scan::PanoramaSource& source = impl_->panoramas->source(key.scan);
    const std::uint32_t size = source.face_sizes(key.viewpoint)[index(key.layer)];
    if (!source.has_cells(key.layer, key.viewpoint)) bytes += face_bytes(key.layer, size);
    if (size == 0 || bytes > impl_->config.bytes / 2) continue;
    impl_->wishes.push_back(key);
  }
  std::ranges::reverse(impl_->wishes);
  if (impl_->wishes.empty()) return;
  if (!impl_->helper.joinable()) {
    impl_->helper = std::jthread([this](const std::stop_token& stop) { impl_->work_ahead(stop); });
  }
  impl_->changed.notify_all();
}

FaceCacheCounters FaceCache::counters() const {
  const Impl::Lock lock(impl_->mutex);
  return impl_->counters;
}

void FaceCache::clear() {
  const Impl::Lock lock(impl_->mutex);
  for (const Place where : {kOwn, kShared}) impl_->clear(lock, where);
}

}  // namespace enfilade::render
