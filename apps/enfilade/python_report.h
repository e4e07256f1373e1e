/// \file  Which `habitat_sim` a Python imports, for `enfilade doctor`.
#pragma once
#include <string>

namespace enfilade::apps {

/// What a Python told of itself and of `habitat_sim`.
struct PythonReport {
  /// Whose module is imported.
  enum class Module { kNone, kOurs, kHabitats, kBroken };

  std::string program;  ///< the Python, as it was started
  std::string error;    ///< why it told nothing; empty if it did. All below is then empty
  std::string version;  ///< of Python
  Module module = Module::kNone;
  std::string path;            ///< of the module; empty for none
  std::string module_version;  ///< `habitat_sim.__version__`; empty for none, or a broken one
  std::string fault;           ///< why a broken one cannot be imported
};

/// The Python beside this program, as in a virtual environment, or else the first python3 on PATH.
std::string python_of_this_machine();

/// Starts a Python that imports `habitat_sim`. Whatever it does, nothing is thrown. It is killed
/// when it has not ended in time. \param program  a path, or a name on PATH
/// \param seconds  the time
PythonReport report_of_python(const std::string& program, double seconds = 30);

}  // namespace enfilade::apps
