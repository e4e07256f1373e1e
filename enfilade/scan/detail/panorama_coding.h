/// \file  Encodes a panorama as a record of a store.
#pragma once
#include "enfilade/scan/detail/store_writer.h"
#include "enfilade/scan/store.h"

namespace enfilade::scan::detail {

/// Sizes that a panorama's faces will have in a store: those of its source, none above
/// options.face_size.
FaceSizes packed_sizes(const FaceSizes& sizes, const PackOptions& options);

/// Reads, shrinks and encodes one panorama. The same input gives the same bytes in any thread.
/// Shrunk colour is averaged; shrunk depth and ids are the texel in the middle of the area: a mean
/// of two classes or of two distances would be neither. \throws what the source throws
EncodedPanorama encode_panorama(const PanoramaSource& source, const PlannedPanorama& planned,
                                const PackOptions& options);

}  // namespace enfilade::scan::detail
