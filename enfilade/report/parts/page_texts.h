/// \file  The files of page/, and D3, as the program carries them. Defined by a source that CMake
/// makes (cmake/embed_text.cmake).
#pragma once
#include <string_view>

namespace enfilade::report::parts {

extern const std::string_view kPageHtml;
extern const std::string_view kPageStyle;
extern const std::string_view kPageScript;
extern const std::string_view kD3;         ///< empty in a build without it (EN_WITH_D3)
extern const std::string_view kD3Licence;  ///< goes with every copy of it

}  // namespace enfilade::report::parts
