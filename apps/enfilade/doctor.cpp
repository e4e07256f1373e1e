// enfilade doctor: what this machine can do, and what to do about what it cannot.
#include <fmt/format.h>
#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <vector>

#include "apps/common/program.h"
#include "apps/enfilade/advice.h"
#include "apps/enfilade/learning/learn.h"
#include "apps/enfilade/python_report.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/proxy.h"
#include "enfilade/core/threads.h"
#include "enfilade/render/devices.h"
#include "enfilade/render/renderer.h"

namespace enfilade::apps::doctor_verb {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMesaPackages = "libegl1 libegl-mesa0 libgl1-mesa-dri";

// A line of the report.
struct Finding {
  std::string section, name;
  std::optional<bool> works;  // no value: a plain fact
  std::string text;
  std::string advice;  // what to do about it
};

class Report {
 public:
  void begin(std::string section) { section_ = std::move(section); }
  void fact(std::string name, std::string text) { add(std::move(name), {}, std::move(text)); }
  void add(std::string name, std::optional<bool> works, std::string text, std::string advice = {}) {
    findings_.push_back({section_, std::move(name), works, std::move(text), std::move(advice)});
  }
  void add(std::string name, Judgement found) {
    add(std::move(name), found.good, std::move(found.text), std::move(found.advice));
  }
  const std::vector<Finding>& findings() const { return findings_; }

