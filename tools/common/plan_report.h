// The forecasts of a plan as text and JSON.
#pragma once

#include <vcd/baker/plan.h>

#include "describe.h"

namespace vcd::tools {

Json describe_plan(const baker::Plan& plan);
void print_plan(const baker::Plan& plan);  // a table on standard output

}  // namespace vcd::tools
