// check_agents: compares recorded passes, rollouts and training of published agents with ours.
#include <fmt/format.h>
#include <algorithm>
#include <set>
#include <string>

#include "apps/common/program.h"
#include "enfilade/core/errors.h"
#include "tests/conformance/agents_golden.h"
#include "tests/conformance/data_beside.h"

namespace enfilade::tests {
namespace {

using namespace apps;

bool is_recording(const std::string& name) {
  return name.starts_with("duet_") || name.starts_with("envdrop");
}

std::string stem_of(const std::string& name) { return name.substr(0, name.find('.')); }

ExitCode report(const AgentsFolder& folder, const AgentsTally& tally) {
  std::size_t values = 0, mismatches = 0;
  std::set<std::string> checked;
  for (const AgentsTally::File& file : tally.files()) {
    for (const std::string& line : file.examples) fmt::print("{}: {}\n", file.name, line);
    fmt::print("{}: {} values, {} mismatches\n", file.name, file.values, file.mismatches);
    checked.insert(file.name);
    values += file.values;
    mismatches += file.mismatches;
  }
  for (const std::string& name : folder.names()) {
    // "duet_units.json" belongs to "duet_units.npz": files of one stem are read together.
    const auto same = [&](const std::string& other) { return stem_of(other) == stem_of(name); };
    if (is_recording(name) && std::ranges::none_of(checked, same)) {
      fmt::print("{}: not checked\n", name);
    }
  }
  fmt::print("{} values, {} mismatches\n", values, mismatches);
  return mismatches > 0 ? kFaultsFound : kSuccess;
}

ExitCode check(const std::string& path, const std::string& data, const std::string& device) {
  if (!std::filesystem::is_directory(path)) throw FileError(path + ": is no folder");
  const auto files = std::filesystem::directory_iterator(path);
  const bool any = std::any_of(begin(files), end(files), [](const auto& entry) {
    return is_recording(entry.path().filename().string());
  });
  if (!any) {
    throw UsageError(path + ": has no recording of an agent (duet_*, envdrop*)");
  }
  // The data lie beside the folder's parent.
  const auto parent = std::filesystem::absolute(std::filesystem::path(path) / "x").parent_path();
  const AgentsFolder folder(path, open_data_beside(data, parent), device);
  AgentsTally tally;
  check_duet(folder, tally);
  check_envdrop(folder, tally);
  return report(folder, tally);
}

}  // namespace
}  // namespace enfilade::tests

int main(int argc, char** argv) {
  using namespace enfilade::tests;
  CLI::App app("Compares recorded passes, rollouts and training of published agents with ours.",
               "check_agents");
  std::string folder, data, device = "cpu";
  int status = kSuccess;
  app.add_option("folder", folder, "A folder with recordings: duet_*, envdrop*")
      ->required()
      ->type_name("DIR");
  app.add_option("--data", data,
                 "Data set: a folder with connectivity/ (default: ENFILADE_DATA, else data/ "
                 "beside the folder's parent)")
      ->type_name("DIR");
  app.add_option("--device", device, "Where networks compute: cpu, cuda or cuda:N")
      ->capture_default_str();
  app.footer(
      "Exit codes: 0 all agree, 1 mismatches, 2 command line or nothing to check, 3 a file that "
      "cannot be used.");
  app.callback([&] { status = check(folder, data, device); });
  return run_program(app, argc, argv, status);
}
