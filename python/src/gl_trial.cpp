// Another Python process tries OpenGL's drivers before this one loads them.
#include <dlfcn.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <filesystem>
#include <string>
#include <vector>

#include "enfilade/render/gl_devices.h"
#include "python/src/bindings.h"

namespace enfilade::python {
namespace {

// Its arguments: this package's folder, then those of try_gl().
constexpr const char* kScript =
    "import sys\n"
    "sys.path.insert(0, sys.argv[1])\n"
    "from enfilade import _core\n"
    "sys.exit(_core._try_gl(sys.argv[2:]))\n";

// The folder of this module's package.
std::filesystem::path own_folder() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&own_folder), &info) == 0) return {};
  return std::filesystem::absolute(info.dli_fname).parent_path().parent_path();
}

}  // namespace

void bind_gl_trial(nb::module_& m) {
  m.def("_try_gl",
        [](const std::vector<std::string>& arguments) { return render::try_gl(arguments); });
  // If Python is embedded, sys.executable is the other program or empty.
  const nb::object executable = nb::module_::import_("sys").attr("executable");
  std::string program;
  if (!nb::try_cast(executable, program)) return;
  const std::string name = std::filesystem::path(program).filename().string();
  if (!name.starts_with("python") && !name.starts_with("pypy")) return;
  render::set_gl_trial({program, "-c", kScript, own_folder().string()});
}

}  // namespace enfilade::python
