#include <fmt/format.h>

#include "enfilade/core/errors.h"
#include "enfilade/render/cuda/compiler.h"
#include "enfilade/render/cuda/driver.h"
#include "enfilade/render/cuda_devices.h"

namespace enfilade::render {

CudaReport cuda_report() {
  CudaReport report;
  try {
    const cuda::Api& api = cuda::api();
    int version = 0, count = 0;
    cuda::check(api.DriverGetVersion(&version), "asking the driver's version");
    report.driver = fmt::format("{}.{}", version / 1000, version % 1000 / 10);
    cuda::check(api.DeviceGetCount(&count), "counting cards");
    for (int k = 0; k < count; ++k) {
      const cuda::Device device(k);
      const cuda::Current current(device);
      CudaDevice& found = report.devices.emplace_back();
      found.name = device.name();
      found.capability = fmt::format("{}.{}", device.capability() / 10, device.capability() % 10);
      cuda::check(api.MemGetInfo(&found.free_bytes, &found.bytes), "asking for free memory");
    }
  } catch (const Error& error) {
    report.error = error.what();
  }
  try {
    report.compiler = cuda::Compiler().version();
  } catch (const Error& error) {
    report.compiler_error = error.what();
  }
  return report;
}

}  // namespace enfilade::render
