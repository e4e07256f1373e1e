/// \file  Mesa's drivers beside other libraries that carry LLVM.
#pragma once

namespace enfilade::render::gl {

/// If the program is linked to a copy of LLVM, loads Mesa so that it finds its own copy first.
///
/// Debian 13's libtorch 2.6 contains a copy of LLVM 19 and exports 200 of its functions, without a
/// version. In a program linked to it, llvmpipe then registers the processor with libtorch's copy,
/// requests it from its own copy, gets nothing and crashes. To be called before anything else loads
/// EGL; does nothing at a second call. (Known elsewhere, too: github.com/pytorch/pytorch issues
/// 87642 and 96060.)
void keep_mesa_to_its_llvm();

}  // namespace enfilade::render::gl
