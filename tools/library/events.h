// What happens in a run, as it happens: JSON objects, one a line, for machines. What a run has written, a later one can
// go on from.
#pragma once

#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "record.h"

namespace vcd {

// spec/library.md lists the events.
class Events {
 public:
  // Empty: nobody listens. "-": standard output. A file is written anew, or gone on with. Error (io).
  static Result<Events> open(const std::string& path, bool go_on);

  void say(Json event);  // with "event" first; flushed, so that who reads along misses nothing
  bool failed() const { return file_ && std::ferror(file_.get()); }  // a full disk, say

 private:
  struct Close {
    void operator()(std::FILE* file) const {
      if (file != stdout) std::fclose(file);
    }
  };
  std::unique_ptr<std::FILE, Close> file_;
};

// Assets that failed in an earlier run, by failure_key(), as its events tell. Lines that were cut off are passed over.
std::map<std::string, Outcome> earlier_failures(const std::string& path);

// Asset, content, settings and baker as one text; empty where the content is not one file's alone, or cannot be read:
// then there is no telling whether it would fail again.
std::string failure_key(const Asset& asset);

}  // namespace vcd
