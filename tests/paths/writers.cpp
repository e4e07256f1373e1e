#include "tests/paths/writers.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <set>
#include <string>
#include <utility>

#include "enfilade/core/file.h"  // read_file

namespace enfilade::tests {
namespace {

namespace fs = std::filesystem;

/// Functions with a bracket behind them; types and flags.
constexpr std::array kDirect{"ofstream",
                             "fopen(",
                             "O_CREAT",
                             "O_TMPFILE",
                             "O_TRUNC",
                             "std::fstream",
                             "fs::copy(",
                             "filesystem::copy(",
                             "H5Fcreate(",
                             "OPEN_CREATE",
                             "torch::save(",
                             "mkdir(",
                             "create_directory(",
                             "create_directories(",
                             "create_symlink(",
                             "create_directory_symlink(",
                             "create_hard_link(",
                             "copy_file(",
                             "resize_file(",
                             "rename(",
                             "remove(",
                             "remove_all(",
                             "unlink(",
                             "write_file_atomically(",
                             "remove_unfinished(",
                             "PartFile",
                             "FolderLock",
                             "fmt::print("};
/// Ours that write a path which their caller names.
constexpr std::array kNamed{"make_folder(",
                            "write_output(",
                            "write_picture(",
                            "write_safetensors(",
                            "write_state(",
                            "write_home_network(",
                            "write_episodes(",
                            "save_navigation_mesh(",
                            "save_connectivity(",
                            "write_obj(",
                            "write_glb(",
                            "save(",
                            "pack(",
                            "convert_features(",
                            "AppendFile",
                            "EventFile",
                            "Hdf5Writer",
                            "StoreWriter"};
constexpr std::array kPython{
    ".write_text(",   ".write_bytes(", ".mkdir(",       "makedirs(",        "os.replace(",
    ".rename(",       ".unlink(",      "rmtree(",       ".touch(",          "symlink_to(",
    "ParquetWriter(", "write_table(",  "av.open(",      "np.save(",         "torch.save(",
    "os.remove(",     "shutil.copy(",  "shutil.copy2(", "shutil.copyfile(", "shutil.copytree(",
    "shutil.move("};

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// The end of a text in quotes that begins at `at`.
std::size_t end_of_text(std::string_view cpp, std::size_t at) {
  if (at > 0 && cpp[at - 1] == 'R' && cpp[at] == '"') {
    const std::size_t open = cpp.find('(', at);
    const std::string close = fmt::format("){}\"", cpp.substr(at + 1, open - at - 1));
    return std::min(cpp.find(close, open), cpp.size() - close.size()) + close.size();
  }
  for (std::size_t i = at + 1; i < cpp.size(); ++i) {
    if (cpp[i] == '\\') {
      ++i;
    } else if (cpp[i] == cpp[at] || cpp[i] == '\n') {
      return i + 1;
    }
  }
  return cpp.size();
}

/// What is between the bracket at `open` and the one that closes it.
std::string_view arguments_at(std::string_view text, std::size_t open) {
  int depth = 0;
  for (std::size_t i = open; i < text.size(); ++i) {
    if (text[i] == '(' || text[i] == '{') ++depth;
    if ((text[i] == ')' || text[i] == '}') && --depth == 0) {
      return text.substr(open + 1, i - open - 1);
    }
  }
  return text.substr(open + 1);
}

std::string_view first_argument(std::string_view arguments) {
  int depth = 0;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const char c = arguments[i];
    if (c == '(' || c == '{' || c == '[') ++depth;
    if (c == ')' || c == '}' || c == ']') --depth;
    if (c == ',' && depth == 0) return arguments.substr(0, i);
  }
  return arguments;
}

/// Whether `path / name` stands in it, with a name that is not in quotes.
bool joins_a_name(std::string_view argument) {
  for (std::size_t at = 0; (at = argument.find('/', at)) != std::string_view::npos; ++at) {
    const std::size_t next = argument.find_first_not_of(" \n(", at + 1);
    if (next != std::string_view::npos && argument[next] != '"') return true;
  }
  return false;
}

/// Whether OutputFolder gives a path in it. Its functions have an argument, unlike
/// Dataset::folder().
bool is_of_output_folder(std::string_view arguments) {
  for (const std::string_view function : {".file(", ".folder("}) {
    for (std::size_t at = 0; (at = arguments.find(function, at)) != std::string_view::npos;) {
      at += function.size();
      const std::size_t next = arguments.find_first_not_of(" \n", at);
      if (next != std::string_view::npos && arguments[next] != ')') return true;
    }
  }
  return false;
}

/// Goes through one file.
class FileChecker {
 public:
  FileChecker(const SourceFile& file, bool has_row, std::vector<Diagnostic>& found)
      : file_(file), has_row_(has_row), found_(found) {}

