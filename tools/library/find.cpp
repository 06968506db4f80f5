#include <vcd/library/find.h>

#include <algorithm>
#include <cerrno>
#include <set>
#include <system_error>
#include <utility>

#include <fnmatch.h>
#include <sys/stat.h>

#include "common/paths.h"

namespace vcd::library {
namespace {

using namespace tools;

namespace fs = std::filesystem;
using FileId = std::pair<dev_t, ino_t>;

bool is_pattern(const std::string& text) { return text.find_first_of("*?[") != std::string::npos; }

class Search {
 public:
  explicit Search(const std::vector<std::string>& extensions) : extensions_(extensions) {}

  Found take() { return std::move(found_); }

  void input(const std::string& text) {
    const fs::path path = text;
    struct stat status {};
    if (stat(path.c_str(), &status) == 0) {
      if (!S_ISDIR(status.st_mode)) return add(path, path.filename());
      folders_.clear();  // a folder that is named twice is entered twice: its files are known by then
      const size_t before = found_.files.size() + found_.named_again;
      folder(path, {});
      if (found_.files.size() + found_.named_again == before) found_.empty_folders.push_back(path);
      return;
    }
    const int reason = errno;
    if (text == "-")
      return found_.errors.push_back(
          {ErrorCode::usage, "-: meshes are not read from standard input: a file's name tells its format"});
    if (!is_pattern(text)) return fail(path, reason);
    const size_t before = found_.files.size() + found_.named_again + found_.errors.size();
    const fs::path base = base_of(path);
    auto component = path.begin();
    std::advance(component, std::distance(base.begin(), base.end()));
    match(base, {}, component, path.end());
    if (found_.files.size() + found_.named_again + found_.errors.size() == before)
      found_.errors.push_back({ErrorCode::io, shown(path) + ": no file matches"});
  }

 private:
  // The components before the first with a wildcard.
  static fs::path base_of(const fs::path& pattern) {
    fs::path base;
    for (const fs::path& component : pattern) {
      std::error_code error;
      // A folder may really be named so: then that one is meant.
      if (is_pattern(component.string()) && !std::filesystem::exists(base / component, error)) break;
      base /= component;
    }
    return base;
  }

  void fail(const fs::path& path, int reason) {
    found_.errors.push_back({ErrorCode::io, shown(path) + ": " + std::generic_category().message(reason)});
  }

  void add(const fs::path& path, const fs::path& below) {
    struct stat status {};
    if (has_extension(path, kSidecarExtensions) && !has_extension(path, extensions_))
      return void(++found_.other_files);  // of a shell's pattern, say, when the meshes beside it have been baked
    if (stat(path.c_str(), &status) != 0) return fail(path, errno);
    if (!files_.insert(place_of(path)).second) return void(++found_.named_again);
    found_.files.push_back({path, below});
  }

  // The visible entries in the order of their names; none, and an error, if the folder cannot be read.
  std::vector<fs::path> entries(const fs::path& folder) {
    std::vector<fs::path> names;
    std::error_code error;
    fs::directory_iterator entry(folder.empty() ? fs::path(".") : folder, error);
    for (; !error && entry != fs::directory_iterator(); entry.increment(error))
      if (const fs::path name = entry->path().filename(); name.native()[0] != '.') names.push_back(name);
    if (error) fail(folder.empty() ? fs::path(".") : folder, error.value());
    std::sort(names.begin(), names.end());
    return names;
  }

  bool entered(const fs::path& folder) {
    struct stat status {};
    return stat(folder.c_str(), &status) == 0 && !folders_.insert(FileId{status.st_dev, status.st_ino}).second;
  }

  void folder(const fs::path& path, const fs::path& below) {
    if (entered(path)) return;
    for (const fs::path& name : entries(path)) {
      std::error_code error;
      const auto kind = fs::status(path / name, error).type();
      if (kind == fs::file_type::directory) {
        folder(path / name, below / name);
      } else if (!has_extension(name, extensions_)) {
        ++found_.other_files;
      } else {
        add(path / name, below / name);  // a link to nothing too: it is named like a mesh and is none
      }
    }
  }

  void add_match(const fs::path& path, const fs::path& below) {
    if (has_extension(path, extensions_)) add(path, below);
    else ++found_.other_files;
  }

  void match(const fs::path& path, const fs::path& below, fs::path::iterator component, const fs::path::iterator end) {
    if (component == end) {
      std::error_code error;
      if (!fs::is_directory(path, error)) add_match(path, below);
      return;
    }
    const bool any_depth = *component == "**";
    const auto next = std::next(component);
    if (any_depth) match(path, below, next, end);
    for (const fs::path& name : entries(path)) {
      std::error_code error;
      const bool is_folder = fs::is_directory(path / name, error);
      if (any_depth) {
        // Not through links: patterns have no memory of the folders that they entered.
        if (is_folder && !fs::is_symlink(path / name, error)) match(path / name, below / name, component, end);
        if (!is_folder && next == end) add_match(path / name, below / name);
      } else if (fnmatch(component->c_str(), name.c_str(), FNM_PERIOD) == 0 && (is_folder || next == end)) {
        match(path / name, below / name, next, end);
      }
    }
  }

  const std::vector<std::string>& extensions_;
  Found found_;
  std::set<fs::path> files_;
  std::set<FileId> folders_;
};

}  // namespace

bool has_extension(const fs::path& path, const std::vector<std::string>& extensions) {
  return std::find(extensions.begin(), extensions.end(), extension_of(path)) != extensions.end();
}

fs::path place_of(const fs::path& path) {
  std::error_code error;
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  return fs::weakly_canonical(folder, error) / path.filename();
}

Found find_files(const std::vector<std::string>& inputs, const std::vector<std::string>& extensions) {
  Search search(extensions);
  for (const std::string& input : inputs) search.input(input);
  return search.take();
}

}  // namespace vcd::library
