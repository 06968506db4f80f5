// --method and --samples, the same in every program that bakes.
#pragma once

#include <CLI/CLI.hpp>

#include <vcd/baker/bake.h>

namespace vcd {

// --samples without --method means sampled.
inline void add_method_options(CLI::App& app, baker::BakeOptions& bake) {
  const std::map<std::string, Method> kMethods = {
      {"proven", Method::proven}, {"hybrid", Method::hybrid}, {"sampled", Method::sampled}};
  CLI::Option* const method =
      app.add_option(
             "-m,--method", bake.method,
             "proven: clear and blocked are proofs; hybrid: and a statistical tier at the deepest level, kept apart\n"
             "(default); sampled: the paper's, statistics alone")
          ->transform(CLI::CheckedTransformer(kMethods, CLI::ignore_case).description(""))
          ->type_name("proven|hybrid|sampled");
  app.add_option("-s,--samples", bake.samples,
                 "Rays a cell (default: 256); with --method hybrid: those of its statistical tier, 81 or 256\n"
                 "(default: 256, or 81 where proofs of blocked hardly ever succeed, as in foliage). Without --method\n"
                 "this means sampled")
      ->check(CLI::IsMember({16, 81, 256}).description(""))
      ->type_name("16|81|256")
      ->each([method, &bake](const std::string&) {
        if (method->count() == 0) bake.method = Method::sampled;
      });
}

}  // namespace vcd
