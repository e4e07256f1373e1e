/// \file  Processes that train or evaluate one model together, on one computer or on many.
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"

namespace enfilade::neural {

/// Another process of the same work has ended or does not answer; what() names it. The work can be
/// retried, from its last checkpoint.
class LostRank : public CutShort {
 public:
  using CutShort::CutShort;
};

/// Rank of this process among those that a launcher started together.
struct RankPlace {
  int rank = 0, size = 1;
  int local_rank = 0, local_size = 1;  ///< among those of this computer
  std::string host = {};   ///< computer of rank 0, which opens a store for the ranks to meet
  std::uint16_t port = 0;  ///< of the store
  std::string launcher;    ///< "torchrun", "srun" or "mpirun"
};

/// Reads a variable of the environment; null: it is not set.
using Variables = std::function<const char*(const char*)>;
/// The place that torchrun (and all that sets RANK and WORLD_SIZE), Open MPI, MPICH or a step of
/// Slurm put into the environment. No value: the process was started alone.
/// \throws ArgumentError naming a variable that is missing or is not a number
std::optional<RankPlace> find_place(const Variables& variables = std::getenv);

/// The first computer of a list as Slurm writes it: "node[07-12,20],login" has "node07".
std::string first_host(std::string_view nodes);

/// Something that has to be the same for all processes.
using RankFacts = std::map<std::string, std::string>;

/// The processes of one work, connected by c10d's Gloo. All call the same functions in the same
/// order; each call waits for the others. One thread at a time.
///
/// All functions \throw LostRank if another process ended, failed or did not answer in time.
class Ranks {
 public:
  /// This process alone; nothing is connected.
  Ranks();
  /// Connects. \param timeout how long any call waits for the others
  /// \throws Error if this build has no c10d; ArgumentError for a store that cannot be opened
  Ranks(const RankPlace& place, std::chrono::seconds timeout);
  ~Ranks();
  Ranks(Ranks&&) noexcept;
  Ranks& operator=(Ranks&&) noexcept;

  int rank() const noexcept;
  int size() const noexcept;  ///< 1 if alone
  bool is_first() const noexcept { return rank() == 0; }
  bool alone() const noexcept { return size() == 1; }

  /// Waits until all are here.
  void meet();
  /// The bytes of each process, by rank.
  std::vector<std::string> gather(std::string_view bytes);
  /// Compares values that must be equal. \throws ArgumentError, in all processes, saying which rank
  /// differs from rank 0 in what
  void agree(const RankFacts& facts);
  /// Sends the others the reason why this process ends, for their error.
  void tell_failure(std::string_view why) noexcept;

  struct Impl;
  Impl& implementation() noexcept { return *impl_; }  ///< of the library itself

 private:
  std::unique_ptr<Impl> impl_;
};

/// Calls work(); an exception is sent to the other ranks before it is passed on.
template <class Work>
void tell_failures(Ranks& ranks, const Work& work) {
  try {
    work();
  } catch (const LostRank&) {  // which the others notice themselves
    throw;
  } catch (const std::exception& error) {
    ranks.tell_failure(error.what());
    throw;
  }
}

/// The default number of parts of a batch (TrainConfig::parts) for that number of processes. It is
/// 8, so that 1, 2, 4 and 8 processes give the same weights; others if 8 cannot be shared.
std::size_t usual_parts(int processes);

/// Whether processes can be connected here: "Gloo, of libtorch 1.13.1", or the missing part.
struct RanksReport {
  bool works = false;
  std::string text;
};
RanksReport examine_ranks();

}  // namespace enfilade::neural
