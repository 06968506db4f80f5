// An object's answers, held against exact arithmetic.
#pragma once

#include <vcd/baker/prepare.h>
#include <vcd/format/contents.h>
#include <vcd/runtime/sidecar.h>

#include <vcd/verify/check.h>

namespace vcd::verify {

// One object as the runtime answers for it.
struct Answering {
  Object all, proven;  // the second trusts proofs alone
};

// Audits it, or asks and traces the one segment. check: what came of it. Throws Interrupted.
void check_answers(const Answering& answering, const baker::PreparedMesh& mesh, const std::string& place,
                   const CheckOptions& options, Outcome& outcome, ObjectCheck& check);

// Asks the horizons of an object, which it must have. Throws Interrupted.
void check_horizons(const ObjectContents& object, const baker::PreparedMesh& mesh, const std::string& place,
                    const CheckOptions& options, Outcome& outcome);

}  // namespace vcd::verify