 private:
  std::string section_;
  std::vector<Finding> findings_;
};

double gigabytes(double bytes) { return bytes / (1U << 30); }

void examine_machine(Report& report) {
  report.begin("machine");
  report.fact("enfilade", EN_VERSION);
  report.fact("processor", processor_name());
  report.fact("cores", fmt::format("{} for this process", available_threads()));
  report.add("SIMD", judge_simd(render::cpu_target(), processor_has_avx2()));
  const double page = static_cast<double>(sysconf(_SC_PAGESIZE));
  report.fact("memory", fmt::format("{:.1f} GiB, {:.1f} GiB free",
                                    gigabytes(page * static_cast<double>(sysconf(_SC_PHYS_PAGES))),
                                    gigabytes(static_cast<double>(available_memory()))));
}

constexpr const char* kBrokenDriver =
    "update or remove that driver; other devices and the cpu back end work without it";

// True if it draws.
bool examine_cpu(Report& report, render::Backend backend) {
  render::RendererConfig config;
  config.backend = backend;
  const std::string name(enum_name(backend));
  try {
    const auto renderer = render::make_renderer(render::sample_faces(), config);
    render::check_sample(*renderer);
    report.add(name, true, renderer->description());
    return true;
  } catch (const Error& error) {
    report.add(name, false, error.what(), "please report this");
    return false;
  }
}

// True if at least one back end draws. OpenGL's draws where one of its devices does: each was tried
// by another process, as a driver may crash or hang.
bool examine_backends(Report& report, const std::vector<render::GlDevice>& devices,
                      const render::CudaReport& cuda) {
  report.begin("rendering");
  bool works = false;
  for (const render::Backend backend : render::backends()) {
    if (backend == render::Backend::kCuda) {
      const bool draws = !cuda.devices.empty() && !cuda.compiler.empty();
      report.add("cuda", draws, draws ? cuda.devices.front().name : "see CUDA below");
      works = works || draws;
      continue;
    }
    if (backend != render::Backend::kGl) {
      works = examine_cpu(report, backend) || works;
      continue;
    }
    const auto device = std::ranges::find_if(devices, &render::GlDevice::works);
    if (device != devices.end()) {
      report.add("gl", true, fmt::format("{}, OpenGL {}", device->renderer, device->version));
      works = true;
      continue;
    }
    report.add("gl", false, "no OpenGL device works: see below",
               fmt::format("use the cpu back end, which needs no OpenGL, or: apt-get install {}",
                           kMesaPackages));
  }
  return works;
}

void examine_gl(Report& report, const std::vector<render::GlDevice>& devices) {
  report.begin("OpenGL through EGL");
  const auto backends = render::backends();
  if (std::ranges::find(backends, render::Backend::kGl) == backends.end()) {
    report.add("EGL", false, "this build has none",
               "for OpenGL, build with -DEN_WITH_GL=ON (needs libepoxy-dev and libegl-dev)");
    return;
  }
  if (devices.empty()) {
    report.add("EGL", false, "libEGL.so.1 cannot be loaded",
               fmt::format("for OpenGL: apt-get install {}, or the driver of your graphics card",
                           kMesaPackages));
  }
  for (const render::GlDevice& device : devices) {
    const bool numbered = device.name.find_first_not_of("0123456789") == std::string::npos;
    const std::string name = numbered ? "device " + device.name : device.name;
    std::string text =
        device.works ? fmt::format("{}, OpenGL {}", device.renderer, device.version) : device.error;
    if (!device.uuid.empty()) text += ", UUID " + device.uuid;
    // No advice if one of several does not work: "default" never works without a display.
    report.add(name, device.works, std::move(text), device.broken ? kBrokenDriver : "");
  }
}

void examine_cuda(Report& report, const render::CudaReport& cuda) {
  report.begin("CUDA");
  report.add("driver", !cuda.driver.empty(),
             cuda.driver.empty() ? cuda.error : fmt::format("of CUDA {}", cuda.driver));
  for (std::size_t k = 0; k < cuda.devices.size(); ++k) {
    const render::CudaDevice& d = cuda.devices[k];
    report.add(fmt::format("card {}", k), true,
               fmt::format("{}, compute capability {}, {:.0f} GiB, {:.0f} free", d.name,
                           d.capability, std::ldexp(static_cast<double>(d.bytes), -30),
                           std::ldexp(static_cast<double>(d.free_bytes), -30)));
  }
  // Without a card no compiler for it is needed.
  const bool compiles = !cuda.compiler.empty();
  report.add("compiler", compiles, compiles ? "NVRTC " + cuda.compiler : "no NVRTC",
             !compiles && !cuda.devices.empty() ? cuda.compiler_error : "");
}

void examine_networks(Report& report) {
  report.begin("networks");
  const auto torch = torch_report();
  if (!torch) {
    report.add("libtorch", false, "no enfilade-learn beside this program",
               fmt::format("for features and training: {}", kHowToLearn));
    return;
  }
  report.add("libtorch", true, torch->version);
  report.fact("BLAS", torch->blas.empty() ? "inside libtorch" : torch->blas);
  report.add("products", judge_blas(*torch));
  const bool cuda = torch->cuda == "works";
  report.add("cuda", cuda, torch->cuda);
  report.add("several processes", torch->connects, torch->processes,
             torch->connects ? "" : "to train in more than one: docs/scale.md");
}

// Which habitat_sim code gets that imports it: the drop-in, or Habitat-Sim itself.
void examine_python(Report& report) {
  using Module = PythonReport::Module;
  report.begin("Python");
  const PythonReport python = report_of_python(python_of_this_machine());
  if (!python.error.empty()) {
    report.add("interpreter", false, fmt::format("{}: {}", python.program, python.error),
               "only `import enfilade` and its drop-ins need it: a python3 that starts, on PATH");
    return;
  }
  report.fact("interpreter", fmt::format("{} {}", python.program, python.version));
  switch (python.module) {
    case Module::kNone:
      report.fact("habitat_sim", "none is installed");
      break;
    case Module::kOurs:
      report.fact("habitat_sim",
                  "Enfilade's drop-in, as " + python.module_version + ": " + python.path);
      break;
    case Module::kHabitats:
      report.fact("habitat_sim",
                  "Habitat-Sim itself, " + python.module_version + ": " + python.path);
      break;
    case Module::kBroken:
      report.add("habitat_sim", false,
                 python.path + (python.path.empty() ? "" : ": ") + python.fault,
                 "install what it lacks, or uninstall it: docs/python_habitat_sim.md");
      break;
  }
}

// What is written where, and how much the demo, the largest of the verbs' usual jobs, writes there.
void examine_space(Report& report) {
  report.begin("disk");
  constexpr std::uint64_t kMebi = std::uint64_t{1} << 20U;
  const auto examine = [&](const char* name, const fs::path& folder, std::uint64_t needed,
                           const char* for_what, const char* change) {
    try {
      report.add(name, judge_space(space_of(folder), needed, for_what, change));
    } catch (const Error& error) {
      report.add(name, false, error.what(), change);
    }
  };
  std::error_code code;
  examine("working folder", fs::current_path(code), 1024 * kMebi,
          "model homes, features and models", "start in a folder on another disk, or give -o one");
  const char* temporary = std::getenv("TMPDIR");
  examine("temporary folder", temporary == nullptr ? "/tmp" : temporary, 256 * kMebi,
          "temporary files", "name a folder on another disk by the environment variable TMPDIR");
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  fs::path caches =
      cache != nullptr ? fs::path(cache) : fs::path(home == nullptr ? "/" : home) / ".cache";
  while (!fs::exists(caches, code) && caches.has_relative_path()) caches = caches.parent_path();
  examine("caches", caches, 256 * kMebi, "what drivers and pip keep there",
          "name a folder on another disk by the environment variable XDG_CACHE_HOME");
  if (fs::exists("/dev/shm", code)) {
    examine("shared memory", "/dev/shm", 256 * kMebi,
            "batches that Python's processes pass to each other",
            "in a container, give it more (docker run --shm-size=2g)");
  }
}

// The proxies that `ask` and `submit` use. Neither user nor password is shown.
void examine_network(Report& report) {
  report.begin("network");
  for (const std::string scheme : {"http", "https"}) {
    try {
      const auto proxy = proxy_for(scheme + "://enfilade.invalid/");
      report.fact("proxy for " + scheme,
                  proxy ? fmt::format("{} ({}{})", proxy->address(), proxy->variable,
                                      proxy->user.empty() ? "" : ", a user")
                        : "none");
    } catch (const Error& error) {
      report.add("proxy for " + scheme, false, error.what(),
                 "set the variable to http://HOST:PORT, or unset it");
    }
  }
  for (const char* name : {"no_proxy", "NO_PROXY"}) {
    const char* const list = std::getenv(name);
    if (list == nullptr || *list == '\0') continue;
    report.fact("without a proxy", fmt::format("this machine, {} ({})", list, name));
    break;
  }
}

void examine_data(Report& report, const std::string& folder) {
  report.begin("data");
  try {
    const dataset::Dataset data = open_data(folder);
    report.add("folder", true, data.folder().string());
    for (const dataset::Part& part : data.examine()) {
      report.add(part.name, part.present, part.found, part.advice);
    }
  } catch (const Error& error) {
    report.add("folder", false, error.what(),
               "set ENFILADE_DATA to a folder with connectivity/ and r2r/, or name it by --data");
  }
}

std::string to_text(const Report& report) {
  std::size_t width = 0;
  for (const Finding& f : report.findings()) width = std::max(width, f.name.size());
  std::string text, section, advice;
  for (const Finding& f : report.findings()) {
    if (f.section != section) text += fmt::format("{}{}\n", section.empty() ? "" : "\n", f.section);
    section = f.section;
    const std::string indent = fmt::format("  {:<{}}  {:<3}  ", "", width, "");
    const std::string lines = CLI::detail::find_and_replace(f.text, "\n", "\n" + indent);
    text += fmt::format("  {:<{}}  {:<3}  {}\n", f.name, width,
                        f.works ? (*f.works ? "yes" : "no") : "", lines);
    if (!f.advice.empty()) advice += fmt::format("  {:<{}}  {}\n", f.name, width, f.advice);
  }
  return advice.empty() ? text : text + "\nwhat to do about what is missing\n" + advice;
}

std::string to_json(const Report& report, bool works) {
  using Json = nlohmann::ordered_json;
  Json json{{"renders", works}};
  for (const Finding& f : report.findings()) {
    Json finding{{"text", f.text}};
    if (f.works) finding["works"] = *f.works;
    if (!f.advice.empty()) finding["advice"] = f.advice;
    json[f.section][f.name] = std::move(finding);
  }
  // Paths and drivers' names need not be UTF-8.
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

struct Arguments {
  std::string data;
  bool json = false;
};

int examine(const Arguments& arguments) {
  Report report;
  examine_machine(report);
  const std::vector<render::GlDevice> devices = render::gl_devices();
  const render::CudaReport cuda = render::cuda_report();
  const bool works = examine_backends(report, devices, cuda);
  examine_gl(report, devices);
  examine_cuda(report, cuda);
  examine_networks(report);
  examine_python(report);
  examine_space(report);
  examine_network(report);
  examine_data(report, arguments.data);
  write_output("-", arguments.json ? to_json(report, works) : to_text(report));
  return works ? kSuccess : kFaultsFound;
}

}  // namespace

void add(CLI::App& app, int& status) {
  CLI::App& verb = *app.add_subcommand(
      "doctor", "Report what this machine supports, and how to add what is missing");
  const auto arguments = std::make_shared<Arguments>();
  add_data_option(verb, arguments->data);
  verb.add_flag("--json", arguments->json, "Print JSON");
  set_examples(verb, {"enfilade doctor", "enfilade doctor --json | jq .rendering"},
               "Exit code 1 if no renderer works.");
  verb.callback([arguments, &status] {
    if (can_learn()) hand_over_to_learn();  // it reports on libtorch too
    status = examine(*arguments);
  });
}

}  // namespace enfilade::apps::doctor_verb
