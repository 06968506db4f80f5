#include "ingest/isolate.h"

#include <sys/mman.h>

#include <cerrno>
#include <cstring>
#include <new>
#include <string>

#include <vcd/baker/child_process.h>

#include "ingest/check.h"
#include "ingest/wire.h"

namespace vcd::baker {
namespace {

constexpr int kCannotSend = 111;  // exit code: any number that is rare elsewhere

// What the child does; its exit code.
int work_and_send(const std::filesystem::path& path, const std::function<Result<Ingested>()>& work, int result_file) {
  bool sent = false;
  try {
    sent = write_result(result_file, work());
  } catch (const std::bad_alloc&) {
    sent = write_result(result_file, file_error(path, ErrorCode::runtime, "out of memory while reading"));
  } catch (const std::exception& error) {
    sent = write_result(result_file,
                        file_error(path, ErrorCode::runtime, std::string("the parser failed: ") + error.what()));
  }
  return sent ? 0 : kCannotSend;
}

Result<Ingested> run(const std::filesystem::path& path, const IngestLimits& limits,
                     const std::function<Result<Ingested>()>& work) {
  const auto fault = [&](const std::string& reason) { return file_error(path, ErrorCode::runtime, reason); };
  const Descriptor result_file(::memfd_create("vcd-ingest", MFD_CLOEXEC));
  if (result_file.get() < 0)
    return fault(std::string("no memory file for the parser's result: ") + std::strerror(errno));
  auto child = ChildProcess::start(limits, [&] { return work_and_send(path, work, result_file.get()); });
  if (!child) return fault(child.error().message);
  child->wait();
  if (child->exit_code() == kCannotSend)
    return fault("the parser's result could not be sent back, perhaps for want of memory" + child->last_words());
  if (const std::string end = child->fault(); !end.empty()) return fault("the parser " + end + child->last_words());
  std::optional<Result<Ingested>> result = read_result(result_file.get());
  if (!result) return fault("the parser ended without a whole result" + child->last_words());
  // The bytes of the file may have had the child in their power: what it says counts no more than the file
  // itself.
  if (result->ok()) {
    if (std::optional<Error> wrong = check_ingested(path, **result)) return *std::move(wrong);
  }
  return *std::move(result);
}

}  // namespace

Result<Ingested> run_isolated(const std::filesystem::path& path, const IngestLimits& limits,
                              const std::function<Result<Ingested>()>& work) try {
  return run(path, limits, work);
} catch (const std::bad_alloc&) {
  return file_error(path, ErrorCode::runtime, "out of memory");
}

Result<Ingested> ingest_isolated(const std::filesystem::path& path, const IngestOptions& options,
                                 const IngestLimits& limits) {
  return run_isolated(path, limits, [&] { return ingest(path, options); });
}

}  // namespace vcd::baker