  /// \returns whether the file writes directly
  bool check() {
    file_.path.ends_with(".py") ? check_python() : check_cpp();
    return writes_;
  }

 private:
  void report(std::size_t line, const char* code, std::string message) {
    found_.push_back(
        {Severity::kError, file_.path, fmt::format("line {}", line), code, std::move(message)});
  }

  void write_directly(std::string_view function, std::size_t line) {
    writes_ = true;
    if (has_row_) return;
    report(line, "writes-directly",
           fmt::format("{}: use OutputFolder (say() for prints), or add a row with the reason to "
                       "tests/paths/writers_rows.cpp",
                       function));
  }

  void check_cpp() {
    text_ = without_texts(file_.text);
    for (const std::string_view name : kDirect) check_uses(name, true);
    for (const std::string_view name : kNamed) check_uses(name, false);
    check_roots();
  }

  std::size_t line_of(std::size_t at) const {
    return 1 + static_cast<std::size_t>(
                   std::ranges::count(std::string_view(text_).substr(0, at), '\n'));
  }

  /// OutputFolder follows a link at its root. A file's folder may be one that another user made.
  void check_roots() {
    constexpr std::string_view kType = "OutputFolder";
    for (std::size_t at = 0; (at = text_.find(kType, at)) != std::string::npos;) {
      const std::size_t begin = at;
      at += kType.size();
      if (!is_use(begin, kType)) continue;
      std::size_t open = at;
      while (open < text_.size() && (is_word(text_[open]) || text_[open] == ' ')) ++open;
      if (open >= text_.size() || (text_[open] != '(' && text_[open] != '{')) continue;
      if (arguments_at(text_, open).find("parent_path(") != std::string_view::npos) {
        write_directly("OutputFolder of a parent_path()", line_of(begin));
      }
    }
  }

  void check_uses(std::string_view name, bool direct) {
    if (name == "fmt::print(" && !file_.path.starts_with("apps/enfilade/")) return;
    for (std::size_t at = 0; (at = text_.find(name, at)) != std::string::npos; at += name.size()) {
      if (!is_use(at, name)) continue;
      const std::size_t line = line_of(at);
      const std::size_t open = text_.find_first_of("({;", at + name.size() - 1);
      const std::string_view arguments =
          open == std::string::npos || text_[open] == ';' ? "" : arguments_at(text_, open);
      if (is_of_output_folder(arguments)) continue;
      if (name != "fmt::print(" && joins_a_name(first_argument(arguments))) {
        report(line, "joined-path",
               fmt::format("{} {}: a computed name, for OutputFolder", name,
                           first_argument(arguments)));
      } else if (direct) {
        write_directly(name, line);
      }
    }
  }

  /// Whether a name found at `at` is called or made there: no part of a longer one, no member of
  /// OutputFolder, not declared.
  bool is_use(std::size_t at, std::string_view name) const {
    const std::string_view text = text_;
    if (at > 0 && is_word(text[at - 1])) return false;
    const std::size_t end = at + name.size();
    if (name.back() != '(') return end >= text.size() || !(is_word(text[end]) || text[end] == ':');
    const std::string_view before = text.substr(0, at);
    const bool is_member = before.ends_with('.') || before.ends_with("->");
    if (name == "save(") return is_member || before.ends_with("image::");
    if (is_member) return false;
    // A definition has a type before it; a call has an operator, a bracket, or one of these words.
    std::string_view rest = before;
    while (!rest.empty() && (is_word(rest.back()) || rest.back() == ':')) rest.remove_suffix(1);
    while (!rest.empty() && std::isspace(static_cast<unsigned char>(rest.back())) != 0) {
      rest.remove_suffix(1);
    }
    if (rest.empty()) return true;
    return !(is_word(rest.back()) || rest.ends_with('&') || rest.ends_with('*') ||
             rest.ends_with('>')) ||
           rest.ends_with("return") || rest.ends_with("else") || rest.ends_with("&&");
  }

