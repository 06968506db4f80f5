// Runs something once with each variant of the kernels that this processor has.
#pragma once

#include <hwy/targets.h>

namespace vcd::test {

template <class Function>
void with_every_target(const Function& function) {
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    function(hwy::TargetName(target));
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace vcd::test
