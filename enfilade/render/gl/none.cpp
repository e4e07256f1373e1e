// Built with EN_WITH_GL=OFF.
#include "enfilade/render/gl_devices.h"

namespace enfilade::render {

std::vector<GlDevice> gl_devices() { return {}; }

}  // namespace enfilade::render