  void check_python() {
    std::size_t line = 0;
    for (std::string_view rest = file_.text; !rest.empty();) {
      ++line;
      const std::size_t end = std::min(rest.find('\n'), rest.size());
      const std::string_view text = rest.substr(0, std::min(rest.find('#'), end));
      for (const std::string_view name : kPython) {
        if (text.find(name) != std::string_view::npos) write_directly(name, line);
      }
      if (opens_to_write(text)) write_directly("open(", line);
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }

  static bool opens_to_write(std::string_view line) {
    const std::size_t at = line.find("open(");
    return at != std::string_view::npos &&
           std::ranges::any_of(
               std::array{"\"w", "\"a\"", "\"ab", "\"x", "'w", "'a'", "'ab", "'x"},
               [&](const char* mode) { return line.find(mode, at) != std::string_view::npos; });
  }

  const SourceFile& file_;
  bool has_row_;
  std::vector<Diagnostic>& found_;
  std::string text_;
  bool writes_ = false;
};

}  // namespace

std::string without_texts(std::string_view cpp) {
  std::string result;
  for (std::size_t i = 0; i < cpp.size();) {
    const std::string_view two = cpp.substr(i, 2);
    std::size_t end = i + 1;
    std::string_view kept = cpp.substr(i, 1);
    if (two == "//") {
      end = std::min(cpp.find('\n', i), cpp.size());
      kept = "";
    } else if (two == "/*") {
      end = std::min(cpp.find("*/", i), cpp.size() - 2) + 2;
      kept = "";
    } else if (cpp[i] == '"') {
      end = end_of_text(cpp, i);
      kept = "\"\"";
    } else if (cpp[i] == '\'' && (i == 0 || !is_word(cpp[i - 1]))) {  // not of 10'000
      end = end_of_text(cpp, i);
      kept = "' '";
    }
    result += kept;
    if (end > i + 1) {
      result.append(static_cast<std::size_t>(std::ranges::count(cpp.substr(i, end - i), '\n')),
                    '\n');
    }
    i = end;
  }
  return result;
}

std::vector<Diagnostic> check_writers(const std::vector<SourceFile>& files,
                                      const std::vector<DirectWriter>& rows) {
  std::set<std::string_view> unused;
  for (const DirectWriter& row : rows) unused.insert(row.path);
  const std::set<std::string_view> known = unused;
  std::vector<Diagnostic> found;
  for (const SourceFile& file : files) {
    if (FileChecker(file, known.contains(file.path), found).check()) unused.erase(file.path);
  }
  for (const std::string_view path : unused) {
    found.push_back({Severity::kError, std::string(path), "", "stale-row", "writes no file"});
  }
  return found;
}

std::vector<SourceFile> read_writers(const fs::path& root) {
  std::vector<SourceFile> files;
  for (const char* part : {"enfilade", "apps", "python/src", "python/enfilade"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / part)) {
      const fs::path& path = entry.path();
      const std::string name = path.lexically_relative(root).generic_string();
      const bool read = path.extension() == ".h" || path.extension() == ".cpp" ||
                        path.extension() == ".cu" || path.extension() == ".py";
      if (!read || name.ends_with("_test.cpp") || name.starts_with("enfilade/core/") ||
          name.starts_with("apps/evalai/")) {  // a worker of EvalAI's own machine
        continue;
      }
      files.push_back({name, read_file(path)});
    }
  }
  std::ranges::sort(files, {}, &SourceFile::path);
  return files;
}

}  // namespace enfilade::tests
