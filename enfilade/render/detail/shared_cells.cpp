#include "enfilade/render/detail/shared_cells.h"

#include <fmt/format.h>
#include <pthread.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <ctime>
#include <new>
#include <string>
#include <string_view>
#include <thread>
#include <tuple>

#include "enfilade/core/errors.h"

namespace enfilade::render::detail {
namespace {

enum State : std::uint32_t { kEmpty, kLoading, kReady };

constexpr std::size_t kMebi = std::size_t{1} << 20U;
constexpr std::size_t kHeadBytes = 4096;
// Smaller faces take as much: with it, the table has 0.6 % of the file.
constexpr std::size_t kLeastSlot = std::size_t{16} << 10U;
// Cells may be read so far beyond their end (face_cells.h); a cache line.
constexpr std::size_t kBeyond = 64;
constexpr std::size_t kWordBits = 64;

constexpr std::size_t round_up(std::size_t bytes, std::size_t to) {
  return (bytes + to - 1) / to * to;
}

// The lock is held for microseconds; who waits longer waits for a process that was stopped.
constexpr long kLockNanoseconds = 200'000'000;
// Between two looks at who still runs: reading /proc takes about 10 us a process.
constexpr std::chrono::milliseconds kBetweenLooks(100);

std::uint64_t now() noexcept {
  const auto since = std::chrono::steady_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(since).count());
}

SharedKey hash(const void* bytes, std::size_t count) {
  const XXH128_hash_t found = XXH3_128bits(bytes, count);
  return {found.low64, found.high64};
}

SharedKey hash(std::string_view text) { return hash(text.data(), text.size()); }

}  // namespace

// All members are atomic, even where the lock guards them: the order of the stores matters where a
// process is killed between two. What follows the SharedFileHead in the file.
struct SharedCells::Head {
  SharedFileHead file;
  pthread_mutex_t mutex;
  std::atomic<std::uint64_t> tick;    // counts uses
  std::atomic<std::uint64_t> looked;  // when ended processes were last looked for, milliseconds
  std::atomic<std::uint32_t> users;
  std::atomic<std::uint32_t> removed;  // the last user has gone, and the file's name with it
};

struct SharedCells::User {
  std::atomic<std::int32_t> number;  // of its process; 0: free
  std::atomic<std::uint64_t> start, name_space;
};

struct SharedCells::Slot {
  std::atomic<std::uint64_t> low, high;  // the key
  std::atomic<std::uint64_t> used;       // Head::tick when it was last used
  std::atomic<std::uint32_t> state;
  std::atomic<std::uint32_t> loader;  // who fills it, if kLoading

  std::uint64_t last_used() const noexcept { return used.load(std::memory_order_relaxed); }
};

// One bit a user. Cleared without the lock, by the user itself.
struct SharedCells::Pins {
  std::array<std::atomic<std::uint64_t>, kMostUsers / kWordBits> words;

  bool any() const noexcept {
    return std::ranges::any_of(
        words, [](const auto& word) { return word.load(std::memory_order_acquire) != 0; });
  }
  void set(std::size_t user) noexcept {
    words[user / kWordBits].fetch_or(std::uint64_t{1} << user % kWordBits);
  }
  void clear(std::size_t user) noexcept {
    words[user / kWordBits].fetch_and(~(std::uint64_t{1} << user % kWordBits));
  }
};

class SharedCells::Lock {
 public:
  explicit Lock(SharedCells& cells) noexcept : cells_(cells), held_(cells.lock()) {}
  ~Lock() {
    if (held_) cells_.unlock();
  }
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;
  explicit operator bool() const noexcept { return held_; }

 private:
  SharedCells& cells_;
  bool held_;
};

// --- where things are in the file -------------------------------------------------------------

SharedCells::FileLayout SharedCells::layout_of(std::size_t bytes) {
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);
  static_assert(sizeof(Head) <= kHeadBytes && sizeof(Slot) == 32);
  if (bytes < kMebi || bytes % kMebi != 0) {
    throw ArgumentError(fmt::format(
        "shared cache: {} bytes; a whole number of MiB, at least 1, is allowed", bytes));
  }
  FileLayout layout;
  // Sixteen, so that four kinds of faces find a place side by side; no longer than what the largest
  // faces in use (2048 texels: 16 MB) fill well.
  layout.segment_bytes = std::clamp(std::bit_floor(bytes / 16), kMebi / 16, 64 * kMebi);
  layout.slots_per_segment = layout.segment_bytes / kLeastSlot;
  for (layout.segments = bytes / layout.segment_bytes;; --layout.segments) {
    const std::size_t slots = layout.segments * layout.slots_per_segment;
    layout.users_at = kHeadBytes;
    layout.sizes_at = layout.users_at + sizeof(User) * kMostUsers;
    layout.slots_at = round_up(layout.sizes_at + 8 * layout.segments, kBeyond);
    layout.pins_at = layout.slots_at + sizeof(Slot) * slots;
    layout.cells_at = round_up(layout.pins_at + sizeof(Pins) * slots, kHeadBytes);
    if (layout.cells_at + layout.segments * layout.segment_bytes + kBeyond <= bytes) return layout;
  }
}

