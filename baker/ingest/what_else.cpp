#include "ingest/what_else.h"

#include <algorithm>
#include <cctype>
#include <string>

#include "ingest/text.h"

namespace vcd::baker {
namespace {

using namespace std::string_view_literals;

struct Kind {
  std::string_view begin;
  const char* what;
};

constexpr Kind kBinary[] = {
    {"version https://git-lfs.github.com/spec/"sv,
     "is a Git LFS pointer, not the file itself (git lfs pull fetches it)"},
    {"version https://hawser.github.com/spec/"sv,
     "is a Git LFS pointer, not the file itself (git lfs pull fetches it)"},
    {"/annex/objects/"sv, "is a git-annex pointer, not the file itself (git annex get fetches it)"},
    {"\x1F\x8B"sv, "is compressed with gzip; unpack it first"},
    {"PK\x03\x04"sv, "is a zip archive; unpack it first"},
    {"\x28\xB5\x2F\xFD"sv, "is compressed with zstd; unpack it first"},
    {"\xFD"
     "7zXZ\0"sv,
     "is compressed with xz; unpack it first"},
    {"BZh"sv, "is compressed with bzip2; unpack it first"},
    {"7z\xBC\xAF\x27\x1C"sv, "is a 7z archive; unpack it first"},
    {"Rar!\x1A\x07"sv, "is a RAR archive; unpack it first"},
};

// In lower case, after a byte order mark and white space.
constexpr Kind kText[] = {
    {"<!doctype html"sv, "is a web page (HTML), not a mesh: perhaps what a server said instead"},
    {"<html"sv, "is a web page (HTML), not a mesh: perhaps what a server said instead"},
    {"<?xml"sv, "is XML, not a mesh: perhaps what a server said instead"},
};

}  // namespace

const char* what_else(std::string_view bytes) {
  for (const Kind& kind : kBinary)
    if (bytes.starts_with(kind.begin)) return kind.what;
  bytes = without_byte_order_mark(bytes);
  bytes.remove_prefix(std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size()));
  std::string begin(bytes.substr(0, 16));
  std::transform(begin.begin(), begin.end(), begin.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const Kind& kind : kText)
    if (begin.starts_with(kind.begin)) return kind.what;
  return nullptr;
}

}  // namespace vcd::baker
