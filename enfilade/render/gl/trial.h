/// \file  OpenGL devices that another process has tried, as a driver may crash or hang; that
/// process, its command line and its output.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/child_process.h"
#include "enfilade/render/devices.h"

namespace enfilade::render::gl {

/// Runs a program as ChildProcess does, without its errors, and waits for its end.
/// \param seconds  limit until each next line that counts \param command  file and arguments
/// \param line  called with each line that it prints; returns whether it counts
ChildEnd run_child(const std::vector<std::string>& command, double seconds,
                   const std::function<bool(std::string_view)>& line);

/// The name of the way that works on this device (empty: on the first that works). No value without
/// a trial process (set_gl_trial()). Each device is tried once; the result is remembered.
/// \throws ArgumentError listing the devices if the name is unknown
/// \throws Error if no context can be made, or if the driver crashed or hung
std::optional<std::string> tried_way(const std::string& device);

/// All devices, tried each time; no value as tried_way().
std::optional<std::vector<GlDevice>> tried_devices();

/// First word of the command line of the process that tries OpenGL. Then a device (empty: the first
/// that works, or all), then pairs of a way and its fault: the crashes of earlier processes.
inline constexpr std::string_view kList = "list", kFind = "find";

/// First word of a line that it prints. After it:
inline constexpr std::string_view kTrying = "trying";      ///< a way, the drivers that are loaded
inline constexpr std::string_view kPlace = "place";        ///< the file whose code crashed
inline constexpr std::string_view kDeviceLine = "device";  ///< the fields of a GlDevice
inline constexpr std::string_view kRefused = "refused";    ///< is it an ArgumentError; its message
inline constexpr std::string_view kFinished = "finished";  ///< nothing: the way tried last works

inline constexpr std::string_view kYes = "yes", kNo = "no";

/// Last words of a message about a driver that crashed or hung.
inline constexpr std::string_view kBrokenAdvice =
    "update or remove that driver, or choose another device; the cpu back end needs no OpenGL";

/// A line of words, line breaks and tabs in them escaped; begins in a new line.
std::string line_of(const std::vector<std::string_view>& words);
/// The words of such a line; none if it is another.
std::vector<std::string> words_of(std::string_view line);

}  // namespace enfilade::render::gl
