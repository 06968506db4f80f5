#include <vcd/verify/inputs.h>

#include <set>

namespace vcd::verify {

using namespace library;
namespace {

namespace fs = std::filesystem;

Input fault(const std::string& name, ErrorCode code, const std::string& why) {
  Outcome outcome{.subject = Subject::input, .path = name};
  outcome.add(IssueId::no_such_input, code, "", why);
  return {{name, name}, std::move(outcome)};
}

}  // namespace

std::vector<Input> find_inputs(const std::vector<std::string>& names, const std::vector<std::string>& extensions,
                               const std::string& kind) {
  std::vector<Input> inputs;
  std::set<fs::path> places;
  for (const std::string& name : names) {
    Found found = find_files({name}, extensions);
    for (const Error& error : found.errors) inputs.push_back(fault(name, error.code, reason(error, name)));
    if (found.files.empty() && found.errors.empty())
      inputs.push_back(fault(name, ErrorCode::io, "there is no " + kind + " in it"));
    for (FoundFile& file : found.files)
      if (places.insert(place_of(file.path)).second) inputs.push_back({std::move(file), std::nullopt});
  }
  return inputs;
}

}  // namespace vcd::verify
