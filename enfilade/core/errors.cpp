#include "enfilade/core/errors.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/core/utf8.h"

namespace enfilade {
namespace {

constexpr std::size_t kListed = 10;  // an exception's text is read in a terminal

// The last net: readers quote foreign values in short (core/names.h).
std::string shortened(const std::string& text) {
  constexpr std::size_t kMost = 400;
  if (text.size() <= kMost) return text;
  return fmt::format("{}... ({} bytes)", utf8_prefix(text, kMost), text.size());
}

std::string summarise(const std::vector<Diagnostic>& diagnostics) {
  std::string text, more;
  std::size_t errors = 0;
  for (const Diagnostic& diagnostic : diagnostics) {
    if (diagnostic.severity != Severity::kError) continue;
    if (diagnostic.code == kMoreFaults) {
      more += '\n' + to_string(diagnostic);
      continue;
    }
    if (++errors > kListed) continue;
    if (!text.empty()) text += '\n';
    text += to_string(diagnostic);
  }
  if (errors > kListed) text += "\n... and " + std::to_string(errors - kListed) + " more";
  return text + more;
}

}  // namespace

void check_range(std::string_view name, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw ArgumentError(fmt::format("{}: {}, not from {} to {}", name, value, least, most));
}

std::string to_string(Severity severity) {
  constexpr std::array<const char*, 3> kNames{"note", "warning", "error"};
  return kNames.at(static_cast<std::size_t>(severity));
}

std::string to_string(const Diagnostic& diagnostic) {
  std::string text = to_string(diagnostic.severity) + ": " + diagnostic.file;
  if (!diagnostic.where.empty()) text += ": " + shortened(diagnostic.where);
  text += ": " + shortened(diagnostic.message);
  if (!diagnostic.code.empty()) text += " [" + diagnostic.code + "]";
  return text;
}

std::size_t count(const std::vector<Diagnostic>& diagnostics, Severity severity) {
  return static_cast<std::size_t>(std::ranges::count(diagnostics, severity, &Diagnostic::severity));
}

InvalidInput::InvalidInput(std::vector<Diagnostic> diagnostics)
    : Error(summarise(diagnostics)), diagnostics_(std::move(diagnostics)) {}

void refuse(std::string file, std::string where, std::string code, std::string message) {
  throw InvalidInput(
      {{Severity::kError, std::move(file), std::move(where), std::move(code), std::move(message)}});
}

}  // namespace enfilade

namespace enfilade::detail {

void check_failed(const char* file, int line, const char* expression, const std::string& values) {
  std::fprintf(stderr, "%s:%d: Enfilade is broken: %s does not hold%s%s\n", file, line, expression,
               values.empty() ? "" : ": ", values.c_str());
  std::abort();
}

}  // namespace enfilade::detail
