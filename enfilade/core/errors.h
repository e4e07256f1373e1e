/// \file  Exceptions of Enfilade, and diagnostics for inputs with many faults. The library never
/// prints or exits. It aborts only if its own logic is broken (check.h). See docs/core.md.
#pragma once
#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade {

/// Base of every exception that Enfilade throws for a mistake of a caller or of a file.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A value that a caller passed is outside the allowed range; what() names the parameter, the value
/// and the range.
class ArgumentError : public Error {
 public:
  using Error::Error;
};

/// An invalid action or start of one agent of a simulator. The whole batch is as before the call.
/// what() names agent, value and allowed range.
class ActionError : public ArgumentError {
 public:
  /// \param agent  its place in the batch
  ActionError(std::size_t agent, const std::string& what) : ArgumentError(what), agent_(agent) {}
  std::size_t agent() const noexcept { return agent_; }

 private:
  std::size_t agent_;
};

/// \throws ArgumentError "NAME: VALUE, not from LEAST to MOST" for a value outside, NaN included
void check_range(std::string_view name, double value, double least, double most);

/// An unknown name (scan, viewpoint, split, instruction); what() names the place of the search.
class LookupError : public Error {
 public:
  using Error::Error;
};

/// A file or folder that cannot be opened, read or written; what() begins with its path.
class FileError : public Error {
 public:
  using Error::Error;
};

/// Work stopped from outside, for example by the end of another process. It can be retried
/// unchanged.
class CutShort : public Error {
 public:
  using Error::Error;
};

/// How bad a finding is.
enum class Severity {
  kNote,     ///< information; nothing is wrong
  kWarning,  ///< unusual, but used as it stands in the file
  kError,    ///< cannot be used
};

/// One fault, or unusual value, in an input. Inputs are never repaired silently.
struct Diagnostic {
  Severity severity = Severity::kError;
  std::string file;     ///< path as the caller gave it, or a name such as "<memory>"
  std::string where;    ///< JSON path such as "$[3].trajectory[0][1]"; may hold line and column
  std::string code;     ///< short and stable, for scripts: "long-edge", "unknown-viewpoint"
  std::string message;  ///< the value found and the values allowed
};

/// Errors that are kept per input; as many warnings and notes are kept beside them. Further ones
/// are counted, and a last diagnostic with the code kMoreFaults gives their number: a broken file
/// of 30 MB has millions. A reader may stop at that many errors, and then says so.
inline constexpr std::size_t kMostFaultsKept = 1000;
inline constexpr std::string_view kMoreFaults = "more-faults";

/// "warning: plan.json: $[3].pose: ... [bad-pose]". A long place or message is cut at 400 bytes.
std::string to_string(const Diagnostic& diagnostic);
std::string to_string(Severity severity);
std::size_t count(const std::vector<Diagnostic>& diagnostics, Severity severity);

/// An input whose faults make it unusable: carries all of them (of a file, the first
/// kMostFaultsKept), not just the first.
class InvalidInput : public Error {
 public:
  /// what() lists the errors among `diagnostics`, at most the first ten, and how many more there
  /// are.
  explicit InvalidInput(std::vector<Diagnostic> diagnostics);
  const std::vector<Diagnostic>& diagnostics() const noexcept { return diagnostics_; }

 private:
  std::vector<Diagnostic> diagnostics_;
};
/// \throws InvalidInput with this one error
[[noreturn]] void refuse(std::string file, std::string where, std::string code,
                         std::string message);

}  // namespace enfilade
