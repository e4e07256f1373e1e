/// \file  The HTML page around the data.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace enfilade::report::parts {

/// One HTML document with style, scripts and data in it. Its content security policy lets nothing
/// be loaded, and no script run but ours, whatever stands in the data.
/// \throws Error if this build has no D3
std::string make_page(std::string_view title, const nlohmann::ordered_json& data);

/// JSON that may stand inside <script>: no '<' in it; ASCII; broken UTF-8 replaced.
std::string script_json(const nlohmann::ordered_json& data);

/// The files of page/, and D3, as the program carries them. Defined by a source that CMake makes
/// (cmake/embed_text.cmake).
extern const std::string_view kPageHtml;
extern const std::string_view kPageStyle;
extern const std::string_view kPageScript;
extern const std::string_view kD3;         ///< empty in a build without it (EN_WITH_D3)
extern const std::string_view kD3Licence;  ///< goes with every copy of it

}  // namespace enfilade::report::parts
