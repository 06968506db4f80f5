// A sidecar's provenance: which baker made it, with which settings, of which files. It is part of the sidecar's bytes.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <vcd/baker/demand.h>
#include <vcd/baker/source.h>
#include <vcd/format/contents.h>

#include <vcd/library/assets.h>

namespace vcd::library {

std::string baker_text();  // with kBakeRevision, and no version: the same revision gives the same file

// sources   the files that were read, the mesh file first
// left_out  for each object that lacks parts of its source a line "SOURCE_INDEX not-opaque=N deforming=N"
// demand    for each object that was baked for one a line as demand_line() makes it
std::map<std::string, std::string> provenance_of(const Asset& asset, const std::vector<baker::SourceFile>& sources,
                                                 const std::string& left_out = {}, const std::string& demand = {});

// "SOURCE_INDEX kept-out=N answered=SHARE wrong=N": what came of segments of the demand that were kept out of the bake.
std::string demand_line(uint32_t source_index, const baker::DemandReport& report);

std::string_view provenance_value(const SidecarContents& sidecar, std::string_view key);  // empty where there is none

// The files that the mesh file named when the sidecar was made of it.
std::vector<baker::SourceFile> dependencies_of(const SidecarContents& sidecar);

}  // namespace vcd::library
