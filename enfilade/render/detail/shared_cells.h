/// \file  SharedCells: decoded faces that all processes of a machine share, in one mapped file,
/// and their keys there.
#pragma once
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "enfilade/render/detail/shared_file.h"
#include "enfilade/render/face_cache.h"
#include "enfilade/scan/panorama_set.h"

namespace enfilade::render::detail {

/// Which face, the same in all processes: a hash of its source, viewpoint, layer, place and size.
struct SharedKey {
  std::uint64_t low = 0, high = 0;
  friend bool operator==(const SharedKey&, const SharedKey&) = default;
};

/// Faces in slots of a file. The file is cut into segments. A segment is cut into slots of one size
/// when a face of that size first needs one. A table has for each slot its face, whether it is
/// complete, its last use, and which processes have pinned it. When all slots are taken, the least
/// recently used face without a pin is replaced.
///
/// Any process may be killed at any instruction. The table is changed under a lock that the kernel
/// hands on when its owner dies. The order of stores leaves it sound after each store. Pins and
/// unfinished faces of processes that have ended are dropped. A stopped process makes no other wait
/// for ever: callers then get no room, and use their own memory.
///
/// A forked child must not use its parent's: it makes one of its own (is_forked()). Releasing
/// inherited pins has no effect.
///
/// All functions may be called from any thread at once.
class SharedCells {
 public:
  /// Keeps a slot's face as it is. Only moved; gives itself back, and the slot too if its face was
  /// not finished.
  class Pin {
   public:
    Pin() = default;
    Pin(Pin&& other) noexcept { *this = std::move(other); }
    Pin& operator=(Pin&& other) noexcept {
      std::swap(cells_, other.cells_);
      std::swap(slot_, other.slot_);
      std::swap(unfinished_, other.unfinished_);
      return *this;
    }
    ~Pin() { reset(); }
    explicit operator bool() const noexcept { return cells_ != nullptr; }
    void reset() noexcept {
      if (cells_ != nullptr) cells_->give_back(*this);
      cells_ = nullptr;
    }

   private:
    friend class SharedCells;
    Pin(SharedCells* cells, std::uint32_t slot, bool unfinished)
        : cells_(cells), slot_(slot), unfinished_(unfinished) {}
    SharedCells* cells_ = nullptr;
    std::uint32_t slot_ = 0;
    bool unfinished_ = false;
  };

  /// Outcome of claim().
  enum class ClaimResult : std::uint8_t {
    kReady,      ///< the face, complete
    kMine,       ///< a slot: the caller has to decode the face into it, then call finish()
    kElsewhere,  ///< another process or cache is decoding it
    kNoRoom,     ///< all slots are pinned, or the face does not fit, or a lock is not to be had
  };
  struct Claim {
    ClaimResult found = ClaimResult::kNoRoom;
    std::uint8_t* cells = nullptr;  ///< of kReady and kMine; as long as `pin`
    Pin pin;
  };

  /// For tests: called between any two changes of the table.
  using Step = void (*)();

  /// Opens the file or makes it, and joins its users.
  /// \throws ArgumentError for a size that is not allowed; FileError as SharedFile
  explicit SharedCells(const SharedCacheConfig& config, Step at_step = nullptr);
  /// The last user's removes the file. \pre all pins are given back
  ~SharedCells();
  SharedCells(const SharedCells&) = delete;
  SharedCells& operator=(const SharedCells&) = delete;

  /// Whether this was made by the parent of this process.
  bool is_forked() const noexcept;
  /// Processes at a time; further ones get kNoRoom.
  static constexpr std::size_t kMostUsers = 512;

  /// Finds the face, or a slot for it. Does not wait for another process that decodes it.
  /// \param bytes of the face's cells, a multiple of 64
  Claim claim(const SharedKey& key, std::size_t bytes) noexcept;
  /// As claim(), but waits until `limit` while the face is decoded elsewhere.
  Claim claim(const SharedKey& key, std::size_t bytes,
              std::chrono::steady_clock::time_point limit) noexcept;
  /// Shows a decoded face to all, if its claim was kMine; else does nothing.
  void finish(Pin& pin) noexcept;

  /// Bytes of faces that this process should keep pinned at most: its part of half the file, so
  /// that there always are faces to replace.
  std::size_t fair_share() const noexcept;

 private:
  struct Head;
  struct User;
  struct Slot;
  struct Pins;
  struct FileLayout {
    std::size_t segment_bytes = 0, segments = 0, slots_per_segment = 0;
    std::size_t users_at = 0, sizes_at = 0, slots_at = 0, pins_at = 0, cells_at = 0;
  };
  class Lock;
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  static FileLayout layout_of(std::size_t bytes);
  void initialise(std::uint8_t* bytes) const;

  Head& head() const noexcept;
  User& user(std::size_t index) const noexcept;
  std::atomic<std::uint64_t>& slot_bytes(std::size_t segment) const noexcept;
  std::size_t slots_of(std::size_t segment) const noexcept;
  Slot& slot(std::uint32_t index) const noexcept;
  Pins& pins(std::uint32_t index) const noexcept;
  std::uint8_t* cells(std::uint32_t index) const noexcept;
  std::uint32_t index_of(std::size_t segment, std::size_t k) const noexcept {
    return static_cast<std::uint32_t>(segment * layout_.slots_per_segment + k);
  }

  void join();
  bool lock() noexcept;
  void unlock() noexcept;
  bool is_time_to_look() const noexcept;
  // Under the lock. \param size of a slot
  Claim claim_now(const SharedKey& key, std::uint64_t size) noexcept;
  std::uint32_t find(const SharedKey& key, std::uint64_t size) const noexcept;
  std::uint32_t find_room(std::uint64_t size) noexcept;
  std::optional<std::uint64_t> last_use(std::size_t segment) const noexcept;
  void drop(std::size_t user) noexcept;
  void drop_ended() noexcept;
  void count_users() noexcept;

  void give_back(const Pin& pin) noexcept;
  void step() const noexcept {
    if (step_ != nullptr) step_();
  }

  FileLayout layout_;
  Step step_;
  ProcessId process_;              // that joined
  std::size_t user_ = kMostUsers;  // in the table; kMostUsers: not there
  std::unique_ptr<SharedFile> file_;
};

/// Makes keys of the faces of a set. Calls each source's state() once, at its first face. Not for
/// several threads at once.
/// \pre the set lives as long
class SharedKeys {
 public:
  explicit SharedKeys(const scan::PanoramaSet& panoramas);
  /// No value if the source's state is unknown: its faces cannot be shared.
  /// \param size of the face, texels  \throws as PanoramaSource::state()
  std::optional<SharedKey> key(const FaceKey& face, std::uint32_t size);

 private:
  struct SourceHash {
    bool asked = false;
    std::optional<SharedKey> hash;
  };
  const scan::PanoramaSet& panoramas_;
  std::vector<SourceHash> sources_;  // by ScanIndex
};

}  // namespace enfilade::render::detail
