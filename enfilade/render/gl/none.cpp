// Built with EN_WITH_GL=OFF.
#include "enfilade/render/devices.h"

namespace enfilade::render {

std::vector<GlDevice> gl_devices() { return {}; }
void set_gl_trial(std::vector<std::string>) {}
int try_gl(std::span<const std::string>) { return 2; }

}  // namespace enfilade::render
