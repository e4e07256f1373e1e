/// \file  Options of all exports.
#pragma once
#include "enfilade/core/progress.h"

namespace enfilade::exports {

/// How an export runs. None of it changes a byte of the files.
struct ExportOptions {
  int threads = 0;         ///< 0: all cores
  Progress progress = {};  ///< counts scans or viewpoints, as each function documents
};

}  // namespace enfilade::exports
