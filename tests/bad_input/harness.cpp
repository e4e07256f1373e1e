#include "tests/bad_input/harness.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "enfilade/core/file.h"
#include "enfilade/tasks/annotations.h"
#include "tests/support/graphs.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::bad_input {
namespace {

namespace fs = std::filesystem;

// Six viewpoints in a row, 2 m apart, the last excluded.
scan::Connectivity row(const std::string& scan) {
  scan::Connectivity c = graph::testing::connectivity(
      scan, {{0, 0, 1.5}, {2, 0, 1.5}, {4, 0, 1.5}, {6, 0, 1.5}, {8, 0, 1.5}, {10, 0, 1.5}},
      {{0, 1}, {1, 2}, {2, 3}, {3, 4}});
  c.entries[5].included = false;
  return c;
}

std::string annotations(bool hidden) {
  tasks::Annotations a;
  for (std::int64_t id = 1; id <= 2; ++id) {
    tasks::PathAnnotation path;
    path.path_id = id;
    path.scan = "one";
    path.heading = Radians(1.5);
    path.path = {"v0", "v1", "v2", "v3", "v4"};
    path.distance = 8;
    path.instructions = {"Walk on.", "Go on and on.", "Straight on."};
    if (id == 2) path.instructions.emplace_back("A fourth one.");
    if (hidden) {
      path.path.resize(1);
      path.distance.reset();
    }
    a.paths.push_back(std::move(path));
  }
  return to_json(a);
}

std::string results() {
  std::string text = "[";
  for (const char* id : {"1_0", "1_1", "1_2", "2_0", "2_1", "2_2"}) {
    text += fmt::format(
        "{}{{\"instr_id\": \"{}\", \"trajectory\": [[\"v0\", 1.5, 0], "
        "[\"v1\", 1.5, 0], [\"v2\", 1.5, 0]]}}",
        text.size() > 1 ? ",\n " : "", id);
  }
  return text + "]\n";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos;
       at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

// What it prints goes to `output`.
Outcome run_program(const std::string& command, const fs::path& folder, const fs::path& output) {
  const std::string line = fmt::format("cd {} && exec env -u ENFILADE_DATA {} {}", folder.string(),
                                       EN_PROGRAM, replaced(command, "{}", folder.string()));
  tests::Process process({"/bin/sh", "-c", line + " 2>&1"}, output);
  const int status = process.wait();
  return {status < 0 ? 128 - status : status, replaced(read_file(output), folder.string(), "{}"),
          process.most_memory(), process.work()};
}

// A cell of a Markdown table.
std::string cell(const std::string& text) { return replaced(text, "|", "\\|"); }

}  // namespace

Files::Files()
    : files_{{kScans, "one\ntwo\n"},
             {kGraph, to_json(row("one"))},
             {"connectivity/two_connectivity.json", to_json(row("two"))},
             {kAnnotations, annotations(false)},
             {"r2r/R2R_hidden.json", annotations(true)},
             {kRegions, R"({"one": {"0": ["v0", "v1"], "1": ["v2", "v3", "v4"]}})"},
             {kResults, results()}} {}

std::string& Files::find(const std::string& file) {
  for (auto& [name, content] : files_) {
    if (name == file) return content;
  }
  throw std::logic_error("no file " + file);
}

const std::string& Files::content(const std::string& file) const {
  return const_cast<Files*>(this)->find(file);  // NOLINT: shares one search
}

Files& Files::edit(const std::string& file, const std::string& from, const std::string& to) {
  std::string& content = find(file);
  const std::size_t at = content.find(from);
  if (at == std::string::npos) throw std::logic_error("no " + from + " in " + file);
  content.replace(at, from.size(), to);
  return *this;
}

Files& Files::write(const std::string& file, const std::string& content) {
  remove(file);
  files_.emplace_back(file, content);
  return *this;
}

Files& Files::append(const std::string& file, const std::string& content) {
  find(file) += content;
  return *this;
}

Files& Files::remove(const std::string& file) {
  std::erase_if(files_, [&](const auto& one) { return one.first == file; });
  return *this;
}

std::vector<Case> all_cases() {
  std::vector<Case> all;
  for (const auto& group : {graph_cases(), mesh_cases(), annotation_cases(), result_cases(),
                            task_cases(), free_walk_cases(), arena_cases(), command_line_cases(),
                            home_cases(), import_cases(), render_cases(), weight_cases()}) {
    all.insert(all.end(), group.begin(), group.end());
  }
  return all;
}

std::string utf16(std::string_view ascii) {
  std::string text = "\xFF\xFE";
  for (const char c : ascii) (text += c) += '\0';
  return text;
}

std::string glb_of_hm3d() {
  std::string json =
      R"({"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 6}]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}],
"bufferViews": [{"buffer": 0, "byteLength": 48}], "buffers": [{"byteLength": 48,
"uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAQAAAAAAAAAAAAACAQAAAgEAAAAAAAAAAAAAAgEAAAAAA"}]})";
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const auto number = [](std::size_t value) {
    return std::string{static_cast<char>(value % 256), static_cast<char>(value / 256), '\0', '\0'};
  };
  return "glTF" + number(2) + number(json.size() + 20) + number(json.size()) + "JSON" + json;
}

Outcome run(const Case& one) {
  const tests::TemporaryFolder made("bad_input");
  const fs::path& folder = made.path();
  Files files;
  if (one.damage) one.damage(files);
  for (const auto& [name, content] : files.all()) {
    fs::create_directories((folder / name).parent_path());
    if (content == kPipe) {
      ::mkfifo((folder / name).c_str(), 0600);
    } else {
      write_file_atomically(folder / name, content);
    }
  }
  const fs::path output = folder / "output.txt";
  if (!one.first.empty()) {
    const Outcome before = run_program(one.first, folder, output);
    if (before.exit_code != 0) {
      throw std::logic_error(one.first + " before " + one.command + ": " + before.output);
    }
  }
  return run_program(one.command, folder, output);
}

std::string docs_page() {
  std::string page =
      "# Bad input\n\n"
      "What each malformed input gets. Every row is a test (`tests/bad_input/`), run against the "
      "real program; this page is written by it (`bad_input_test --write-docs`). `{}` stands for "
      "the data set's folder. Exit codes: 0 done, 1 faults found in what was checked, 2 command "
      "line, 3 files.\n\n"
      "Inputs are never repaired in silence: an odd graph is walked as its file says, and "
      "`enfilade graph check` reports what is odd; an unusable one is refused with its faults, up "
      "to 1,000 of them, and their JSON paths.\n";
  std::string group;
  for (const Case& one : all_cases()) {
    if (one.group != group) {
      group = one.group;
      page += fmt::format(
          "\n## {}\n\n| input | `enfilade ...` | exit | says |\n|---|---|---|---|\n", group);
    }
    const std::string before = one.first.empty() ? "" : fmt::format("`{}`, then ", one.first);
    page += fmt::format("| {} | {}`{}` | {} | `{}` |\n", cell(one.input), cell(before),
                        cell(one.command), one.exit_code, cell(one.says));
  }
  return page;
}

}  // namespace enfilade::bad_input
