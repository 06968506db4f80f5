#include "depfile.h"

#include <cctype>
#include <span>
#include <string>

#include <vcd/writer/atomic_file.h>

#include "common/paths.h"

namespace vcd::tools {
namespace {

namespace fs = std::filesystem;

std::string escaped(const fs::path& path) {
  std::string text;
  for (const char c : path.native()) {
    if (c == ' ' || c == '#' || c == '\\' || c == ':') text += '\\';
    if (c == '$') text += '$';
    text += c;
  }
  return text;
}

// Whether Make and Ninja, the older ones too, read the escaped name as it is meant. Not among these: what is a pattern
// for Make, and what parts a name for Ninja before 1.12.
bool is_plain(const fs::path& path) {
  for (const char c : path.native()) {
    const bool is_ascii = static_cast<unsigned char>(c) < 128;
    if (is_ascii && !std::isalnum(static_cast<unsigned char>(c)) &&
        std::string_view("_./+,=@- ").find(c) == std::string_view::npos)
      return false;
  }
  return true;
}

// Links to files whose names a dependency file cannot hold: DEPFILE.links/1, …
class Links {
 public:
  explicit Links(const fs::path& depfile) : folder_(depfile.native() + ".links") {}

  // The name to give a file: its own, or that of a link to it, which has the file's time.
  Result<fs::path> name_of(const fs::path& file) {
    if (is_plain(file)) return file;
    const fs::path link = folder_ / std::to_string(++count_);
    std::error_code error;
    fs::create_directory(folder_, error);
    if (fs::is_symlink(folder_, error)) return Error{ErrorCode::io, shown(folder_) + ": is a link itself"};
    if (fs::is_symlink(link, error)) fs::remove(link, error);
    fs::create_symlink(fs::absolute(file), link, error);
    if (error) return Error{ErrorCode::io, shown(link) + ": cannot be made: " + error.message()};
    return link;
  }

 private:
  fs::path folder_;
  size_t count_ = 0;
};

}  // namespace

std::optional<Error> write_depfile(const fs::path& path, const fs::path& target, const std::vector<fs::path>& files) {
  Links links(path);
  std::vector<fs::path> names;
  for (const fs::path& file : files) {
    auto name = links.name_of(file);
    if (!name) return name.error();
    names.push_back(*std::move(name));
  }
  std::string text = escaped(target) + ":";
  for (const fs::path& name : names) text += " \\\n  " + escaped(name);
  text += "\n";
  // A rule for each but the mesh, so that Make does not want one that is gone and not named any more.
  for (size_t i = 1; i < names.size(); ++i) text += escaped(names[i]) + ":\n";
  AtomicFile out(path);
  out.append(std::as_bytes(std::span(text)));
  const auto written = out.commit();
  return written ? std::nullopt : std::optional(written.error());
}

}  // namespace vcd::tools
