#include "depfile.h"

#include <span>
#include <string>

#include <vcd/writer/atomic_file.h>

#include "common/paths.h"

namespace vcd::tools {
namespace {

std::string escaped(const std::filesystem::path& path) {
  std::string text;
  for (const char c : path.native()) {
    if (c == ' ' || c == '#' || c == '\\' || c == ':') text += '\\';
    if (c == '$') text += '$';
    text += c;
  }
  return text;
}

}  // namespace

std::optional<Error> write_depfile(const std::filesystem::path& path, const std::filesystem::path& target,
                                   const std::vector<std::filesystem::path>& files) {
  std::string text = escaped(target) + ":";
  for (const std::filesystem::path& file : files) text += " \\\n  " + escaped(file);
  text += "\n";
  // A rule for each but the mesh, so that Make does not want one that is gone and not named any more.
  for (size_t i = 1; i < files.size(); ++i) text += escaped(files[i]) + ":\n";
  for (const std::filesystem::path& file : files)
    if (file.native().find_first_of("\r\n") != std::string::npos)
      return Error{ErrorCode::unsupported, shown(path) + ": a dependency file cannot hold the name " + shown(file)};
  AtomicFile out(path);
  out.append(std::as_bytes(std::span(text)));
  const auto written = out.commit();
  return written ? std::nullopt : std::optional(written.error());
}

}  // namespace vcd::tools