// All else is right when it is 0.
void SharedCells::initialise(std::uint8_t* bytes) const {
  pthread_mutexattr_t attributes;
  pthread_mutexattr_init(&attributes);
  pthread_mutexattr_setpshared(&attributes, PTHREAD_PROCESS_SHARED);
  pthread_mutexattr_setrobust(&attributes, PTHREAD_MUTEX_ROBUST);
  const int failed = pthread_mutex_init(&reinterpret_cast<Head*>(bytes)->mutex, &attributes);
  pthread_mutexattr_destroy(&attributes);
  if (failed != 0) throw FileError("shared cache: this system has no locks that outlive a process");
}

SharedCells::Head& SharedCells::head() const noexcept {
  return *reinterpret_cast<Head*>(file_->bytes());
}
SharedCells::User& SharedCells::user(std::size_t index) const noexcept {
  return reinterpret_cast<User*>(file_->bytes() + layout_.users_at)[index];
}
SharedCells::Slot& SharedCells::slot(std::uint32_t index) const noexcept {
  return reinterpret_cast<Slot*>(file_->bytes() + layout_.slots_at)[index];
}
SharedCells::Pins& SharedCells::pins(std::uint32_t index) const noexcept {
  return reinterpret_cast<Pins*>(file_->bytes() + layout_.pins_at)[index];
}
std::atomic<std::uint64_t>& SharedCells::slot_bytes(std::size_t segment) const noexcept {
  return reinterpret_cast<std::atomic<std::uint64_t>*>(file_->bytes() + layout_.sizes_at)[segment];
}
// 0 of a segment that is not cut yet.
std::size_t SharedCells::slots_of(std::size_t segment) const noexcept {
  const std::uint64_t bytes = slot_bytes(segment).load();
  return bytes < kLeastSlot ? 0 : layout_.segment_bytes / bytes;
}
std::uint8_t* SharedCells::cells(std::uint32_t index) const noexcept {
  const std::size_t segment = index / layout_.slots_per_segment,
                    k = index % layout_.slots_per_segment;
  return file_->bytes() + layout_.cells_at + segment * layout_.segment_bytes +
         k * slot_bytes(segment).load();
}

// --- the lock ---------------------------------------------------------------------------------

bool SharedCells::lock() noexcept {
  pthread_mutex_t* mutex = &head().mutex;
  int result = pthread_mutex_trylock(mutex);
  if (result == EBUSY) {
    timespec until{};
    clock_gettime(CLOCK_REALTIME, &until);
    constexpr long kSecond = 1'000'000'000;
    until.tv_nsec += kLockNanoseconds;
    until.tv_sec += until.tv_nsec / kSecond;
    until.tv_nsec %= kSecond;
    result = pthread_mutex_timedlock(mutex, &until);
  }
  if (result == EOWNERDEAD) {
    // Its owner was killed. Each of its stores has left the table sound; what it held is dropped.
    drop_ended();
    pthread_mutex_consistent(mutex);
    result = 0;
  }
  return result == 0;
}

void SharedCells::unlock() noexcept { pthread_mutex_unlock(&head().mutex); }

// --- users ------------------------------------------------------------------------------------

SharedCells::SharedCells(const SharedCacheConfig& config, Step at_step)
    : layout_(layout_of(config.bytes)), step_(at_step) {
  const std::filesystem::path path =
      config.path.empty() ? shared_cache_path(config.bytes) : config.path;
  for (;;) {
    file_ = std::make_unique<SharedFile>(path, config.bytes,
                                         [&](std::uint8_t* bytes) { initialise(bytes); });
    join();
    // Another one may have been the last user, and have removed the file, since it was opened.
    if (user_ < kMostUsers || head().removed.load() == 0) return;
  }
}

SharedCells::~SharedCells() {
  if (is_forked() || user_ == kMostUsers) return;  // the pins and the file are another process's
  const Lock held(*this);
  if (!held) return;  // a process that was stopped has it; then this one's end shows in /proc
  drop(user_);
  drop_ended();
  if (head().users.load() > 0) return;
  file_->remove();
  step();
  head().removed.store(1);
}

