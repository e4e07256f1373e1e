/// \file  Fine-grained R2R beside R2R: which piece of an instruction describes which piece of its
/// path.
#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/service/detail/once_cache.h"
#include "enfilade/service/site.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::service::browsing {

/// Pieces of the instructions of R2R's splits, from tasks::fine_grained_places(). A split's file is
/// read at the first request for one of its instructions, and kept. All functions may be called
/// from any thread.
class Pieces {
 public:
  explicit Pieces(std::shared_ptr<const Site> site);

  /// What the data set says of one instruction.
  struct Found {
    std::vector<tasks::SubInstruction> parts;  ///< in order; empty: there are none
    bool broken = false;                       ///< the file cannot be read
  };
  /// What is found for instruction k of a path of the split. Nothing for other benchmarks than R2R,
  /// for hidden goals, and where the file has another path or text by this path_id. Such a file may
  /// be of another version, and its places would be wrong.
  /// \pre path is one of the split's, k < path.instructions.size()
  Found of(const PublicSplit& split, const tasks::PathAnnotation& path, std::size_t k);

 private:
  struct Read;
  std::shared_ptr<const Read> read(const std::string& split) const;

  std::shared_ptr<const Site> site_;
  detail::OnceCache<std::string, std::shared_ptr<const Read>> read_;  // by split
};

}  // namespace enfilade::service::browsing
