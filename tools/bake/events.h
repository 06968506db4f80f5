// What happens in a run, as it happens: JSON objects, one a line, for machines. What a run has written, a later one can
// go on from.
#pragma once

#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include <vcd/library/batch.h>

#include "common/describe.h"

namespace vcd::tools {

// spec/library.md lists the events.
class Events : public library::BatchListener {
 public:
  // Empty: nobody listens. "-": standard output. A file is written anew, or gone on with. Error (io).
  static Result<Events> open(const std::string& path, bool go_on);

  void say(const Json& event);  // with "event" first; flushed, so that who reads along misses nothing
  void started(size_t, size_t) override {}
  void attempt_started(const library::Asset& asset, const library::Grant& grant) override;
  void going_on(const std::vector<Running>&, size_t, double) override {}
  void ended(const library::Asset& asset, const library::Record& record) override;
  bool failed() const { return file_ && std::ferror(file_.get()); }  // a full disk, say

 private:
  struct Close {
    void operator()(std::FILE* file) const {
      if (file != stdout) std::fclose(file);
    }
  };
  std::unique_ptr<std::FILE, Close> file_;
};

// Assets that failed in an earlier run, by library::failure_key(), as its events tell. Lines that were cut off are
// passed over.
std::map<std::string, library::Outcome> earlier_failures(const std::string& path);

}  // namespace vcd::tools
