// The files of tools/info/page and of three.js, as they lie in the program (cmake/vcd_embed.cmake).
#pragma once

#include <string_view>

namespace vcd::tools {

extern const std::string_view kPageHtml, kPageCss, kLookUpJs, kPageJs, kSceneJs, kThreeJs, kOrbitControlsJs;

}  // namespace vcd::tools
