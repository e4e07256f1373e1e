/// \file  Command line and output of a process that tries OpenGL.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::render::gl {

/// First word of its command line. Then a device (empty: the first that works, or all), then pairs
/// of a way and its fault: the crashes of earlier processes.
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
