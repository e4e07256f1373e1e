/// \file  The templates of prompts/, which the build puts into the library.
#pragma once
#include <string_view>

namespace enfilade::arena::detail {
extern const std::string_view kTextPrompt, kMarksPrompt, kNavgptPrompt, kMapgptPrompt;
}