bool SharedCells::is_forked() const noexcept { return getpid() != process_.number; }

void SharedCells::join() {
  process_ = this_process();
  const Lock held(*this);
  if (!held || head().removed.load() != 0) return;
  drop_ended();
  for (std::size_t k = 0; k < kMostUsers; ++k) {
    User& free = user(k);
    if (free.number.load() != 0) continue;
    free.start.store(process_.start);
    step();
    free.name_space.store(process_.name_space);
    step();
    free.number.store(process_.number);
    step();
    count_users();
    user_ = k;
    return;
  }
}

// Its bits first: if this process is killed in between, the user still counts as one that ended.
void SharedCells::drop(std::size_t index) noexcept {
  for (std::size_t s = 0; s < layout_.segments; ++s) {
    const std::size_t count = slots_of(s);
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint32_t i = index_of(s, k);
      Slot& dropped = slot(i);
      if (dropped.state.load() == kLoading && dropped.loader.load() == index) {
        dropped.state.store(kEmpty);
        step();
      }
      pins(i).clear(index);
    }
    step();
  }
  user(index).number.store(0);
  step();
  count_users();
}

// Counted anew each time, as a process may be killed before it has counted itself.
void SharedCells::count_users() noexcept {
  std::uint32_t count = 0;
  for (std::size_t k = 0; k < kMostUsers; ++k) count += user(k).number.load() != 0 ? 1U : 0U;
  head().users.store(count);
}

void SharedCells::drop_ended() noexcept {
  head().looked.store(now());
  for (std::size_t k = 0; k < kMostUsers; ++k) {
    const ProcessId process{user(k).number.load(), user(k).start.load(), user(k).name_space.load()};
    if (process.number != 0 && process != process_ && !may_run(process, process_)) drop(k);
  }
  count_users();
}

std::size_t SharedCells::fair_share() const noexcept {
  const std::size_t users = std::max<std::size_t>(head().users.load(), 1);
  return layout_.segments * layout_.segment_bytes / 2 / users;
}

// --- slots ------------------------------------------------------------------------------------

std::uint32_t SharedCells::find(const SharedKey& key, std::uint64_t size) const noexcept {
  for (std::size_t s = 0; s < layout_.segments; ++s) {
    if (slot_bytes(s).load() != size) continue;
    const std::size_t count = slots_of(s);
    for (std::size_t k = 0; k < count; ++k) {
      const Slot& one = slot(index_of(s, k));
      if (one.low.load(std::memory_order_relaxed) == key.low && one.high.load() == key.high &&
          one.state.load() != kEmpty) {
        return index_of(s, k);
      }
    }
  }
  return kNone;
}

// When the segment's face that was used last was used; no value if one may not be replaced.
std::optional<std::uint64_t> SharedCells::last_use(std::size_t segment) const noexcept {
  std::uint64_t last = 0;
  const std::size_t count = slots_of(segment);
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t i = index_of(segment, k);
    if (slot(i).state.load() == kEmpty) continue;
    if (slot(i).state.load() == kLoading || pins(i).any()) return {};
    last = std::max(last, slot(i).last_used());
  }
  return last;
}

// An empty slot, or that of the face to be replaced; kNone if there is neither.
std::uint32_t SharedCells::find_room(std::uint64_t size) noexcept {
  std::uint32_t oldest = kNone;
  std::uint64_t oldest_use = ~std::uint64_t{0};
  std::size_t segment = layout_.segments;  // to be cut anew, if its last use is before that
  std::uint64_t segment_use = ~std::uint64_t{0};
  for (std::size_t s = 0; s < layout_.segments; ++s) {
    if (slot_bytes(s).load() != size) {
      const auto use = last_use(s);
      if (use && *use < segment_use) std::tie(segment, segment_use) = std::tuple(s, *use);
      continue;
    }
    const std::size_t count = slots_of(s);
    for (std::size_t k = 0; k < count; ++k) {
      const std::uint32_t i = index_of(s, k);
      const std::uint32_t state = slot(i).state.load();
      if (state == kEmpty) return i;
      if (state == kReady && slot(i).last_used() < oldest_use && !pins(i).any()) {
        std::tie(oldest, oldest_use) = std::tuple(i, slot(i).last_used());
      }
    }
  }
  if (segment == layout_.segments || segment_use >= oldest_use) return oldest;
  const std::size_t count = slots_of(segment);
  for (std::size_t k = 0; k < count; ++k) {
    slot(index_of(segment, k)).state.store(kEmpty);
    step();
  }
  // Slots that the old size had not: what an older one left there is no face.
  for (std::size_t k = count; k < layout_.slots_per_segment; ++k) {
    slot(index_of(segment, k)).state.store(kEmpty);
  }
  step();
  slot_bytes(segment).store(size);
  step();
  return index_of(segment, 0);
}

