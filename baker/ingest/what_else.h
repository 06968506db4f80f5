// Files that are no mesh at all, whatever their name: what a repository or a server gives in place of one.
#pragma once

#include <string_view>

namespace vcd::baker {

// What the bytes are, as the end of a message, if they are a pointer of Git LFS or git-annex, a web page or an archive;
// else null. Looks at the first bytes only.
const char* what_else(std::string_view bytes);

}  // namespace vcd::baker
