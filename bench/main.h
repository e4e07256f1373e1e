/// \file  What every benchmark program does around its benchmarks.
#pragma once
#include <benchmark/benchmark.h>
#include <cstdio>

#include "enfilade/scan/data_root.h"

namespace enfilade::bench {

/// Runs what `register_all` registers, or says why not where there is no real data. The status to
/// return from main().
inline int run(int argc, char** argv, void (*register_all)()) {
  if (!scan::DataRoot::from_environment()) {
    std::fprintf(stderr, "%s: skipped: ENFILADE_DATA is not set: no real data to measure on\n",
                 argv[0]);
    return 0;
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  register_all();
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}

}  // namespace enfilade::bench