SharedCells::Claim SharedCells::claim_now(const SharedKey& key, std::uint64_t size) noexcept {
  const std::uint64_t tick = head().tick.fetch_add(1) + 1;
  std::uint32_t i = find(key, size);
  if (i != kNone) {
    if (slot(i).state.load() != kReady) return {ClaimResult::kElsewhere, nullptr, {}};
    pins(i).set(user_);
    step();
    slot(i).used.store(tick);
    return {ClaimResult::kReady, cells(i), Pin(this, i, false)};
  }
  i = find_room(size);
  if (i == kNone && is_time_to_look()) {
    drop_ended();
    i = find_room(size);
  }
  if (i == kNone) return {};
  slot(i).state.store(kEmpty);
  step();
  slot(i).low.store(key.low);
  step();
  slot(i).high.store(key.high);
  slot(i).used.store(tick);
  slot(i).loader.store(static_cast<std::uint32_t>(user_));
  step();
  for (auto& word : pins(i).words) word.store(0);
  step();
  pins(i).set(user_);
  step();
  slot(i).state.store(kLoading);
  step();
  return {ClaimResult::kMine, cells(i), Pin(this, i, true)};
}

bool SharedCells::is_time_to_look() const noexcept {
  return now() - head().looked.load() > static_cast<std::uint64_t>(kBetweenLooks.count());
}

SharedCells::Claim SharedCells::claim(const SharedKey& key, std::size_t bytes) noexcept {
  const std::uint64_t size = std::max(bytes, kLeastSlot);
  if (user_ == kMostUsers || size > layout_.segment_bytes) return {};
  const Lock held(*this);
  if (!held) return {};
  return claim_now(key, size);
}

SharedCells::Claim SharedCells::claim(const SharedKey& key, std::size_t bytes,
                                      std::chrono::steady_clock::time_point limit) noexcept {
  // A face takes a millisecond, of which this is a fair part; and a processor is not kept busy.
  constexpr std::chrono::microseconds kPause(200);
  for (;;) {
    Claim claimed = claim(key, bytes);
    if (claimed.found != ClaimResult::kElsewhere || std::chrono::steady_clock::now() > limit) {
      return claimed;
    }
    std::this_thread::sleep_for(kPause);
    if (!is_time_to_look()) continue;
    const Lock held(*this);
    if (held) drop_ended();
  }
}

void SharedCells::finish(Pin& pin) noexcept {
  if (std::exchange(pin.unfinished_, false)) slot(pin.slot_).state.store(kReady);
}

// Without the lock: no other process changes a pinned slot.
void SharedCells::give_back(const Pin& pin) noexcept {
  if (is_forked()) return;
  if (pin.unfinished_) {
    slot(pin.slot_).state.store(kEmpty);
    step();
  }
  slot(pin.slot_).used.store(head().tick.fetch_add(1) + 1);
  pins(pin.slot_).clear(user_);
}

SharedKeys::SharedKeys(const scan::PanoramaSet& panoramas)
    : panoramas_(panoramas), sources_(panoramas.size()) {}

std::optional<SharedKey> SharedKeys::key(const FaceKey& face, std::uint32_t size) {
  const scan::PanoramaSource& from = panoramas_.source(face.scan);
  SourceHash& source = sources_[face.scan.at()];
  if (!source.asked) {
    const std::string state = from.state();
    if (!state.empty()) source.hash = hash(state + '\0' + from.origin() + '\0' + from.scan());
    source.asked = true;
  }
  if (!source.hash) return {};
  // The pose too: a state may be of the pictures alone, and turned depth depends on it.
  const scan::PanoramaPose& pose = from.poses()[face.viewpoint.at()];
  const SharedKey viewpoint = hash(pose.viewpoint);
  std::array<std::uint64_t, 19> all{};
  std::size_t next = 0;
  for (const std::uint64_t part :
       {source.hash->low, source.hash->high, viewpoint.low, viewpoint.high,
        std::uint64_t{index(face.layer)}, std::uint64_t{index(face.face)}, std::uint64_t{size}}) {
    all[next++] = part;
  }
  for (const double part : pose.world_from_panorama.m) {
    all[next++] = std::bit_cast<std::uint64_t>(part);
  }
  for (const double part : {pose.position.x, pose.position.y, pose.position.z}) {
    all[next++] = std::bit_cast<std::uint64_t>(part);
  }
  return hash(all.data(), sizeof(all));
}

}  // namespace enfilade::render::detail
