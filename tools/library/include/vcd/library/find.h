// Inputs as users name them → files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <vcd/baker/ingest.h>
#include <vcd/format/error.h>

namespace vcd::library {

struct FoundFile {
  std::filesystem::path path;  // as named, or below the folder as named
  // Relative to the folder that was searched; the file's name where the file was named itself.
  std::filesystem::path below;
};

struct Found {
  std::vector<FoundFile> files;  // each path once, however often it was named; folders in the order of names
  std::vector<Error> errors;     // what was named and is not there, cannot be read, or matches nothing; code io
  std::vector<std::filesystem::path> empty_folders;  // that were named and have no such file
  size_t other_files = 0;                            // passed over for their extension
  size_t named_again = 0;                            // found a second time, by another input
};

// Finds the files that `inputs` name: a file (whatever its extension, but for that of sidecars where meshes are looked
// for), a folder (everything below it with one of the `extensions`, without their dots and in any case), or a pattern
// where no such file exists, for files with these extensions: * ? [ ] within a component, ** for any number of folders.
//
// Links are followed; each folder is entered once, so a loop of links ends, and a file in it has one path. A link to a
// file is a file of its own. Names that begin with a dot are passed over below folders and by patterns. Names may hold
// any bytes.
Found find_files(const std::vector<std::string>& inputs, const std::vector<std::string>& extensions);

// Where a path leads to, links in its folders followed: the same for two paths to one entry of a folder.
std::filesystem::path place_of(const std::filesystem::path& path);

bool has_extension(const std::filesystem::path& path, const std::vector<std::string>& extensions);  // likewise

inline const std::vector<std::string> kSidecarExtensions = {"vcd"};  // of meshes: mesh_extensions()

// For what is written beside them: by its name the path is neither a mesh nor a sidecar, which a slip of the hand would
// replace.
inline bool may_be_written(const std::filesystem::path& path) {
  return !has_extension(path, baker::mesh_extensions()) && !has_extension(path, kSidecarExtensions);
}

}  // namespace vcd::library
