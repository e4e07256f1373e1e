/// \file  Names of faces that are the same in all processes.
#pragma once
#include <optional>
#include <vector>

#include "enfilade/render/detail/shared_cells.h"
#include "enfilade/render/face_cache.h"
#include "enfilade/scan/panorama_set.h"

namespace enfilade::render::detail {

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
  struct Source {
    bool asked = false;
    std::optional<SharedKey> hash;
  };
  const scan::PanoramaSet& panoramas_;
  std::vector<Source> sources_;  // by ScanIndex
};

}  // namespace enfilade::render::detail
